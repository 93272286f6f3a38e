//! The ground's plane in one scan, by iterated trimming.
//!
//! A point p of the plane n·p + d = 0 lies on the ray r at p = r/w; so m·r = w with m = −n/d, linear
//! in m: depth images and clouds alike give a weighted least-squares problem in three unknowns.
//!
//!   min Σ ωᵢ (m·rᵢ − wᵢ)²,   ω = 1/(A_σ σ_w² + A_κ (κ w)²),   Cov m = (Σ ωᵢ rᵢ rᵢᵀ)⁻¹
//!
//! w is the inverse depth of a pixel (r = (x, y, 1)) or the inverse range of a point (‖r‖ = 1),
//! σ_w its noise, κ w the slowly varying error; A = 4π s² counts the samples over which an error of
//! correlation length s repeats itself, so that correlated noise is not taken for independent. The
//! weights are those of perception's planes.
//!
//! The slowly varying error is mostly a pattern of the device: the same in all frames, where the
//! noise is drawn anew in each. Averaging over frames does not remove it, so its part of Cov m is
//! kept apart ([`Ground::common`]).
//!
//! * `samples`: the rays, from an image or a cloud.
//! * `consensus`: where to start when not all that is seen is ground.
//! * `trimming`: the iterations.

mod config;
mod consensus;
mod pattern;
mod samples;
mod trimming;

pub use config::GroundConfig;
pub use pattern::CellEffect;

use nalgebra::{Matrix3, Unit, Vector3};
use perception::Scan;
use samples::Samples;

use crate::plane::tangents;
use crate::{Error, GroundPlane};

/// The ground's plane in V, and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// The plane, its normal toward the sensor; its covariance is that of the errors that are
    /// drawn anew in each frame.
    pub plane: GroundPlane,
    /// What the device's distortion does to it, which all frames share.
    pub common: Vec<CellEffect>,
    /// Samples within range.
    pub samples: usize,
    /// Samples that the plane was fitted to in the end.
    pub inliers: usize,
    /// Root mean square of the inliers' distances from the plane, in units of their stated noise.
    pub residual: f64,
    /// Iterations of the trimming.
    pub iterations: usize,
    /// Whether the trimming came to rest by itself.
    pub converged: bool,
}

/// The plane of the ground in `scan`.
///
/// # Errors
/// [`Error::NoGround`] when too few points lie on one plane; [`Error::Config`].
/// Source: \[chai2015\] Section 4.1; deviations: distances are weighed by their noise and trimmed
/// with their sign (with absolute ones, as printed, trimming goes on until few points are left), and the
/// start does not need most points to be ground.
pub fn ground(scan: &Scan, config: &GroundConfig) -> Result<Ground, Error> {
    config.check()?;
    let samples = Samples::of(scan, config);
    trimming::trim(&samples, config)
}

/// The plane of m = −n/d, and what errors of m do to its (η₁, η₂, d).
///
///   δη = −d Tᵀ δm,   δd = d² n·δm
fn plane_of(m: &Vector3<f64>) -> Option<(GroundPlane, Matrix3<f64>)> {
    let distance_m = 1.0 / m.norm();
    let normal = Unit::try_new(-m, 1e-12)?;
    let mut J = Matrix3::zeros();
    let turn = tangents(&normal).transpose() * -distance_m;
    J.fixed_rows_mut::<2>(0).copy_from(&turn);
    let shift = normal.transpose() * (distance_m * distance_m);
    J.fixed_rows_mut::<1>(2).copy_from(&shift);
    let plane = GroundPlane::exact(normal, distance_m);
    distance_m.is_finite().then_some((plane, J))
}

/// The two parts of a symmetric matrix that rounding has made different, as one.
fn symmetric(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    (matrix + matrix.transpose()) * 0.5
}

fn no_ground(found: usize, samples: &Samples, config: &GroundConfig) -> Error {
    Error::NoGround {
        found,
        samples: samples.len(),
        wanted: config.inliers_min,
        range_min_m: config::RANGE_MIN_M,
        range_max_m: config::RANGE_MAX_M,
    }
}
