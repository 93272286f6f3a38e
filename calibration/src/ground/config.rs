//! What the ground's plane is found with.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// Nearest point that counts, m from the sensor: depth cameras measure nothing nearer.
pub(super) const RANGE_MIN_M: f64 = 0.4;
/// Farthest point that counts, m from the sensor: beyond it a depth camera's noise says little.
pub(super) const RANGE_MAX_M: f64 = 4.0;

/// What the ground's plane is found with: one setting, and what a caller may choose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GroundConfig {
    /// Root mean square of the slowly varying depth error as a ratio of depth; the sensor's own
    /// where absent, 0 for a sensor of which the depth has been undistorted.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub distortion_ratio: Option<f64>,
    /// Share of that error's variance that is the same in all frames: a pattern of the device.
    #[serde(skip)]
    pub distortion_shared: f64,
    /// Least points on the plane.
    #[serde(skip)]
    pub inliers_min: usize,
    /// Planes that are drawn for the start.
    #[serde(skip)]
    pub draws: usize,
    /// Seed of the draws.
    #[serde(skip)]
    pub seed: u64,
}

impl Default for GroundConfig {
    fn default() -> Self {
        Self {
            distortion_ratio: None,
            // The residuals of [chai2015] leave no room for an error that changes from frame to frame.
            distortion_shared: 1.0,
            inliers_min: 500,
            draws: 100,
            seed: 0,
        }
    }
}

impl GroundConfig {
    /// Checks the setting's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming it.
    pub fn check(&self) -> Result<(), Error> {
        let (ratio, cause) = (self.distortion_ratio, "must be a ratio below 1");
        within("distortion_ratio", ratio.unwrap_or(0.0), [0.0, 1.0], cause)
    }
}
