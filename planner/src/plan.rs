//! The plan as it is written: stances, postures, forces and margins.
//!
//! Everything a reader needs to check the plan stands in the file: the surfaces it uses, the
//! margins it promises and, for each stance, the posture and the forces at the patch vertices.
#![allow(non_snake_case)]

pub use motion::Pose;
use serde::{Deserialize, Serialize};
use surfaces::{Obstacle, Surface};

/// The value of [`Plan::format`] that this version writes and reads.
pub const PLAN_FORMAT: &str = "scandent-plan/1";

/// A sequence of stances from the start to the goal, with what it was computed from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// The surfaces that the plan may touch, the ground under the start included.
    pub surfaces: Vec<Surface>,
    /// Convex bodies that are only avoided.
    pub obstacles: Vec<Obstacle>,
    /// Thickness of the body behind every surface, m.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Name.
    pub name: String,
    /// Version, as in the package manifest.
    pub version: String,
}

/// One file that the plan was computed from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequiredMargins {
    /// Largest part of the friction coefficient that the forces use, 0…1.
    pub friction_use: f64,
    /// Largest part of the torque limits that holding the posture uses, 0…1.
    pub torque_use: f64,
    /// Distance of every joint from its limits, rad (m where prismatic).
    pub joint_rad: f64,
    /// Distance between the robot and the environment, contacts excepted, m.
    pub clearance_m: f64,
    /// Distance between parts of the robot, m.
    pub self_clearance_m: f64,
    /// Distance by which the contact patches are shrunk for the equilibrium, m: with coplanar
    /// contacts the distance of the centre of mass from the edge of the support region, and that
    /// distance on balls alone, whatever their heights, on faces of less than 45°.
    pub com_m: f64,
}

impl From<&posture::Config> for RequiredMargins {
    /// The margins that the posture generator keeps.
    fn from(config: &posture::Config) -> Self {
        Self {
            friction_use: config.friction_use,
            torque_use: config.torque_use,
            joint_rad: config.joint_margin_rad,
            clearance_m: config.clearance_m,
            self_clearance_m: config.self_clearance_m,
            com_m: config.com_margin_m,
        }
    }
}

/// The goal as the search understood it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
}

/// A contact that the last stance must contain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalContact {
    /// The robot's contact patch.
    pub patch: String,
    /// The surface it must be on.
    pub surface: String,
}

/// One contact set with its posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stance {
    /// Position in the plan, from 0.
    pub index: usize,
    /// How the stance differs from the one before it.
    pub change: Change,
    /// The contacts that touch in this posture; the one that was just made or is about to leave
    /// is listed too, with `loaded: false` and no forces, so that the posture belongs to both
    /// contact sets and the transition is real.
    pub contacts: Vec<StanceContact>,
    /// Posture `[p_WB, quat_xyzw, joints…]`, m and rad.
    pub q: Vec<f64>,
    /// Centre of mass in W, m.
    pub com_W: [f64; 3],
    /// The margins as the posture generator evaluated them at the end.
    pub margins: Margins,
}

/// What was done to get from one stance to the next.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Change {
    /// The first stance.
    Start,
    /// A contact was made.
    Add {
        /// The robot's contact patch.
        patch: String,
        /// The surface it was placed on.
        surface: String,
    },
    /// A contact was released; the posture still touches with no load on it.
    Remove {
        /// The robot's contact patch.
        patch: String,
        /// The surface it left.
        surface: String,
    },
    /// Same contacts, all of them loaded, the posture that fulfils the goal.
    Goal,
}

/// A contact of a stance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StanceContact {
    /// The robot's contact patch.
    pub patch: String,
    /// The link that carries it.
    pub link: String,
    /// The surface it touches.
    pub surface: String,
    /// Pose of the patch frame C in W; of a point patch the ball's centre, with the axes of the
    /// surface that it touches.
    pub X_WC: Pose,
    /// Coefficient of friction of the pair (the real one, before `friction_use`).
    pub friction: f64,
    /// Whether it may carry load.
    pub loaded: bool,
    /// Vertices of the patch in W, m; of a point patch the touched point.
    pub vertices_W: Vec<[f64; 3]>,
    /// Points in W where the forces act (the patch shrunk by the CoM margin; of a point patch the
    /// touched point), m.
    pub force_points_W: Vec<[f64; 3]>,
    /// Force on the robot at each force point, in W, N.
    pub forces_W: Vec<[f64; 3]>,
}

/// How far a posture is from each limit; what is negative is violated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Largest distance of a contact from its place, m (angles times 0.1 m).
    pub closure_m: f64,
    /// Smallest distance of a patch vertex from the edge of its effective surface polygon, m.
    pub inclusion_m: Option<f64>,
    /// Largest residual of force (N) and moment (N·m) over the robot's weight, 1 (and m).
    pub equilibrium: f64,
    /// Largest used part of the friction coefficient.
    pub friction_use: f64,
    /// Largest used part of the torque limits.
    pub torque_use: f64,
    /// Smallest distance of a joint from its limits, rad (m where prismatic).
    pub joint_rad: f64,
    /// Smallest distance to the environment, contacts excepted, m.
    pub clearance_m: Option<f64>,
    /// Smallest distance between parts of the robot, m.
    pub self_clearance_m: Option<f64>,
}

/// What the search did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
}
