//! Settings of the motion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Times, margins and budgets of the motion between stances.
///
/// The margins of joints, torques, friction, clearances and of the centre of mass are those of the
/// postures ([`posture::Config`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Time between two samples, s.
    pub dt_s: f64,
    /// Shortest time of a phase with all contacts closed, s.
    pub shift_s: f64,
    /// Shortest time of a phase with a patch in the air, s.
    pub swing_s: f64,
    /// Time at rest after a patch has landed, s.
    pub settle_s: f64,
    /// Largest used part of the joints' speed limits, (0, 1].
    pub joint_speed_use: f64,
    /// Largest speed of a patch in the air, m/s.
    pub swing_speed_m_s: f64,
    /// Distance by which a patch in the air clears what lies under its path, m; what stands beside
    /// its path is cleared as in the postures.
    pub swing_clearance_m: f64,
    /// Height over the higher end at which a patch travels where nothing asks for more, m.
    pub swing_height_m: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            dt_s: 0.01,
            shift_s: 2.0,
            swing_s: 2.5,
            settle_s: 0.1,
            joint_speed_use: 0.5,
            swing_speed_m_s: 0.5,
            swing_clearance_m: 0.020,
            swing_height_m: 0.05,
        }
    }
}

impl Config {
    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`Error::Config`] with the field, its value and what is allowed.
    pub fn validate(&self) -> Result<(), Error> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let length = |value: f64| value >= 0.0 && value.is_finite();
        let part = |value: f64| value > 0.0 && value <= 1.0;
        for (field, value, fine, allowed) in [
            ("dt_s", self.dt_s, positive as fn(f64) -> bool, "> 0"),
            ("shift_s", self.shift_s, positive, "> 0"),
            ("swing_s", self.swing_s, positive, "> 0"),
            ("settle_s", self.settle_s, length, "≥ 0"),
            ("joint_speed_use", self.joint_speed_use, part, "(0, 1]"),
            ("swing_speed_m_s", self.swing_speed_m_s, positive, "> 0"),
            ("swing_clearance_m", self.swing_clearance_m, length, "≥ 0"),
            ("swing_height_m", self.swing_height_m, positive, "> 0"),
        ] {
            if !fine(value) {
                return Err(Error::Config {
                    field,
                    value,
                    allowed,
                });
            }
        }
        Ok(())
    }
}
