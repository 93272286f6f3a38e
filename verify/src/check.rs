//! What is checked, in which unit, and which side of the bound is the good one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which values are good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// Those not above the bound.
    AtMost,
    /// Those not below the bound.
    AtLeast,
    /// There is no number: it holds or it does not.
    Holds,
}

/// Rows of the table: what is checked, its name in tables and files, its unit, and which values are good.
macro_rules! checks {
    ($($(#[$meaning:meta])* $check:ident = $name:literal, $unit:literal, $sense:ident;)*) => {
        /// One thing that a plan must fulfil.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        #[non_exhaustive]
        pub enum Check {
            $($(#[$meaning])* #[serde(rename = $name)] $check),*
        }

        impl Check {
            /// Every check, in the order in which tables show them.
            pub const ALL: &[Check] = &[$(Check::$check),*];

            /// Its name in tables and files; the unit of its values, empty where there is none; and
            /// which of them are good.
            const fn row(self) -> (&'static str, &'static str, Sense) {
                match self {
                    $(Check::$check => ($name, $unit, Sense::$sense)),*
                }
            }
        }
    };
}

checks! {
    /// The file is of the format that is read here.
    Format = "format", "", Holds;
    /// The robot is the one the plan was made for: name, joint names in order, mass.
    Robot = "robot", "", Holds;
    /// The margins that the plan promises make sense.
    Required = "required", "", Holds;
    /// Surfaces and obstacles have distinct names, finite numbers and a body behind them.
    Environment = "environment", "", Holds;
    /// The plan's world, task and robot are those of its files.
    World = "world", "", Holds;
    /// The plan says how many contact sets it has, and has so many.
    PathLength = "path_length", "", Holds;
    /// Vectors have the right length and hold numbers of a sane size.
    Numbers = "numbers", "", Holds;
    /// Patches, links and surfaces exist, and every contact is described in full.
    Names = "names", "", Holds;
    /// Quaternions have unit length.
    Quaternion = "quaternion", "", AtMost;
    /// A stance follows from the one before it by the one contact that it says.
    Sequence = "sequence", "", Holds;
    /// Patches touch surfaces that their roles allow.
    Role = "role", "", Holds;
    /// A contact that stays, stays where it was made.
    Kept = "kept", "m", AtMost;
    /// The last stance fulfils the goal.
    Goal = "goal", "m", AtMost;
    /// Joints are inside their limits by the margin.
    JointLimit = "joint_limit", "rad", AtLeast;
    /// The stated centre of mass is the robot's.
    Com = "com", "m", AtMost;
    /// Patches are where the posture puts them.
    Pose = "pose", "m", AtMost;
    /// Patch vertices lie in the plane of the surface.
    Closure = "closure", "m", AtMost;
    /// The patch's normal is that of the surface.
    Normal = "normal", "rad", AtMost;
    /// Patch vertices lie in the surface's polygon, inset.
    Inclusion = "inclusion", "m", AtLeast;
    /// Forces act inside the patch, shrunk by the margin of the centre of mass.
    ForcePoint = "force_point", "m", AtLeast;
    /// The contact that is made or broken bears nothing.
    Unloaded = "unloaded", "N", AtMost;
    /// Contacts push.
    Unilateral = "unilateral", "N", AtLeast;
    /// Forces lie in the friction cone.
    Friction = "friction", "", AtMost;
    /// The stated forces carry the weight.
    BalanceForce = "balance_force", "", AtMost;
    /// The stated forces have no moment about the centre of mass.
    BalanceMoment = "balance_moment", "m", AtMost;
    /// Joints hold the posture with the part of their torque that the plan allows.
    Torque = "torque", "", AtMost;
    /// Forces that balance the robot can be found from nothing but the contacts.
    Equilibrium = "equilibrium", "", AtLeast;
    /// The centre of mass may be elsewhere and the contacts still hold it.
    ComMargin = "com_margin", "m", AtLeast;
    /// Nothing but contacts is near the environment.
    Clearance = "clearance", "m", AtLeast;
    /// What touches does not sink in, and what carries a sole or a palm stays off what that touches.
    ContactDepth = "contact_depth", "m", AtLeast;
    /// Parts of the robot are apart.
    SelfClearance = "self_clearance", "m", AtLeast;
    /// The motion is of the format that is read here, and whole.
    MotionRecord = "motion_record", "", Holds;
    /// The motion's phases lead from stance to stance on contacts that both have.
    MotionPhases = "motion_phases", "", Holds;
    /// Where phases meet at a stance, the motion is at its posture (m, rad).
    MotionEnd = "motion_end", "", AtMost;
    /// Joints keep to their part of their speed limits.
    MotionSpeed = "motion_speed", "", AtMost;
    /// Joints accelerate no more than the motion says (rad/s²; m/s² where prismatic).
    MotionAcceleration = "motion_acceleration", "", AtMost;
    /// Stated velocities are those of the samples (m/s, rad/s).
    MotionRate = "motion_rate", "", AtMost;
    /// Stated accelerations are those of the velocities, and do not jump (m/s², rad/s²).
    MotionJump = "motion_jump", "", AtMost;
    /// Stated torques are those that the motion takes (over the weight, m).
    MotionTorque = "motion_torque", "", AtMost;
    /// What the plan says of its margins is not better than what is found.
    StatedMargin = "stated_margin", "", AtMost;
}

impl Check {
    /// Its name in tables and files.
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// The unit of its values; empty where there is none.
    pub fn unit(self) -> &'static str {
        self.row().1
    }

    /// Which values are good.
    pub fn sense(self) -> Sense {
        self.row().2
    }

    /// By how much a value is on the good side of a bound.
    pub(crate) fn margin(self, value: f64, bound: f64) -> f64 {
        match self.sense() {
            Sense::AtMost => bound - value,
            _ => value - bound,
        }
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_are_called_in_files_as_they_are_here() {
        for check in Check::ALL {
            let mut name = String::new();
            for letter in format!("{check:?}").chars() {
                if letter.is_uppercase() && !name.is_empty() {
                    name.push('_');
                }
                name.extend(letter.to_lowercase());
            }
            assert_eq!(check.name(), name);
        }
    }
}
