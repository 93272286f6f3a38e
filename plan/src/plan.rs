//! The plan as it is written: stances, postures, forces and margins.
//!
//! Everything a reader needs to check the plan stands in the file: the surfaces it uses, the
//! margins it promises and, for each stance, the posture and the forces at the patch vertices.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surfaces::{Face, FaceId, Obstacle};

use crate::Stance;

/// The value of [`Plan::format`] that this version writes and reads.
pub const PLAN_FORMAT: &str = "scandent-plan/2";

/// A sequence of stances from the start to the goal, with what it was computed from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Always [`PLAN_FORMAT`].
    pub format: String,
    /// The program that wrote the plan.
    pub program: Program,
    /// Name of the scene.
    pub scene: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// The resolved configuration, one table per crate.
    pub config: serde_json::Value,
    /// The files the plan was computed from.
    pub inputs: Vec<Input>,
    /// The robot.
    pub robot: RobotSummary,
    /// The faces that the plan may touch, the ground under the start included.
    pub faces: Vec<Face>,
    /// Convex bodies that are only avoided.
    pub obstacles: Vec<Obstacle>,
    /// Thickness of the body behind every face, m.
    pub thin_body_m: f64,
    /// The margins that every stance keeps.
    pub required: RequiredMargins,
    /// The goal.
    pub goal: GoalRecord,
    /// The stances, start first.
    pub stances: Vec<Stance>,
    /// The motion between the stances, in a file beside the plan's; none where there is no plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionFile>,
    /// What the search did.
    pub search: SearchSummary,
}

/// The file that holds the motion of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionFile {
    /// Its name, in the folder of the plan.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// How long the motion takes, s.
    pub duration_s: f64,
    /// Number of samples.
    pub samples: usize,
}

/// Name and version of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Name.
    pub name: String,
    /// Version, as in the package manifest.
    pub version: String,
}

/// One file that the plan was computed from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// `scan`, `surfaces`, `mesh`, `urdf`, `srdf`, `contacts` or `scene`.
    pub role: String,
    /// The file as it was named by the user, or `builtin:…`.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

/// What identifies the robot of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotSummary {
    /// Name in the URDF.
    pub name: String,
    /// Names of the joints in the order of `q`.
    pub joint_names: Vec<String>,
    /// Total mass, kg.
    pub mass_kg: f64,
}

/// The margins that every stance of the plan promises to keep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RequiredMargins {
    /// Largest part of the friction coefficient that the forces use, 0…1.
    pub friction_use: f64,
    /// Largest part of the torque limits that holding the posture uses, 0…1.
    pub torque_use: f64,
    /// Distance of every joint from its limits, rad (m where prismatic).
    pub joint_rad: f64,
    /// Distance between the robot and the environment, contacts excepted, m. Links within two joints of a sole or a palm
    /// keep `self_clearance_m` from what it touches.
    pub clearance_m: f64,
    /// Distance between parts of the robot, m.
    pub self_clearance_m: f64,
    /// Distance by which the contact patches are shrunk for the equilibrium, m: with coplanar
    /// contacts the distance of the centre of mass from the edge of the support region, and that
    /// distance on balls alone, whatever their heights, on faces of less than 45°.
    pub com_m: f64,
    /// Standard deviations by which faces are taken back at edges that are not known exactly.
    pub edge_sigmas: f64,
}

/// The goal as the search understood it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalRecord {
    /// Wanted position of the base in W, m; a coordinate without a value is free.
    pub base_position_m: Option<[Option<f64>; 3]>,
    /// Largest distance from that position, m.
    pub tolerance_m: f64,
    /// Wanted heading of the base, rad.
    pub yaw_rad: Option<f64>,
    /// Wanted contacts.
    pub contacts: Vec<GoalContact>,
    /// Wanted joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<GoalJoints>,
}

/// Where joints must be at the end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalJoints {
    /// Value of each joint that is wanted, by its name, rad (m where prismatic).
    pub wanted: BTreeMap<String, f64>,
    /// Largest distance from it, rad (m).
    pub tolerance_rad: f64,
}

/// A contact that the last stance must contain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoalContact {
    /// The robot's contact patch.
    pub patch: String,
    /// The face it must be on.
    pub face: FaceId,
}

/// What the search did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SearchSummary {
    /// Contact sets with a posture, the start included.
    pub nodes_generated: usize,
    /// Contact sets of which at least one child was tried.
    pub nodes_expanded: usize,
    /// Posture problems solved.
    pub candidates_solved: usize,
    /// Contact sets on the path, the start included.
    pub path_stances: usize,
    /// A number of contact changes that no plan falls short of, by lengths alone; that of the plan is
    /// `path_stances` less one.
    #[serde(default)]
    pub changes_min: usize,
    /// The way of the base that the search followed: x, y, z in W, m, and its heading, rad.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub route: Vec<[f64; 4]>,
    /// Why this is no verified plan, where it is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unsolved: Option<Unsolved>,
}

/// How a search ended without a verified plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Unsolved {
    /// `no_plan` (proved), `exhausted`, `budget_spent`, `interrupted`, or `refused` by the verifier.
    pub status: String,
    /// The same in words.
    pub sentence: String,
    /// What blocks the way, nearest to the goal first; what the verifier refuses.
    pub reasons: Vec<String>,
    /// What may help.
    pub to_try: Vec<String>,
    /// The faces where contacts could not be made, nearest to the goal first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub blocked: Vec<FaceId>,
}
