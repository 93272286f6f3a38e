//! Parameters of the robot's pose over the ground.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;

/// How a pose comes from feet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StanceMethod {
    /// The nearest pose to all feet.
    #[default]
    AllFeet,
    /// Trilateration with three feet, as in [chai2015].
    ThreeFeet,
}

/// Parameters of the robot's pose over the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StanceConfig {
    /// How a pose comes from feet.
    pub method: StanceMethod,
    /// Largest root mean square by which feet may miss their places, m: more is a foot that
    /// slipped, or joints that are not the robot's.
    pub foot_error_max_m: f64,
}

impl Default for StanceConfig {
    fn default() -> Self {
        Self {
            method: StanceMethod::AllFeet,
            foot_error_max_m: 0.02,
        }
    }
}

impl StanceConfig {
    /// Checks every parameter's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the parameter.
    pub fn check(&self) -> Result<(), Error> {
        within(
            "foot_error_max_m",
            self.foot_error_max_m,
            [1e-9, 1.0],
            "must be a length up to 1 m",
        )
    }
}
