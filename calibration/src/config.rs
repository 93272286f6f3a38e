//! Parameters of the calibration.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::camera::CameraConfig;
use crate::ground::GroundConfig;
use crate::lidar::LidarMountConfig;
use crate::stance::StanceConfig;

/// Parameters of the calibration.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The ground's plane in one scan.
    pub ground: GroundConfig,
    /// The robot's pose over the ground.
    pub stance: StanceConfig,
    /// The mount from the planes.
    pub camera: CameraConfig,
    /// A LiDAR over the ground.
    pub lidar: LidarMountConfig,
}

impl Config {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        self.ground.check()?;
        self.stance.check()?;
        self.camera.check()?;
        self.lidar.check()
    }
}
