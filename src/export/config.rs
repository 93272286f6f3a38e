//! Settings of the exporters.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Times and names that a plan of postures does not have and a controller needs.
///
/// The durations are those that a humanoid climbed steps of 0.20–0.35 m with in simulation under a
/// whole-body controller; half of them worked, a quarter did not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// From the start of the motion to its first movement, s.
    pub start_s: f64,
    /// To shift the weight with all contacts made, s.
    pub shift_s: f64,
    /// From leaving one place to touching the next, s.
    pub swing_s: f64,
    /// To take a limb away that touches nothing next, s.
    pub release_s: f64,
    /// How high over the higher of its two places a limb swings, m.
    pub swing_height_m: f64,
    /// How far a limb leaves and approaches a surface along the normal, m.
    pub approach_m: f64,
    /// Part of a swing in which a limb leaves, and part in which it approaches.
    pub approach_part: f64,
    /// Names of limbs by patch; patches that are not named get theirs in camel case
    /// (`left_foot` is `LeftFoot`).
    pub limbs: BTreeMap<String, String>,
    /// Name of the robot in the controller; the plan's where there is none.
    pub robot: Option<String>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            start_s: 1.0,
            shift_s: 2.0,
            swing_s: 2.5,
            release_s: 1.5,
            swing_height_m: 0.05,
            approach_m: 0.03,
            approach_part: 0.3,
            limbs: BTreeMap::new(),
            robot: None,
        }
    }
}

impl Config {
    /// Refuses durations and lengths that make no sense, naming the field.
    ///
    /// # Errors  the field, its value and what is allowed.
    pub fn validate(&self) -> anyhow::Result<()> {
        for (field, value) in [
            ("shift_s", self.shift_s),
            ("swing_s", self.swing_s),
            ("release_s", self.release_s),
        ] {
            anyhow::ensure!(
                value > 0.0 && value.is_finite(),
                "export.{field} = {value} is not allowed: give a duration > 0"
            );
        }
        for (field, value) in [
            ("start_s", self.start_s),
            ("swing_height_m", self.swing_height_m),
            ("approach_m", self.approach_m),
        ] {
            anyhow::ensure!(
                value >= 0.0 && value.is_finite(),
                "export.{field} = {value} is not allowed: give a value ≥ 0"
            );
        }
        let part = self.approach_part;
        anyhow::ensure!(
            part > 0.0 && part < 0.5,
            "export.approach_part = {part} is not allowed: give a value in (0, 0.5)"
        );
        Ok(())
    }
}
