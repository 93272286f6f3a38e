//! Parameters of the LiDAR chain.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// Parameters of the LiDAR chain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LidarConfig {
    /// Horizontal field of view about V's x, rad.
    #[schemars(range(min = 0.01, max = std::f64::consts::TAU))]
    pub view_rad: f64,
    /// Nearer points are the robot's own, m.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub range_min_m: f64,
    /// Farther points are not used, m.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub range_max_m: f64,
    /// Least angle of a slope to the ground, rad.
    #[schemars(range(min = 0.0, max = 1.5))]
    pub inclination_min_rad: f64,
    /// Most angle of a slope to the ground, rad; steeper planes are walls.
    #[schemars(range(min = 0.0, max = 1.5))]
    pub inclination_max_rad: f64,
    /// Samples planes and compares the distances of isolated points as \[meng\] publishes it.
    pub as_published: bool,
    /// Seed of the random samples.
    #[serde(skip)]
    pub seed: u64,
}

impl Default for LidarConfig {
    /// Half a turn, as \[meng\] IV.
    fn default() -> Self {
        Self {
            view_rad: std::f64::consts::PI,
            range_min_m: 0.4,
            range_max_m: 20.0,
            inclination_min_rad: 0.07,
            inclination_max_rad: 0.80,
            as_published: false,
            seed: 0,
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
        let (near, flat) = (self.range_min_m, self.inclination_min_rad);
        let (far, steep) = (self.range_max_m, self.inclination_max_rad);
        within(
            "lidar.view_rad",
            self.view_rad,
            1e-3,
            turn,
            "must be in (0, 2π]",
        )?;
        within("lidar.range_min_m", near, 0.0, 1e3, "must not be negative")?;
        let more = "must be more than range_min_m";
        within("lidar.range_max_m", far, near + 1e-3, 1e6, more)?;
        let some = "must be in [0, 1.5] rad";
        within("lidar.inclination_min_rad", flat, 0.0, 1.5, some)?;
        let steeper = "must be in [inclination_min_rad, 1.5]";
        within("lidar.inclination_max_rad", steep, flat, 1.5, steeper)?;
        Ok(())
    }
}
