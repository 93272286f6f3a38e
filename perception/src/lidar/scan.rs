//! What a LiDAR's scan shows of ground and slopes.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use serde::Serialize;

use super::description::Description;
use super::plane::Plane;

/// How many points there were after each step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, schemars::JsonSchema)]
pub struct LidarCounts {
    /// Finite points of the cloud.
    pub points: usize,
    /// Points that were invalid.
    pub invalid: usize,
    /// Points in the field of view and within range.
    pub in_view: usize,
    /// Points that are not isolated.
    pub kept: usize,
    /// Points on the ground.
    pub ground: usize,
}

/// The ground of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// The plane in V.
    pub plane_V: Plane,
    /// Whether this scan shows it; else it is the calibrated one.
    pub seen: bool,
    /// Root mean square distance of its points, m; 0 where it was not seen.
    pub rms_m: f64,
    /// Covariance of (rotation about x_W, rotation about y_W, height) at `centre_W`: rad, rad, m.
    pub covariance: Matrix3<f64>,
    /// The mean of its points, m.
    pub centre_W: Point3<f64>,
    /// Its points, indices into [`SlopeScan::points_W`].
    pub members: Vec<u32>,
}

/// A slope of a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Slope {
    /// Start line, orientation, angle.
    pub description: Description,
    /// Standard deviation of δ, rad.
    pub delta_sigma_rad: f64,
    /// Standard deviation of p₁ and p₂ across the start line, along the ground, m.
    pub across_sigma_m: [f64; 2],
    /// Standard deviation of p₁ and p₂ along the start line, m.
    pub along_sigma_m: [f64; 2],
    /// Whether something hides where the start line ends at p₁ and at p₂: the end is as far as the
    /// slope was seen, and the deviation along the line reaches over what is hidden.
    pub hidden: [bool; 2],
    /// The plane in V.
    pub plane_V: Plane,
    /// Covariance of (tilt along t₁, tilt along t₂, distance) at `centre_V`: rad, rad, m.
    pub covariance: Matrix3<f64>,
    /// The mean of its points in V, m.
    pub centre_V: Vector3<f64>,
    /// The tangents t₁ and t₂ in V.
    pub tangents_V: [Vector3<f64>; 2],
    /// Root mean square distance of its points, m.
    pub rms_m: f64,
    /// Its points, indices into [`SlopeScan::points_W`].
    pub members: Vec<u32>,
}

/// What a scan shows of ground and slopes, in W.
#[derive(Debug, Clone, PartialEq)]
pub struct SlopeScan {
    /// Pose of V in W: the calibrated one, or the one that the ground gives.
    pub X_WV: Isometry3<f64>,
    /// The points that were used, in W, m.
    pub points_W: Vec<[f32; 3]>,
    /// Index in the cloud of every one of them.
    pub source: Vec<u32>,
    /// The ground.
    pub ground: Ground,
    /// The slopes, the largest consensus set first.
    pub slopes: Vec<Slope>,
    /// The rings' range errors beyond the calibrated ones, as this scan shows them, m.
    pub ring_bias_m: Vec<f64>,
    /// Counts along the way.
    pub counts: LidarCounts,
}
