//! A contact between a patch of the robot and a face.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surfaces::FaceId;

use crate::Pose;

/// A contact of a stance, or of a phase of a motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The robot's contact patch.
    pub patch: String,
    /// The link that carries it.
    pub link: String,
    /// The face it touches.
    pub face: FaceId,
    /// Pose of the patch frame C in W; of a point patch the ball's centre, with the axes of the
    /// face that it touches.
    pub X_WC: Pose,
    /// Of a ball that rolls while it touches: where its centre was, and how its link was turned, in W, when it came to
    /// stand. From there its centre goes by its radius times the link's rotation since × the face's normal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolls_from: Option<Pose>,
    /// Coefficient of friction of the pair (the real one, before `friction_use`).
    pub friction: f64,
    /// Whether it may carry load.
    pub loaded: bool,
    /// Vertices of the patch in W, m; of a point patch the touched point. In a motion
    /// there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vertices_W: Vec<[f64; 3]>,
    /// Points in W where the forces act (the patch shrunk by the CoM margin; of a point patch the
    /// touched point), m. Of a motion's ball that rolls it is the point that it touched when it came to stand, and the
    /// force acts where it touches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub force_points_W: Vec<[f64; 3]>,
    /// Force on the robot at each force point, in W, N; none in a motion, whose samples have them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forces_W: Vec<[f64; 3]>,
}
