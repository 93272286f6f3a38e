//! Settings of the calibration.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::camera::CameraConfig;
use crate::ground::GroundConfig;
use crate::lidar::LidarExtrinsicsConfig;

/// Settings of the calibration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The ground's plane in one scan.
    pub ground: GroundConfig,
    /// The mount from the planes.
    pub camera: CameraConfig,
    /// A LiDAR over the ground.
    pub lidar: LidarExtrinsicsConfig,
}

impl Config {
    /// Checks every setting's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the setting.
    pub fn check(&self) -> Result<(), Error> {
        self.ground.check()?;
        self.camera.check()?;
        self.lidar.check()
    }
}
