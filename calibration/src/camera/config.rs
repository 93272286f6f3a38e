//! Parameters of the identification and of the pose design.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// Parameters of the identification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraConfig {
    /// Standard deviation of the robot's tilt about each level axis, from joints, backlash and
    /// bending, rad.
    pub robot_tilt_sigma_rad: f64,
    /// Standard deviation of the robot's height, m.
    pub robot_height_sigma_m: f64,
    /// Standard deviation of an error of height that all poses share (worn feet, soft ground), m.
    /// No set of poses can tell it from the sensor's height; it only widens the covariance.
    pub common_height_sigma_m: f64,
    /// Huber's threshold on √(eᵀΣ⁻¹e) of a pose; poses beyond it count less.
    pub huber: f64,
    /// Root mean square by which the tilts must vary in every direction, rad.
    pub tilt_spread_min_rad: f64,
    /// Most iterations of the refinement.
    pub iterations_max: usize,
    /// Which pose to add.
    pub design: DesignConfig,
}

/// Parameters of the pose design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DesignConfig {
    /// Largest tilt of a candidate, rad.
    pub tilt_max_rad: f64,
    /// Step of the tilts of the candidates, rad.
    pub tilt_step_rad: f64,
    /// Distance from the sensor at which an error of the mount counts, m.
    pub reach_m: f64,
    /// Least share of the image that must see ground within range.
    pub ground_share_min: f64,
}

impl Default for CameraConfig {
    fn default() -> Self {
        Self {
            // The residuals of [chai2015] (0.21° mean angle, 1.1 mm) are those of 0.17° and 1 mm.
            robot_tilt_sigma_rad: 0.17_f64.to_radians(),
            robot_height_sigma_m: 0.001,
            common_height_sigma_m: 0.0,
            // √(eᵀΣ⁻¹e) of three Gaussian components exceeds 3 in 3 % of all poses.
            huber: 3.0,
            tilt_spread_min_rad: 1.0_f64.to_radians(),
            iterations_max: 50,
            design: DesignConfig::default(),
        }
    }
}

impl Default for DesignConfig {
    fn default() -> Self {
        Self {
            tilt_max_rad: 20.0_f64.to_radians(),
            tilt_step_rad: 5.0_f64.to_radians(),
            reach_m: 2.0,
            ground_share_min: 0.2,
        }
    }
}

impl CameraConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        let positive = "must be positive";
        within(
            "robot_tilt_sigma_rad",
            self.robot_tilt_sigma_rad,
            [0.0, 1.0],
            "must be an angle below 1 rad",
        )?;
        within(
            "robot_height_sigma_m",
            self.robot_height_sigma_m,
            [0.0, 1.0],
            "must be a length below 1 m",
        )?;
        within(
            "common_height_sigma_m",
            self.common_height_sigma_m,
            [0.0, 1.0],
            "must be a length below 1 m",
        )?;
        within("huber", self.huber, [1e-3, 1e6], positive)?;
        within(
            "tilt_spread_min_rad",
            self.tilt_spread_min_rad,
            [1e-6, 1.0],
            "must be an angle between 0 and 1 rad",
        )?;
        within(
            "iterations_max",
            self.iterations_max as f64,
            [1.0, 1e6],
            positive,
        )?;
        let design = &self.design;
        within(
            "tilt_max_rad",
            design.tilt_max_rad,
            [1e-3, 1.2],
            "must be an angle below 1.2 rad",
        )?;
        within(
            "tilt_step_rad",
            design.tilt_step_rad,
            [design.tilt_max_rad / 50.0, design.tilt_max_rad],
            "must be between a fiftieth of tilt_max_rad and all of it",
        )?;
        within("reach_m", design.reach_m, [1e-3, 1e3], positive)?;
        within(
            "ground_share_min",
            design.ground_share_min,
            [0.0, 1.0],
            "must be a share between 0 and 1",
        )
    }
}
