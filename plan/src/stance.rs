//! One contact set of a plan with the posture and the forces that hold the robot on it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surfaces::FaceId;

use crate::Contact;

/// One contact set with its posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stance {
    /// Position in the plan, from 0.
    pub index: usize,
    /// How the stance differs from the one before it.
    pub change: Change,
    /// The contacts that touch in this posture; the one that was just made or is about to leave
    /// is listed too, with `loaded: false` and no forces, so that the posture belongs to both
    /// contact sets and the transition is real.
    pub contacts: Vec<Contact>,
    /// Posture `[p_WB, quat_xyzw, joints…]`, m and rad.
    pub q: Vec<f64>,
    /// Centre of mass in W, m.
    pub com_W: [f64; 3],
    /// The margins as the posture generator evaluated them at the end.
    pub margins: Margins,
}

/// What was done to get from one stance to the next.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Change {
    /// The first stance.
    Start,
    /// A contact was made.
    Add {
        /// The robot's contact patch.
        patch: String,
        /// The face it was placed on.
        face: FaceId,
    },
    /// A contact was released; the posture still touches with no load on it.
    Remove {
        /// The robot's contact patch.
        patch: String,
        /// The face it left.
        face: FaceId,
    },
    /// Same contacts, all of them loaded, the posture that fulfils the goal.
    Goal,
}

impl std::fmt::Display for Change {
    /// In words, as on the terminal and on the page.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Start => f.write_str("start"),
            Self::Add { patch, face } => write!(f, "{patch} onto {face}"),
            Self::Remove { patch, face } => write!(f, "{patch} off {face}"),
            Self::Goal => f.write_str("goal"),
        }
    }
}

/// How far a posture is from each limit; what is negative is violated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Margins {
    /// Largest distance of a contact from its place, m (angles times 0.1 m).
    pub closure_m: f64,
    /// Smallest distance of a patch vertex from the edge of its inset face, m.
    pub inclusion_m: Option<f64>,
    /// Largest residual of force (N) and moment (N·m) over the robot's weight, 1 (and m).
    pub equilibrium: f64,
    /// Largest part of the friction coefficient that is used by more than 1e-4 of the weight.
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
