//! A node of the tree: a contact set with the posture that reached it.

use std::sync::Arc;

use nalgebra::Vector3;
use plan::Change;
use posture::{Contact, FaceIndex, Posture};
use robot_model::PatchId;

use crate::change::{Candidate, Move};
use crate::context::SearchContext;
use crate::estimate::estimate;
use crate::footing::Footing;
use crate::goal_stance::is_at;

/// A contact set with its posture.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub parent: Option<usize>,
    /// Contact changes from the root.
    pub depth: usize,
    pub change: Change,
    /// The contact set, at fixed places and loaded, in the order of the patches.
    pub contacts: Vec<Contact>,
    /// The contacts of the posture problem: the set, and the one just released, if any.
    pub touching: Vec<Contact>,
    pub posture: Arc<Posture>,
    /// Where on the route every patch stands, or stood last.
    pub footing: Vec<Option<Footing>>,
    /// The candidate that it came of.
    pub origin: Option<Candidate>,
    /// What it cost when it was chosen, in contacts made and estimated to follow.
    pub price: f64,
    /// How much lower the base is than legs go down as usual, m.
    pub crouch_m: f64,
    /// Motions from it that failed.
    pub failures: usize,
    /// Whether there is a motion to it from its parent, as far as is known.
    pub settled: bool,
}

impl Node {
    pub fn holds(&self, patch: PatchId) -> bool {
        self.contacts.iter().any(|c| c.patch == patch)
    }

    /// Where a patch touches, or touched until it left, in W.
    fn place_W(&self, patch: PatchId) -> Option<Vector3<f64>> {
        let mut touching = self.touching.iter();
        let contact = touching.find(|c| c.patch == patch);
        contact.map(|c| c.X_WC.translation.vector)
    }

    /// Where a change from it lands a patch, or lifts it off, in W.
    pub fn place_of_W(&self, change: &Move) -> Vector3<f64> {
        match change {
            Move::Remove(patch) => self.place_W(*patch).unwrap_or_default(),
            Move::Add(foothold) => foothold.place.coords,
        }
    }

    /// Where the contact that was changed touches, or the base where none was, in W.
    pub fn changed_W(&self, context: &SearchContext) -> Vector3<f64> {
        let patch = match &self.change {
            Change::Add { patch, .. } | Change::Remove { patch, .. } => Some(patch),
            Change::Start | Change::Goal => None,
        };
        let patch = patch.and_then(|name| context.request.robot.patch_id(name).ok());
        let place = patch.and_then(|patch| self.place_W(patch));
        place.unwrap_or(self.posture.q.p_WB)
    }

    /// Distance along the route that the feet still have to go, on the mean, m.
    pub fn distance_m(&self, context: &SearchContext) -> f64 {
        let end = context.route.length_m();
        let feet = self.feet(context);
        let behind: f64 = feet.iter().map(|f| (end - f.along_m).max(0.0)).sum();
        behind / feet.len().max(1) as f64
    }

    /// Where on the route the feet are on the mean, m.
    pub fn along_m(&self, context: &SearchContext) -> f64 {
        let feet = self.feet(context);
        feet.iter().map(|f| f.along_m).sum::<f64>() / feet.len().max(1) as f64
    }

    /// The feet as the estimate sees them.
    pub fn feet(&self, context: &SearchContext) -> Vec<Footing> {
        let foot = |&patch: &PatchId| {
            let held = self.contacts.iter().find(|c| c.patch == patch);
            let last = self.footing[patch.index()].unwrap_or_default();
            let elsewhere = held.and_then(|c| c.face);
            Footing {
                in_air: held.is_none(),
                astray: last.astray || elsewhere.is_some_and(|f| context.is_elsewhere(patch, f)),
                ..last
            }
        };
        context.feet.iter().map(foot).collect()
    }

    /// Estimated number of contact changes from it to the goal.
    pub fn rest(&self, context: &SearchContext) -> f64 {
        estimate(context, &self.feet(context), context.missing(&self.held()))
    }

    /// Which patch touches which face.
    pub fn held(&self) -> Vec<(PatchId, FaceIndex)> {
        let held = self.contacts.iter();
        held.filter_map(|c| Some((c.patch, c.face?))).collect()
    }

    /// The contacts in words.
    pub fn describe(&self, context: &SearchContext) -> String {
        let request = context.request;
        let words = |c: &Contact| c.describe(request.robot, request.environment);
        let contacts: Vec<String> = self.contacts.iter().map(words).collect();
        contacts.join(", ")
    }
}

/// Headings of a sole nearer than this count as the same, rad.
const SAME_HEADING_RAD: f64 = 0.2;

/// What tells one contact set from another: patches, faces, places and headings, to the cell, and whether a foot is
/// where it has to be at the goal.
pub(crate) type Key = Vec<(PatchId, Option<FaceIndex>, [i64; 4], bool)>;

/// What tells one change to a contact set from another: patch, and the contact made.
pub(crate) type ChangeKey = (PatchId, Option<(FaceIndex, [i64; 3])>);

/// The key of a change.
pub(crate) fn change_key(context: &SearchContext, change: &Move) -> ChangeKey {
    match change {
        Move::Remove(patch) => (*patch, None),
        Move::Add(foothold) => {
            let p = foothold.place.coords / context.same_place_m();
            let cell = [p.x, p.y, p.z].map(|x| x.round() as i64);
            (foothold.patch, Some((foothold.face, cell)))
        }
    }
}

/// The key of contacts in the order of the patches.
pub(crate) fn key(context: &SearchContext, contacts: &[Contact]) -> Key {
    let of_contact = |c: &Contact| {
        let p = c.X_WC.translation.vector / context.same_place_m();
        let yaw = context.yaw(c);
        let turned = yaw.unwrap_or(0.0) / SAME_HEADING_RAD;
        (
            c.patch,
            c.face,
            [p.x, p.y, p.z, turned].map(|x| x.round() as i64),
            context
                .stand_at_goal(c.patch)
                .is_some_and(|wanted| is_at(wanted, &context.place_W(c), yaw)),
        )
    };
    contacts.iter().map(of_contact).collect()
}
