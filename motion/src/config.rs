//! Settings of the motion.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Times, margins and budgets of the motion between stances.
///
/// The margins of joints, torques, friction, clearances and of the centre of mass are those of the
/// postures ([`posture::Config`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Part of the margin of the centre of mass that its acceleration may use, m: the zero-moment
    /// point stays this near to it.
    pub zmp_excursion_m: f64,
    /// Largest vertical acceleration of the centre of mass, m/s²: forces and torques, which are those of
    /// standing still, are more by its part of gravity.
    pub lift_m_s2: f64,
    /// Largest used part of the joints' speed limits, (0, 1].
    pub joint_speed_use: f64,
    /// Largest speed of a patch in the air, m/s.
    pub swing_speed_m_s: f64,
    /// Distance by which a patch in the air clears what lies under its way, m; what stands beside
    /// its way is cleared as in the postures.
    pub swing_clearance_m: f64,
    /// Height over the higher end at which a patch travels where nothing asks for more, m.
    pub swing_height_m: f64,
    /// How far a patch moves straight along the normal of the surface that it leaves or lands on,
    /// m.
    pub straight_m: f64,
    /// Spline pieces of one phase.
    pub pieces: usize,
    /// Largest distance of a closed contact from its place, m (angles times 0.1 m).
    pub closure_m: f64,
    /// Ways through the air that are tried for one swing.
    pub ways_max: usize,
    /// Postures solved on one way where its checks fail.
    pub waypoints_max: usize,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            dt_s: 0.01,
            shift_s: 2.0,
            swing_s: 2.5,
            settle_s: 0.1,
            zmp_excursion_m: 0.015,
            lift_m_s2: 1.5,
            joint_speed_use: 0.5,
            swing_speed_m_s: 0.5,
            swing_clearance_m: 0.020,
            swing_height_m: 0.05,
            straight_m: 0.030,
            pieces: 40,
            closure_m: 1e-5,
            ways_max: 6,
            waypoints_max: 2,
        }
    }
}

impl Config {
    /// Refuses values that make no sense, naming the field.
    ///
    /// # Errors
    /// [`Error::Config`] with the field, its value and what is allowed.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |field, value: f64, fine: bool, allowed| {
            if fine && value.is_finite() {
                Ok(())
            } else {
                Err(Error::Config {
                    field,
                    value,
                    allowed,
                })
            }
        };
        for (field, value) in [
            ("dt_s", self.dt_s),
            ("shift_s", self.shift_s),
            ("swing_s", self.swing_s),
            ("zmp_excursion_m", self.zmp_excursion_m),
            ("lift_m_s2", self.lift_m_s2),
            ("swing_speed_m_s", self.swing_speed_m_s),
            ("swing_height_m", self.swing_height_m),
            ("straight_m", self.straight_m),
            ("closure_m", self.closure_m),
            ("ways_max", self.ways_max as f64),
        ] {
            check(field, value, value > 0.0, "> 0")?;
        }
        for (field, value) in [
            ("settle_s", self.settle_s),
            ("swing_clearance_m", self.swing_clearance_m),
        ] {
            check(field, value, value >= 0.0, "≥ 0")?;
        }
        let value = self.joint_speed_use;
        check(
            "joint_speed_use",
            value,
            value > 0.0 && value <= 1.0,
            "(0, 1]",
        )?;
        let value = self.pieces as f64;
        check("pieces", value, (8.0..=512.0).contains(&value), "8 to 512")
    }
}
