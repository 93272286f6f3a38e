//! A node of the tree: a contact set with the posture that reached it.

use std::sync::Arc;

use nalgebra::Vector3;
use plan::Change;
use posture::{Contact, FaceIndex, Posture};
use robot_model::PatchId;

use crate::context::{FootState, SearchContext};

/// A contact set with its posture.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub parent: Option<usize>,
    /// Contact changes from the root.
    pub depth: usize,
    pub change: Change,
    /// Whether the contact is an alternative to one that no motion leads to.
    pub alternative: bool,
    /// The contact set, at fixed places and loaded, in the order of the patches.
    pub contacts: Vec<Contact>,
    /// The contacts of the posture problem: the set, and the one just released, if any.
    pub touching: Vec<Contact>,
    pub posture: Arc<Posture>,
    /// Last place of every patch in W, whether it still touches or not.
    pub last: Vec<Option<Vector3<f64>>>,
}

impl Node {
    pub fn holds(&self, patch: PatchId) -> bool {
        self.contacts.iter().any(|c| c.patch == patch)
    }

    /// Distance along the guide path that the feet still have to go, on the mean, m.
    pub fn distance_m(&self, context: &SearchContext) -> f64 {
        let end = context.request.guide.length_m();
        let feet = self.feet(context);
        let behind: f64 = feet.iter().map(|f| (end - f.along_m).max(0.0)).sum();
        behind / feet.len().max(1) as f64
    }

    /// The feet as the estimate sees them.
    pub fn feet(&self, context: &SearchContext) -> Vec<FootState> {
        let foot = |&patch: &PatchId| {
            let place = self.last[patch.index()].unwrap_or_else(Vector3::zeros);
            let (along_m, lateral_m) = context.progress(patch, &place);
            FootState {
                along_m,
                lateral_m,
                in_air: !self.holds(patch),
            }
        };
        context.feet.iter().map(foot).collect()
    }

    /// The contacts in words.
    pub fn describe(&self, context: &SearchContext) -> String {
        let request = context.request;
        let words = |c: &Contact| c.describe(request.robot, request.environment);
        let contacts: Vec<String> = self.contacts.iter().map(words).collect();
        contacts.join(", ")
    }
}

/// Contacts of one patch on one face nearer than this count as the same, m; alternatives to one
/// that no motion leads to are this far from it.
pub(crate) const SAME_PLACE_M: f64 = 0.06;

/// What tells one contact set from another: patches, faces and places, to the cell.
pub(crate) type Key = Vec<(PatchId, Option<FaceIndex>, [i64; 3])>;

/// The key of contacts in the order of the patches.
pub(crate) fn key(contacts: &[Contact]) -> Key {
    let of_contact = |c: &Contact| {
        let p = c.X_WC.translation.vector / SAME_PLACE_M;
        (c.patch, c.face, [p.x, p.y, p.z].map(|x| x.round() as i64))
    };
    contacts.iter().map(of_contact).collect()
}
