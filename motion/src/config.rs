//! Settings of the motion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Limits and margins of the motion between stances.
///
/// The margins of joints and clearances are those of the postures ([`posture::Config`]); a motion may use
/// more of torque and friction and of the margin of the centre of mass than a posture at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Time between two samples, s.
    #[schemars(range(min = 0.001, max = 0.02))]
    pub dt_s: f64,
    /// Time at rest after a patch has landed, s; at 0 the body goes on while it lands, where it can.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub settle_s: f64,
    /// Time over which an acceleration grows or falls, s: bounds the jerk.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub smooth_s: f64,
    /// Largest used part of the joints' speed limits.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub joint_speed_use: f64,
    /// Largest acceleration of a joint, rad/s² (m/s² where prismatic).
    #[schemars(range(min = 0.1, max = 100.0))]
    pub joint_acceleration_rad_s2: f64,
    /// Largest used part of the torque limits; at least the postures'.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub torque_use: f64,
    /// Largest used part of the friction coefficients; at least the postures'.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub friction_use: f64,
    /// Part of the margin of the centre of mass that the zero-moment point may use.
    #[schemars(range(min = 0.01, max = 0.99))]
    pub margin_use: f64,
    /// Largest speed of a patch in the air, m/s.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub swing_speed_m_s: f64,
    /// Largest speed of a patch where it may touch, m/s.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub landing_speed_m_s: f64,
    /// Distance by which a patch in the air clears what lies under its path, m; what stands beside
    /// its path is cleared as in the postures.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub swing_clearance_m: f64,
    /// Height over the higher end at which a patch travels where nothing asks for more, m.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub swing_height_m: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            dt_s: 0.01,
            settle_s: 0.0,
            smooth_s: 0.05,
            joint_speed_use: 0.8,
            joint_acceleration_rad_s2: 25.0,
            torque_use: 0.85,
            friction_use: 0.9,
            margin_use: 0.75,
            swing_speed_m_s: 1.5,
            landing_speed_m_s: 0.25,
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
        let inside = |value: f64| value > 0.0 && value < 1.0;
        for (field, value, fine, allowed) in [
            ("dt_s", self.dt_s, positive as fn(f64) -> bool, "> 0"),
            ("settle_s", self.settle_s, length, "≥ 0"),
            ("smooth_s", self.smooth_s, positive, "> 0"),
            ("joint_speed_use", self.joint_speed_use, part, "(0, 1]"),
            (
                "joint_acceleration_rad_s2",
                self.joint_acceleration_rad_s2,
                positive,
                "> 0",
            ),
            ("torque_use", self.torque_use, part, "(0, 1]"),
            ("friction_use", self.friction_use, part, "(0, 1]"),
            ("margin_use", self.margin_use, inside, "(0, 1)"),
            ("swing_speed_m_s", self.swing_speed_m_s, positive, "> 0"),
            ("landing_speed_m_s", self.landing_speed_m_s, positive, "> 0"),
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
