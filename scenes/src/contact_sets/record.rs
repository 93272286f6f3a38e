//! The file of posture problems.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The format that is written.
pub const FORMAT: &str = "scandent-posture-problems/1";
/// What the names of all its versions begin with.
pub const FORMAT_BEGINS: &str = "scandent-posture-problems/";
/// The body behind every surface where a file does not say it, m.
pub const BODY_M: f64 = 0.03;

/// The file: problems for one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProblemSet {
    /// [`FORMAT`].
    pub format: String,
    /// Name of the robot that the problems are for; empty where any will do.
    #[serde(default)]
    pub robot: String,
    /// The robot's joints in the order of the witnesses; may be empty where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joint_names: Vec<String>,
    /// What kind of problems they are.
    #[serde(default)]
    pub family: String,
    /// The seed they were drawn from.
    #[serde(default)]
    pub seed: u64,
    /// Thickness of the body behind every surface, m.
    #[serde(default = "body_m")]
    pub body_m: f64,
    /// The problems.
    pub problems: Vec<ProblemRecord>,
}

fn body_m() -> f64 {
    BODY_M
}

/// One problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProblemRecord {
    /// A number or a name that the result repeats.
    pub id: serde_json::Value,
    /// Coefficient of friction of every contact.
    pub mu: f64,
    /// The contacts.
    pub contacts: Vec<ContactRecord>,
    /// What the contacts lie on and the robot must not hit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceRecord>,
    /// What is known of the answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<Expected>,
    /// Why no posture exists, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// A posture that solves the problem, `[p_WB, quat_xyzw, joints…]`; solvers do not see it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub witness: Option<Vec<f64>>,
}

/// What is known of a problem by the way it was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Expected {
    /// A posture exists.
    Solvable,
    /// No posture exists.
    Infeasible,
}

/// One contact: at a pose (`p` and `R`), or anywhere on a surface (neither).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactRecord {
    /// The link that carries the patch.
    pub link: String,
    /// The patch: its name, or a role that tells it from the link's other patches; may be left
    /// out where the link has one only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch: Option<String>,
    /// Position of C in W, m; of a point patch the touched point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p: Option<[f64; 3]>,
    /// Rotation of C in W by rows; its columns are C's axes in W, z outward from the environment.
    /// Of a point patch only z means something.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub R: Option<[[f64; 3]; 3]>,
    /// Whether the patch may turn about that z.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub yaw_free: bool,
    /// Id of the surface that is touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<String>,
}

/// A surface with a body of the file's thickness behind it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRecord {
    /// Name, unique in the problem.
    pub id: String,
    /// Position of S in W, m.
    pub p: [f64; 3],
    /// Rotation of S in W by rows; its third column is the outward normal.
    pub R: [[f64; 3]; 3],
    /// Convex polygon in S, counter-clockwise, m: patches that touch lie inside it.
    pub polygon_m: Vec<[f64; 2]>,
}
