//! A change to a contact set, as it waits in the frontier.

use std::sync::Arc;

use posture::Posture;
use robot_model::PatchId;

use crate::foothold::Foothold;

/// Attempts from other seeds at a child, each time that it is tried: a posture that was not found
/// from its parent's is no proof that there is none.
pub(crate) const RESTARTS: [usize; 3] = [0, 1, 4];

/// A change to a node's contact set that has passed the cheap tests.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub node: usize,
    pub change: Move,
    /// Contacts made plus contacts still to be made, as far as one can tell before solving; those by
    /// the weight that the search gives them.
    pub priority: f64,
    /// Contacts estimated to follow.
    pub rest: f64,
    /// How often it was tried already.
    pub tries: usize,
    /// What its priority has been charged for what failed before it, in contacts.
    pub charged: f64,
    /// A posture to stay near to in the place of the nominal one: the next one on a way that no
    /// motion takes off for.
    pub near: Option<Arc<Posture>>,
    /// The changes to follow on it, where several were planned together.
    pub then: Option<Vec<Move>>,
    /// The changes that it is to make possible, where it is made for these alone.
    pub purpose: Vec<Move>,
    /// The posture that the last of them was planned with: where its own is looked for.
    pub planned: Option<Arc<Posture>>,
}

impl Candidate {
    /// A change that was not tried yet, with what it costs so far and what is estimated to follow.
    pub fn new(node: usize, change: Move, made: f64, rest: f64, weight: f64) -> Self {
        Self {
            node,
            change,
            priority: made + weight * rest,
            rest,
            tries: 0,
            charged: 0.0,
            near: None,
            then: None,
            purpose: Vec::new(),
            planned: None,
        }
    }

    /// What it costs with what is estimated to follow at full weight, in contacts.
    pub fn price(&self, weight: f64) -> f64 {
        self.priority - (weight - 1.0) * self.rest
    }

    /// Whether it leads to a contact set that was reached before, in another way that counts.
    pub fn is_variant(&self) -> bool {
        self.near.is_some() || self.then.is_some()
    }

    /// Whether nothing more is to be tried at it.
    pub fn is_spent(&self) -> bool {
        self.then.is_some() || self.tries + 1 >= RESTARTS.len()
    }
}

/// One contact more or one less.
#[derive(Clone, Debug)]
pub(crate) enum Move {
    /// Release the contact of this patch.
    Remove(PatchId),
    /// Touch with a patch, as near as possible to the proposed place.
    Add(Foothold),
}

impl Move {
    /// The patch that leaves or lands.
    pub fn patch(&self) -> PatchId {
        match self {
            Move::Remove(patch) => *patch,
            Move::Add(foothold) => foothold.patch,
        }
    }
}
