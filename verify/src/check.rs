//! What is checked, in which unit, and which side of the bound is the good one.

use serde::{Deserialize, Serialize};

/// One thing that a plan must fulfil.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Check {
    /// The file is of the format that is read here.
    Format,
    /// The robot is the one the plan was made for: name, joint names in order, mass.
    Robot,
    /// The margins that the plan promises make sense.
    Required,
    /// Surfaces and obstacles have distinct names, finite numbers and a body behind them.
    Environment,
    /// The plan says how many contact sets it has, and has so many.
    PathLength,
    /// Vectors have the right length and hold numbers of a sane size.
    Numbers,
    /// Patches, links and surfaces exist, and every contact is described in full.
    Names,
    /// Quaternions have unit length.
    Quaternion,
    /// A stance follows from the one before it by the one contact that it says.
    Sequence,
    /// A contact that stays, stays where it was made.
    Kept,
    /// The last stance fulfils the goal.
    Goal,
    /// Joints are inside their limits by the margin.
    JointLimit,
    /// The stated centre of mass is the robot's.
    Com,
    /// Patches are where the posture puts them.
    Pose,
    /// Patch vertices lie in the plane of the surface.
    Closure,
    /// The patch's normal is that of the surface.
    Normal,
    /// Patch vertices lie in the surface's polygon, inset.
    Inclusion,
    /// Forces act inside the patch, shrunk by the margin of the centre of mass.
    ForcePoint,
    /// The contact that is made or broken bears nothing.
    Unloaded,
    /// Contacts push.
    Unilateral,
    /// Forces lie in the friction cone.
    Friction,
    /// The stated forces carry the weight.
    BalanceForce,
    /// The stated forces have no moment about the centre of mass.
    BalanceMoment,
    /// Joints hold the posture with the part of their torque that the plan allows.
    Torque,
    /// Forces that balance the robot can be found from nothing but the contacts.
    Equilibrium,
    /// The centre of mass may be elsewhere and the contacts still hold it.
    ComMargin,
    /// Nothing but contacts is near the environment.
    Clearance,
    /// What touches does not sink in.
    ContactDepth,
    /// Parts of the robot are apart.
    SelfClearance,
    /// The motion is of the format that is read here, and whole.
    MotionRecord,
    /// The motion's phases lead from stance to stance on contacts that both have.
    MotionPhases,
    /// Where phases meet at a stance, the motion is at its posture (m, rad).
    MotionEnd,
    /// Joints keep to their speed limits (part of them).
    MotionSpeed,
    /// No body moves farther from one sample to the next than the robot is kept clear of things.
    MotionStep,
    /// What the plan says of its margins is not better than what is found.
    StatedMargin,
}

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

impl Check {
    /// Every check, in the order in which tables show them.
    pub const ALL: [Check; 35] = [
        Check::Format,
        Check::Robot,
        Check::Required,
        Check::Environment,
        Check::PathLength,
        Check::Numbers,
        Check::Names,
        Check::Quaternion,
        Check::Sequence,
        Check::Kept,
        Check::Goal,
        Check::JointLimit,
        Check::Com,
        Check::Pose,
        Check::Closure,
        Check::Normal,
        Check::Inclusion,
        Check::ForcePoint,
        Check::Unloaded,
        Check::Unilateral,
        Check::Friction,
        Check::BalanceForce,
        Check::BalanceMoment,
        Check::Torque,
        Check::Equilibrium,
        Check::ComMargin,
        Check::Clearance,
        Check::ContactDepth,
        Check::SelfClearance,
        Check::MotionRecord,
        Check::MotionPhases,
        Check::MotionEnd,
        Check::MotionSpeed,
        Check::MotionStep,
        Check::StatedMargin,
    ];

    /// Its name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Check::Format => "format",
            Check::Robot => "robot",
            Check::Required => "required",
            Check::Environment => "environment",
            Check::PathLength => "path_length",
            Check::Numbers => "numbers",
            Check::Names => "names",
            Check::Quaternion => "quaternion",
            Check::Sequence => "sequence",
            Check::Kept => "kept",
            Check::Goal => "goal",
            Check::JointLimit => "joint_limit",
            Check::Com => "com",
            Check::Pose => "pose",
            Check::Closure => "closure",
            Check::Normal => "normal",
            Check::Inclusion => "inclusion",
            Check::ForcePoint => "force_point",
            Check::Unloaded => "unloaded",
            Check::Unilateral => "unilateral",
            Check::Friction => "friction",
            Check::BalanceForce => "balance_force",
            Check::BalanceMoment => "balance_moment",
            Check::Torque => "torque",
            Check::Equilibrium => "equilibrium",
            Check::ComMargin => "com_margin",
            Check::Clearance => "clearance",
            Check::ContactDepth => "contact_depth",
            Check::SelfClearance => "self_clearance",
            Check::MotionRecord => "motion_record",
            Check::MotionPhases => "motion_phases",
            Check::MotionEnd => "motion_end",
            Check::MotionSpeed => "motion_speed",
            Check::MotionStep => "motion_step",
            Check::StatedMargin => "stated_margin",
        }
    }

    /// The unit of its values; empty where there is none.
    pub fn unit(self) -> &'static str {
        match self {
            Check::JointLimit | Check::Normal => "rad",
            Check::Kept
            | Check::Goal
            | Check::Com
            | Check::Pose
            | Check::Closure
            | Check::Inclusion
            | Check::ForcePoint
            | Check::BalanceMoment
            | Check::ComMargin
            | Check::Clearance
            | Check::ContactDepth
            | Check::MotionStep
            | Check::SelfClearance => "m",
            Check::Unloaded | Check::Unilateral => "N",
            _ => "",
        }
    }

    /// Which values are good.
    pub fn sense(self) -> Sense {
        match self {
            Check::Quaternion
            | Check::Kept
            | Check::Goal
            | Check::Com
            | Check::Pose
            | Check::Closure
            | Check::Normal
            | Check::Unloaded
            | Check::Friction
            | Check::BalanceForce
            | Check::BalanceMoment
            | Check::Torque
            | Check::MotionEnd
            | Check::MotionSpeed
            | Check::MotionStep
            | Check::StatedMargin => Sense::AtMost,
            Check::JointLimit
            | Check::Inclusion
            | Check::ForcePoint
            | Check::Unilateral
            | Check::Equilibrium
            | Check::ComMargin
            | Check::Clearance
            | Check::ContactDepth
            | Check::SelfClearance => Sense::AtLeast,
            Check::Format
            | Check::Robot
            | Check::Required
            | Check::Environment
            | Check::PathLength
            | Check::Numbers
            | Check::Names
            | Check::MotionRecord
            | Check::MotionPhases
            | Check::Sequence => Sense::Holds,
        }
    }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
