//! Parameters of the whole extraction.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::chain::ChainConfig;
use crate::error::within;
use crate::inset::InsetConfig;
use crate::lidar::LidarConfig;
use crate::organised::OrganisedConfig;
use crate::registration::RegistrationConfig;
use crate::voxels::VoxelConfig;

/// Which path a scan takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The organised path where the scan has an image, else voxels.
    #[default]
    Auto,
    /// Inverse-depth moments on the image.
    Organised,
    /// Moments of the points in hashed voxels.
    Voxels,
    /// The chain of brossette2013 on the points.
    Chain,
}

/// Parameters of the extraction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Which path a scan takes.
    pub method: Method,
    /// Points farther than this from the sensor are not used, m.
    pub range_max_m: f64,
    /// Parameters of the organised path.
    pub organised: OrganisedConfig,
    /// Parameters of the path of voxels.
    pub voxels: VoxelConfig,
    /// Parameters of the chain.
    pub chain: ChainConfig,
    /// How far surfaces keep from their edges.
    pub inset: InsetConfig,
    /// Parameters of the LiDAR chain.
    pub lidar: LidarConfig,
    /// Where further scans of a scene were taken from.
    pub registration: RegistrationConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            range_max_m: 5.0,
            organised: OrganisedConfig::default(),
            voxels: VoxelConfig::default(),
            chain: ChainConfig::default(),
            inset: InsetConfig::default(),
            lidar: LidarConfig::default(),
            registration: RegistrationConfig::default(),
        }
    }
}

impl Config {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        within(
            "range_max_m",
            self.range_max_m,
            1e-3,
            1e6,
            "must be a positive distance",
        )?;
        self.organised.check()?;
        self.voxels.check(self.range_max_m)?;
        self.chain.check(self.range_max_m)?;
        self.inset.check()?;
        self.lidar.check()?;
        self.registration.check()
    }
}
