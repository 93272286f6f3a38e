//! Why a set of contacts has no posture, for whoever does not believe it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Pose, RequiredMargins};

/// Contacts that no posture has within its margins, and the proof of that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refutation {
    /// The contacts.
    pub contacts: Vec<ContactPlace>,
    /// The margins that a posture keeps.
    pub required: RequiredMargins,
    /// The proof.
    pub proof: Proof,
}

/// A contact of which a posture is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactPlace {
    /// The robot's contact patch.
    pub patch: String,
    /// Pose of the patch frame C in W; of a ball its centre, z the normal of what it touches.
    pub X_WC: Pose,
    /// How it may differ from that pose.
    pub freedom: PlaceFreedom,
    /// Coefficient of friction of the pair (the real one, before `friction_use`).
    pub friction: f64,
    /// Whether it may carry load.
    pub loaded: bool,
}

/// How a contact may differ from its pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PlaceFreedom {
    /// Not at all; a ball may turn.
    Fixed,
    /// The patch may turn about its z.
    Yaw,
    /// The patch may be elsewhere.
    Elsewhere,
}

/// A proof that contacts have no posture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Proof {
    /// A link is too near to another, or to a body of the environment, where contacts put it.
    Colliding {
        /// The link.
        link: String,
        /// What it is too near to.
        other: Near,
    },
    /// A sum of conditions that every posture fulfils, each times a multiplier, is more than nothing whatever
    /// the rotations of the bodies and the forces are.
    Multipliers(Multipliers),
}

/// What a link is too near to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Near {
    /// Another link that a contact puts.
    Link(String),
    /// A convex body of the environment.
    Body {
        /// Its name.
        id: String,
        /// The points whose hull it is, in W, m.
        points_W: Vec<[f64; 3]>,
    },
}

/// The multipliers of
///
///   L = Σ_i λ_i·(p_i − p_i*) + φ·(Σ f − ẑ) + μ·(Σ (p − o) × f − (c − o) × ẑ) + Σ_b t_b a_b·Σ (p − o_b) × f
///
/// with places p_i of contacts, forces f over the weight, the centre of mass c, and axes a_b of joints next to
/// bodies that contacts put. A posture has L ≤ Σ |t_b| (limit of b over the weight); it is disproved where L is
/// more than that. Bodies are gone through from the leaves to the base: for every rotation of its parent, what L
/// has of a body and of those beyond is at least a linear form H_b of that rotation and a number that whoever
/// checks computes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Multipliers {
    /// λ_i, one a contact.
    pub places: Vec<[f64; 3]>,
    /// φ, m.
    pub force: [f64; 3],
    /// μ.
    pub moment: [f64; 3],
    /// o in W, m.
    pub about: [f64; 3],
    /// t_b, one a joint in the order of `q`.
    pub torques: Vec<f64>,
    /// H_b, one a joint, by rows: the form Σ_rc H_rc R_rc of the rotation R of the joint's parent in W.
    pub turns: Vec<[[f64; 3]; 3]>,
}
