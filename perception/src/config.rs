//! Parameters of the whole extraction.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::brossette2013::Brossette2013Config;
use crate::error::within;
use crate::lidar::LidarConfig;
use crate::registration::RegistrationConfig;

/// Which path a scan takes.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The organised path where the scan has an image with few enough pixels missing, else voxels.
    #[default]
    Auto,
    /// Inverse-depth moments on the image.
    Organised,
    /// Moments of the points in hashed voxels.
    Voxels,
    /// The chain of brossette2013 on the points.
    Brossette2013,
}

/// Parameters of the extraction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Which path a scan takes.
    pub method: Method,
    /// Points farther than this from the sensor are not used, m.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub range_max_m: f64,
    /// How deep something may go on where a seen face hides it from the sensor, m: avoided, and seen free by no view.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub unseen_depth_m: f64,
    /// How far a face may go on beyond the border of the view that cuts it, m.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub unseen_reach_m: f64,
    /// How much of a tread the edge of the step before it may hide: it is taken to go on to below that edge, m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub under_steps_m: f64,
    /// Parameters of the method of brossette2013.
    pub brossette2013: Brossette2013Config,
    /// Parameters of the LiDAR chain.
    pub lidar: LidarConfig,
    /// Where further scans of a scene were taken from.
    pub registration: RegistrationConfig,
    /// Whether what a camera or a bare cloud shows beside all faces is kept away from.
    pub avoid_loose: bool,
    /// Whether faces that may be level are taken to be.
    pub assume_level: bool,
    /// Whether faces that more than one scan shows are made one; if not, those of every scan stand
    /// side by side.
    pub fuse_views: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            range_max_m: 5.0,
            unseen_depth_m: surfaces::UNSEEN_DEPTH_M,
            unseen_reach_m: 0.5,
            under_steps_m: 0.3,
            brossette2013: Brossette2013Config::default(),
            lidar: LidarConfig::default(),
            registration: RegistrationConfig::default(),
            avoid_loose: true,
            assume_level: true,
            fuse_views: true,
        }
    }
}

impl Config {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        let range = "must be in [0.001, 10000] m";
        within("range_max_m", self.range_max_m, 1e-3, RANGE_MAX_M, range)?;
        let unseen = "must be in [0, 1000] m";
        within("unseen_depth_m", self.unseen_depth_m, 0.0, 1e3, unseen)?;
        within("unseen_reach_m", self.unseen_reach_m, 0.0, 1e3, unseen)?;
        let hidden = "must be in [0, 1] m";
        within("under_steps_m", self.under_steps_m, 0.0, 1.0, hidden)?;
        self.brossette2013.check(self.range_max_m)?;
        self.lidar.check()
    }
}

/// Farthest range, m: a voxel's place along an axis has to fit 21 bits.
const RANGE_MAX_M: f64 = 1e4;
