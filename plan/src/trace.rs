//! What a search tried: its tree, what it was refused, and why each contact of the way was chosen.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Change;

/// The tree of a search, and the choices along the way that it gave.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trace {
    /// Contact sets with a posture, parents before children.
    pub nodes: Vec<TracedNode>,
    /// Changes that could not be made, in the order in which they were tried; of very many the last ones.
    pub refused: Vec<Refusal>,
    /// What was chosen at each stance of the way, and instead of what; last, where the way does not come to
    /// the goal, what was tried from its end.
    pub choices: Vec<Choice>,
}

/// A contact set of the tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracedNode {
    /// The contact set before, by its position; none of the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<usize>,
    /// Where the base is, in W, m.
    pub base_W: [f64; 3],
    /// Whether it was taken out of the tree: no motion leads to it, or to one before it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cut: bool,
}

/// A change that could not be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Refusal {
    /// The contact set that it was tried from, by its position.
    pub node: usize,
    /// Where the contact was to be made, or was, in W, m.
    pub at_W: [f64; 3],
    /// By what it was refused.
    pub by: Barrier,
}

/// What refuses a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Barrier {
    /// The contact is out of reach.
    Reach,
    /// The patch has no room on the face.
    Room,
    /// The robot would come too near to something or to itself.
    Collision,
    /// Nothing balances the weight.
    Balance,
    /// A contact slips.
    Friction,
    /// A joint would have to exert too much.
    Torque,
    /// A joint is beyond its limit.
    JointLimit,
    /// The base tilts too far.
    Tilt,
    /// There is a posture, and no motion to it.
    Motion,
    /// There is no posture at the goal.
    Goal,
}

/// What was chosen at a stance of the way, and instead of what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// The stance that came of it; the number of stances where none did.
    pub stance: usize,
    /// The contact set that it was chosen from, by its position in the tree.
    pub node: usize,
    /// Contacts made and estimated to follow, with what is charged for odd places and for what failed before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub price: Option<f64>,
    /// The other changes from there, the cheapest first.
    pub alternatives: Vec<Alternative>,
    /// How many more there were.
    #[serde(default)]
    pub more: usize,
}

/// A change that was not chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Alternative {
    /// The change.
    pub change: Change,
    /// Its price, as the choice's.
    pub price: f64,
    /// By what it was refused; nothing where it was not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<Barrier>,
    /// The constraint that fails and by how much, or what became of it.
    pub reason: String,
}
