//! Where a scan was taken from, by the planes that it shares with what is known.
//!
//! Planes of the scan are matched to known ones by the pose that is given. Of the matched pairs
//! (n, p, Σ) ↔ (m, q, T) a rotation ω and a shift t of the scan are sought with
//!
//!   R = argmax Σ w mᵀ R n,                          Kabsch on the normals,
//!   t = argmin Σ w (m · (R p + t − q))²,            least squares on the offsets,
//!
//! and from there the covariance-weighted optimum of tilts and offsets together,
//!
//!   min Σ dᵀ S⁻¹ d,   d(ω, t) = (θ_x, θ_y, z),   S = Σ + T,
//!
//! by Gauss and Newton. No points are matched, nothing iterates over nearest neighbours. Planes that
//! do not determine the pose are refused, with what they leave open.
//! Source: [kabsch1976] for the rotation.
#![allow(non_snake_case)]

mod matching;
mod solve;

use nalgebra::{Isometry3, Matrix6};
use serde::{Deserialize, Serialize};
use surfaces::{Face, FaceId};

use crate::Error;

/// Whether scans are registered.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RegistrationConfig {
    /// Whether the poses of all scans but the first are refined.
    pub refine: bool,
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
    /// Root mean square distance between matched planes, before and after, m.
    pub offset_rms_m: (f64, f64),
}

/// Registers the faces of a scan (in W by the pose that is given) with known ones.
///
/// # Errors
/// [`Error::FewPlanes`] with fewer than three pairs, [`Error::Degenerate`] naming what the pairs
/// leave open.
pub fn register(known: &[Face], scanned: &[Face]) -> Result<Registration, Error> {
    let mut X_W = Isometry3::identity();
    let mut result = None;
    let mut before = None;
    for round in 0..ROUNDS {
        let gate = (round > 0).then_some(GATE_SIGMAS);
        let pairs = matching::pairs(known, scanned, &X_W, gate);
        before.get_or_insert_with(|| solve::offset_rms_m(&pairs, &Isometry3::identity()));
        let solved = solve::solve(&pairs)?;
        X_W = solved.X_W * X_W;
        result = Some((solved, pairs));
    }
    let (solved, pairs) = result.ok_or(Error::FewPlanes { pairs: 0 })?;
    let names = |pair: &matching::Pair| {
        let (a, b) = (&known[pair.known].id, &scanned[pair.scanned].id);
        (a.clone(), b.clone())
    };
    Ok(Registration {
        X_W,
        covariance: solved.covariance,
        about_W: solved.about_W,
        misfit: solved.misfit,
        offset_rms_m: (
            before.unwrap_or(0.0),
            solve::offset_rms_m(&pairs, &solved.X_W),
        ),
        pairs: pairs.iter().map(names).collect(),
    })
}

#[cfg(test)]
mod tests;
