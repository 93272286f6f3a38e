//! Parameters of the ground's plane.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// Which distances are trimmed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GroundForm {
    /// Signed, in units of their noise; the weighted fit of inverse depth.
    #[default]
    InverseDepth,
    /// Signed, in m, from the plane of total least squares: the paper's, in the form that converges.
    Signed,
    /// Absolute, in m: the paper's as printed. It trims on until few points are left.
    Absolute,
}

/// Parameters of the ground's plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GroundConfig {
    /// Which distances are trimmed.
    pub form: GroundForm,
    /// Standard deviations beyond which a point is trimmed ([chai2015] has 2).
    pub trim_sigmas: f64,
    /// Nearest point that counts, m from the sensor.
    pub range_min_m: f64,
    /// Farthest point that counts, m from the sensor.
    pub range_max_m: f64,
    /// Least points on the plane.
    pub inliers_min: usize,
    /// Most iterations of the trimming.
    pub iterations_max: usize,
    /// Root mean square of the slowly varying depth error as a ratio of depth; the sensor's own
    /// where absent, 0 for a sensor of which the depth has been undistorted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion_ratio: Option<f64>,
    /// Share of that error's variance that is the same in all frames: a pattern of the device.
    pub distortion_shared: f64,
    /// Planes that are drawn for the start.
    pub draws: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl Default for GroundConfig {
    fn default() -> Self {
        Self {
            form: GroundForm::InverseDepth,
            // Trimming Gaussians at 3σ costs 4 % of variance, at 2σ (which settles at 1.44σ) 126 %.
            trim_sigmas: 3.0,
            range_min_m: 0.4,
            range_max_m: 4.0,
            inliers_min: 500,
            iterations_max: 50,
            distortion_ratio: None,
            // The residuals of [chai2015] leave no room for an error that changes from frame to frame.
            distortion_shared: 1.0,
            draws: 100,
            seed: 0,
        }
    }
}

impl GroundConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        within(
            "trim_sigmas",
            self.trim_sigmas,
            [1.8, 1e3],
            "must be at least 1.8: a tighter bound trims uniform distances to nothing",
        )?;
        within(
            "range_min_m",
            self.range_min_m,
            [0.0, 1e3],
            "must be a distance",
        )?;
        within(
            "range_max_m",
            self.range_max_m,
            [self.range_min_m, 1e3],
            "must be a distance above range_min_m",
        )?;
        let count = "must be a positive number";
        within("inliers_min", self.inliers_min as f64, [3.0, 1e9], count)?;
        within(
            "iterations_max",
            self.iterations_max as f64,
            [1.0, 1e6],
            count,
        )?;
        if let Some(ratio) = self.distortion_ratio {
            within(
                "distortion_ratio",
                ratio,
                [0.0, 1.0],
                "must be a ratio below 1",
            )?;
        }
        within(
            "distortion_shared",
            self.distortion_shared,
            [0.0, 1.0],
            "must be a share between 0 and 1",
        )?;
        within("draws", self.draws as f64, [1.0, 1e6], count)
    }
}
