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
#![allow(non_snake_case)]

mod matching;
mod solve;

use nalgebra::{Isometry3, Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};
use solve::Pose;
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
/// After the first round, pairs that disagree by more standard deviations than this are left out.
const GATE_SIGMAS: f64 = 4.5;

/// How a scan has to be moved, and how well that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// The motion, in W: what the scan showed at x is at `X_W` x.
    pub X_W: Isometry3<f64>,
    /// Covariance of (turn, shift) of that motion in W about `about_W`: rad, m.
    pub covariance: Matrix6<f64>,
    /// The point that the turn is about, m.
    pub about_W: nalgebra::Point3<f64>,
    /// Pairs of (known, scanned) faces that were used, by id.
    pub pairs: Vec<(FaceId, FaceId)>,
    /// dᵀS⁻¹d over the degrees of freedom that are left: about 1 where covariances are right.
    pub misfit: f64,
    /// What the planes leave open, in words: it stays as it was given.
    pub open: Vec<String>,
    /// Root mean square distance between matched planes, before and after, m.
    pub offset_rms_m: (f64, f64),
}

/// Registers the faces of a scan (in W by the pose that is given) with known ones.
///
/// # Errors
/// [`Error::Config`]; [`Error::FewPlanes`] where no face is a known one.
pub fn register(
    known: &[Face],
    scanned: &[Face],
    config: &RegistrationConfig,
) -> Result<Registration, Error> {
    config.check()?;
    let sigmas = [config.direction_sigma_rad, config.position_sigma_m];
    let [turn, shift] = sigmas.map(|sigma| sigma.powi(-2));
    let prior = Vector6::new(turn, turn, turn, shift, shift, shift);
    let mut pose: Option<Pose> = None;
    let mut before = 0.0;
    let mut result = None;
    for round in 0..ROUNDS {
        let X_W = pose.as_ref().map_or_else(Isometry3::identity, |p| p.X_W);
        let gate = (round > 0).then_some(GATE_SIGMAS);
        let pairs = matching::pairs(known, scanned, &X_W, gate);
        if pairs.is_empty() {
            return Err(Error::FewPlanes);
        }
        // Turns are about the middle of what is shared first.
        let pose = pose.get_or_insert_with(|| {
            before = solve::offset_rms_m(&pairs, &Isometry3::identity());
            let places = pairs.iter().map(|pair| pair.X_WC.translation.vector);
            Pose {
                X_W,
                about_W: (places.sum::<Vector3<f64>>() / pairs.len() as f64).into(),
                prior: Matrix6::from_diagonal(&prior),
            }
        });
        let solved = solve::solve(&pairs, pose).ok_or(Error::FewPlanes)?;
        pose.X_W = solved.X_W * pose.X_W;
        result = Some((solved, pairs, pose.X_W, pose.about_W));
    }
    let (solved, pairs, X_W, about_W) = result.ok_or(Error::FewPlanes)?;
    let names = |pair: &matching::Pair| {
        let (a, b) = (&known[pair.known].id, &scanned[pair.scanned].id);
        (a.clone(), b.clone())
    };
    Ok(Registration {
        X_W,
        about_W,
        misfit: solved.misfit,
        open: solve::open(&solved.covariance, sigmas),
        offset_rms_m: (before, solve::offset_rms_m(&pairs, &solved.X_W)),
        covariance: solved.covariance,
        pairs: pairs.iter().map(names).collect(),
    })
}

#[cfg(test)]
mod tests;
