//! What is asked of the planner.

use posture::{BaseGoal, Environment, FaceIndex};
use robot_model::{Configuration, PatchId, Robot};

use crate::guide::Guide;

/// A robot, its surroundings, where it is and where it shall go.
pub struct Request<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// Where it is.
    pub start: Start,
    /// Where it shall go.
    pub goal: Goal,
    /// The path that its base should roughly follow.
    pub guide: Guide,
    /// For each patch of the robot, in its order, the faces it may touch.
    pub usable: Vec<Vec<FaceIndex>>,
    /// The nominal posture; its base is not used.
    pub reference: Configuration,
}

/// The first stance.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Base pose and joints.
    pub configuration: Configuration,
    /// Pairs of patch and face that are in contact.
    pub contacts: Vec<(PatchId, FaceIndex)>,
}

/// What the last stance must be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goal {
    /// Where the base must be.
    pub base: BaseGoal,
    /// Patches that must be in contact, anywhere.
    pub patches: Vec<PatchId>,
    /// Pairs of patch and face that must be in contact.
    pub contacts: Vec<(PatchId, FaceIndex)>,
}
