//! Where a scan was taken from, by the planes that it shares with what is known.
//!
//! Planes of the scan are matched to known ones by the pose that is given. Of the matched pairs
//! (n, p, Σ) ↔ (m, q, T) the most likely turn ω and shift t of the scan are sought,
//!
//!   min Σ dᵀ S⁻¹ d + (ω, t)ᵀ P⁻¹ (ω, t),   d(ω, t) = (θ_x, θ_y, z),   S = Σ + T,
//!
//! P what is known of the pose that is given, by Gauss and Newton. So each direction of the pose is
//! corrected as far as planes determine it, and what they leave open stays as it was given, with the
//! covariance that it had. No points are matched, nothing iterates over nearest neighbours.

mod matching;
mod pose;
mod solve;

use nalgebra::{Isometry3, Matrix6, Point3, Vector3};
use pose::Pose;
use serde::{Deserialize, Serialize};
use solve::Solved;
use surfaces::{Face, FaceId};

use crate::Error;
use crate::error::within;

/// Whether scans are registered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RegistrationConfig {
    /// Whether the poses of all scans but the first are refined.
    pub refine: bool,
    /// Standard deviation of a position that is given along each axis, m.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub position_sigma_m: f64,
    /// Standard deviation of a direction that is given about each axis, rad.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub direction_sigma_rad: f64,
}

impl Default for RegistrationConfig {
    fn default() -> Self {
        Self {
            refine: false,
            position_sigma_m: 0.03,
            direction_sigma_rad: 1.5_f64.to_radians(),
        }
    }
}

impl RegistrationConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        let (m, rad) = ("must be a length above 0", "must be an angle above 0");
        let shift = "registration.position_sigma_m";
        within(shift, self.position_sigma_m, 1e-6, 1e3, m)?;
        let turn = "registration.direction_sigma_rad";
        within(turn, self.direction_sigma_rad, 1e-6, 1e3, rad)
    }
}

/// Times that planes are matched anew after the pose has moved.
const ROUNDS: usize = 3;

/// How a scan has to be moved, and how well that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// The motion, in W: what the scan showed at x is at `X_W` x.
    pub X_W: Isometry3<f64>,
    /// Covariance of (turn, shift) of that motion in W about `about_W`: rad, m.
    pub covariance: Matrix6<f64>,
    /// The point that the turn is about, m.
    pub about_W: Point3<f64>,
    /// Pairs of (known, scanned) faces that were used, by id.
    pub pairs: Vec<(FaceId, FaceId)>,
    /// dᵀS⁻¹d over the degrees of freedom that are left: about 1 where covariances are right.
    pub misfit: f64,
    /// What the planes leave open, in words: it stays as it was given.
    pub open: Vec<String>,
    /// Root mean square distance between matched planes, before and after, m.
    pub offset_rms_m: (f64, f64),
}

/// Registers the faces of a scan that was taken from `eye_W` (both in W by the pose that is given) with known
/// ones. Where none is a known one all stays as it was given, and as uncertain.
///
/// # Errors
/// [`Error::Config`].
pub fn register(
    known: &[Face],
    scanned: &[Face],
    eye_W: &Point3<f64>,
    config: &RegistrationConfig,
) -> Result<Registration, Error> {
    config.check()?;
    // Turns are about the middle of what the scan shows; those of the pose given are about the sensor.
    let places = scanned.iter().map(|face| face.X_WF.translation.vector);
    let middle = places.sum::<Vector3<f64>>() / scanned.len().max(1) as f64;
    let mut pose = Pose::given(eye_W, middle.into(), config);
    let mut solved = Solved {
        X_W: Isometry3::identity(),
        covariance: pose.given,
        misfit: 0.0,
    };
    let (mut pairs, mut before) = (Vec::new(), 0.0);
    for round in 0..ROUNDS {
        pairs = matching::pairs(known, scanned, &pose);
        if round == 0 {
            before = solve::offset_rms_m(&pairs, &Isometry3::identity());
        }
        let Some(next) = solve::solve(&pairs, &pose) else {
            break;
        };
        pose.X_W = next.X_W * pose.X_W;
        solved = next;
    }
    let names = |pair: &matching::Pair| {
        let (a, b) = (&known[pair.known].id, &scanned[pair.scanned].id);
        (a.clone(), b.clone())
    };
    Ok(Registration {
        X_W: pose.X_W,
        about_W: pose.about_W,
        misfit: solved.misfit,
        open: solve::open(&solved.covariance, config),
        offset_rms_m: (before, solve::offset_rms_m(&pairs, &solved.X_W)),
        covariance: solved.covariance,
        pairs: pairs.iter().map(names).collect(),
    })
}

#[cfg(test)]
mod tests;
