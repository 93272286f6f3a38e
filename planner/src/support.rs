//! Hands that help a foot: where a foot cannot leave or land, a contact of another limb is sought with which it can.
//!
//! A hand that is put somewhere for nothing yet multiplies all that follows by its places. Where a change of a foot has no
//! posture, each other limb is tried on each face in its reach in one posture problem together with that change, the limb's
//! place free on its face: it bears, and the foot does not. Only where that has a posture are the changes made, one by one,
//! at the places that were found. A limb that touches already is tried elsewhere.

use std::sync::Arc;

use posture::Outcome;
use robot_model::PatchId;

use crate::candidate::{Solved, touch, within_reach};
use crate::change::{Candidate, Move};
use crate::foothold_proposal::propose;
use crate::node::Node;
use crate::place_anew::one_by_one;
use crate::search::Search;

impl Search<'_> {
    /// The contacts of other limbs, as candidates, with which a change of a foot that failed may be possible.
    pub fn supports(&self, failed: &Candidate) -> Vec<Candidate> {
        let context = &self.context;
        let patch = failed.change.patch();
        if failed.tries > 0 || failed.is_variant() || context.foot(patch).is_none() {
            return Vec::new();
        }
        // From where both feet stand.
        let mut purpose = vec![failed.change.clone()];
        let mut index = failed.node;
        if let Move::Add(foothold) = &failed.change {
            let origin = self.nodes[failed.node].origin.as_ref();
            let lifted = origin
                .filter(|origin| matches!(origin.change, Move::Remove(left) if left == patch));
            let Some(lifted) = lifted.filter(|_| foothold.variation == 0) else {
                return Vec::new();
            };
            purpose.insert(0, lifted.change.clone());
            index = lifted.node;
        }
        let limbs = context.request.robot.patch_ids();
        let limbs = limbs.filter(|limb| context.is_used(*limb) && context.foot(*limb).is_none());
        limbs
            .flat_map(|limb| self.supports_of(limb, index, &purpose))
            .collect()
    }

    /// The same of one limb from a node.
    fn supports_of(&self, limb: PatchId, index: usize, purpose: &[Move]) -> Vec<Candidate> {
        let context = &self.context;
        let node = &self.nodes[index];
        let holds = node.holds(limb);
        let mut without = node.clone();
        if holds {
            without.contacts.retain(|c| c.patch != limb);
            without.depth += 1;
        }
        let without: &Node = &without;
        let feet = without.feet(context);
        let faces = within_reach(context, without, limb).into_iter();
        let footholds = faces.filter_map(|face| propose(context, without, &feet, limb, face, 0));
        let candidates = footholds.map(|foothold| {
            let touches = touch(context, index, without, foothold);
            let mut changes = vec![touches.change.clone()];
            if holds {
                changes.insert(0, Move::Remove(limb));
            }
            changes.extend_from_slice(purpose);
            Candidate {
                change: changes.remove(0),
                purpose: changes,
                ..touches
            }
        });
        candidates.collect()
    }

    /// Puts the changes of a contact together with what it is for on the frontier, where they have a posture.
    pub fn put_one_by_one(&mut self, candidate: Candidate, solved: Option<Solved>) {
        let outcome = solved.map(|solved| (solved.contacts, solved.outcome));
        let Some((asked, Outcome::Feasible(posture))) = outcome else {
            tracing::debug!(
                "node {}: no help of {:?}",
                candidate.node,
                candidate.change.patch()
            );
            self.staleness.count(candidate.node, None);
            self.nearest.1 += 1;
            return;
        };
        let mut changes = vec![candidate.change.clone()];
        changes.extend(candidate.purpose.iter().cloned());
        let first = one_by_one(changes, &asked, Arc::from(posture));
        first
            .into_iter()
            .for_each(|first| self.put(first(&candidate)));
    }
}
