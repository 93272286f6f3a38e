//! Parameters of the LiDAR chain.

use serde::{Deserialize, Serialize};

use super::ground::GroundConfig;
use super::outliers::OutlierConfig;
use super::plane::RangeErrors;
use super::prosac::ConsensusConfig;
use super::slopes::SlopeConfig;
use super::surroundings::SurroundingsConfig;
use crate::Error;
use crate::error::within;

/// Parameters of the LiDAR chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LidarConfig {
    /// Horizontal field of view about V's x, rad.
    pub view_rad: f64,
    /// Nearer points are the robot's own, m.
    pub range_min_m: f64,
    /// Farther points are not used, m.
    pub range_max_m: f64,
    /// Errors of a measured point.
    pub errors: RangeErrors,
    /// Isolated points.
    pub outliers: OutlierConfig,
    /// The search for planes.
    pub consensus: ConsensusConfig,
    /// The ground.
    pub ground: GroundConfig,
    /// The slopes.
    pub slope: SlopeConfig,
    /// Walls and things around.
    pub around: SurroundingsConfig,
}

impl Default for LidarConfig {
    /// Half a turn, as [meng] IV.
    fn default() -> Self {
        Self {
            view_rad: std::f64::consts::PI,
            range_min_m: 0.4,
            range_max_m: 20.0,
            errors: RangeErrors::default(),
            outliers: OutlierConfig::default(),
            consensus: ConsensusConfig::default(),
            ground: GroundConfig::default(),
            slope: SlopeConfig::default(),
            around: SurroundingsConfig::default(),
        }
    }
}

impl LidarConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        let turn = std::f64::consts::TAU + 1e-9;
        within(
            "lidar.view_rad",
            self.view_rad,
            1e-3,
            turn,
            "must be in (0, 2π]",
        )?;
        within(
            "lidar.range_min_m",
            self.range_min_m,
            0.0,
            1e3,
            "must not be negative",
        )?;
        let cause = "must be more than range_min_m";
        within(
            "lidar.range_max_m",
            self.range_max_m,
            self.range_min_m + 1e-3,
            1e6,
            cause,
        )?;
        self.errors.check()?;
        self.outliers.check()?;
        self.consensus.check()?;
        self.ground.check()?;
        self.slope.check()?;
        self.around.check()
    }
}
