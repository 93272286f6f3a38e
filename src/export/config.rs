//! Settings of the exporters.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Times and names that a plan of postures does not have and a controller needs.
///
/// The durations are those that a humanoid climbed steps of 0.20–0.35 m with in simulation under a
/// whole-body controller; half of them worked, a quarter did not. A plan with a motion has its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Time to shift the weight with all contacts made where the plan has no motion, s.
    #[schemars(range(min = 0.001, max = 1000.0))]
    pub shift_s: f64,
    /// Time from leaving one place to touching the next where the plan has no motion, s.
    #[schemars(range(min = 0.001, max = 1000.0))]
    pub swing_s: f64,
    /// Names of limbs by patch; patches that are not named get theirs in camel case
    /// (`left_foot` is `LeftFoot`).
    pub limbs: BTreeMap<String, String>,
    /// Name of the robot in the controller; the plan's where there is none.
    pub robot: Option<String>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            shift_s: 2.0,
            swing_s: 2.5,
            limbs: BTreeMap::new(),
            robot: None,
        }
    }
}

impl Config {
    /// Refuses durations that make no sense, naming the field.
    ///
    /// # Errors  the field, its value and what is allowed.
    pub fn validate(&self) -> anyhow::Result<()> {
        for (field, value) in [("shift_s", self.shift_s), ("swing_s", self.swing_s)] {
            anyhow::ensure!(
                value > 0.0 && value.is_finite(),
                "export.{field} = {value} is not allowed: give a duration > 0"
            );
        }
        Ok(())
    }
}
