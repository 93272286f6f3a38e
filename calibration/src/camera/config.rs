//! Settings of the identification: how exactly the robot knows where it stands.

use nalgebra::{Isometry3, Matrix3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::within;
use crate::{Error, GroundPlane};

/// How exactly the robot knows where it stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CameraConfig {
    /// Standard deviation of the robot's tilt about each level axis, from joints, backlash and
    /// bending, rad.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub robot_tilt_sigma_rad: f64,
    /// Standard deviation of the robot's height, m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub robot_height_sigma_m: f64,
    /// Standard deviation of an error of height that all poses share (worn feet, soft ground), m.
    /// No set of poses can tell it from the sensor's height; it only widens the covariance.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub common_height_sigma_m: f64,
}

impl Default for CameraConfig {
    fn default() -> Self {
        Self {
            // The residuals of [chai2015] (0.21° mean angle, 1.1 mm) are those of 0.17° and 1 mm.
            robot_tilt_sigma_rad: 0.17_f64.to_radians(),
            robot_height_sigma_m: 0.001,
            common_height_sigma_m: 0.0,
        }
    }
}

impl CameraConfig {
    /// The ground as a robot at `X_GR` knows it, with the noise of its pose.
    pub fn robot_plane(&self, X_GR: &Isometry3<f64>) -> GroundPlane {
        let tilt = self.robot_tilt_sigma_rad.powi(2);
        let height = self.robot_height_sigma_m.powi(2);
        let noise = Matrix3::from_diagonal(&Vector3::new(tilt, tilt, height));
        GroundPlane::ground(X_GR, noise)
    }

    /// Checks every setting's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the setting.
    pub fn check(&self) -> Result<(), Error> {
        let (rad, m) = ("must be an angle below 1 rad", "must be a length below 1 m");
        let unit = [0.0, 1.0];
        within("robot_tilt_sigma_rad", self.robot_tilt_sigma_rad, unit, rad)?;
        within("robot_height_sigma_m", self.robot_height_sigma_m, unit, m)?;
        within("common_height_sigma_m", self.common_height_sigma_m, unit, m)
    }
}
