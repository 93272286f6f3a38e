//! The motions of the tree's edges: asked for a few changes behind where the search is, and what becomes
//! of those that have none.

use motion::Failure;
use plan::{Barrier, Change};

use crate::Error;
use crate::change::Candidate;
use crate::node::{Node, key};
use crate::result::{Blocked, PathStance, Tried};
use crate::search::Search;

/// Part of a motion up to which a failure is one of taking off.
const TAKE_OFF: f64 = 0.2;
/// A contact change is given its motion once the search has gone on by as many from there, or at all where
/// that of another change from the same stance failed: what has none is cut before much grows on it, and not
/// every leaf is given one.
const SETTLED_BEHIND: usize = 2;

impl Search<'_> {
    /// Notes what has a posture and no motion from a node, and why.
    pub fn block(&mut self, node: usize, child: Option<Node>, reason: String) {
        let change = child
            .as_ref()
            .map_or(Change::Goal, |child| child.change.clone());
        tracing::debug!("node {node}: {change:?}: {reason}");
        let tried = Tried {
            node,
            at_W: child
                .as_ref()
                .unwrap_or(&self.nodes[node])
                .changed_W(&self.context),
            price: child.as_ref().unwrap_or(&self.nodes[node]).price,
            asked: Vec::new(),
            by: Barrier::Motion,
        };
        self.blocked.push(Blocked {
            change,
            held: self.nodes[node].describe(&self.context),
            reason,
            distance_m: self.nodes[node].distance_m(&self.context),
            amount: None,
            proof: false,
            remedy: None,
            tried: Some(tried),
        });
    }

    /// Gives the contact changes on the way to a node their motions, but for the last few; whether
    /// all have one. One that has none is cut.
    pub fn settle(&mut self, node: usize) -> Result<bool, Error> {
        let ancestors = std::iter::successors(Some(node), |&i| self.nodes[i].parent);
        let fails = |parent: usize| self.nodes[parent].failures > 0;
        let open = ancestors.enumerate().filter(|&(behind, i)| {
            let node = &self.nodes[i];
            !node.settled && (behind >= SETTLED_BEHIND || node.parent.is_some_and(fails))
        });
        let mut open: Vec<usize> = open.map(|(_, i)| i).collect();
        while let Some(index) = open.pop() {
            let Some(parent) = self.nodes[index].parent else {
                continue;
            };
            let pair = [parent, index].map(|i| PathStance::from(&self.nodes[i]));
            if let Some((_, failure)) = self.motions.along(&pair, &|_, _| {})? {
                let child = self.nodes[index].clone();
                let reason = format!("no motion: {}", failure.describe());
                self.block(parent, Some(child), reason);
                self.mend(index, &failure);
                self.cut(index);
                return Ok(false);
            }
            self.nodes[index].settled = true;
        }
        Ok(true)
    }

    /// Learns from a node that has no motion from its parent: what else is tried from there comes
    /// later, and where the patch cannot take off, the parent's own posture is sought once more, near
    /// to the one that it should lead to.
    pub fn mend(&mut self, index: usize, failure: &Failure) {
        let Some(parent) = self.nodes[index].parent else {
            return;
        };
        self.nodes[parent].failures += 1;
        let change = self.nodes[index].origin.as_ref().map(|o| o.change.clone());
        change
            .iter()
            .for_each(|change| self.remember(parent, change));
        if failure.at > TAKE_OFF {
            return;
        }
        let posture = self.nodes[index].posture.clone();
        let origin = self.nodes[parent].origin.take();
        if let Some(origin) = origin.filter(|origin| origin.near.is_none()) {
            self.put(Candidate {
                near: Some(posture),
                ..origin
            });
        }
    }

    /// Takes a node and all that came of it out of the tree; its contact set may be reached in
    /// another way.
    pub fn cut(&mut self, index: usize) {
        self.dead.insert(index);
        // Parents come before children.
        for i in index..self.nodes.len() {
            if self.nodes[i].parent.is_some_and(|p| self.dead.contains(&p)) {
                self.dead.insert(i);
            }
            if self.dead.contains(&i) {
                self.seen
                    .remove(&key(&self.context, &self.nodes[i].contacts));
            }
        }
        let dead = &self.dead;
        self.frontier
            .retain(|candidate| !dead.contains(&candidate.node));
    }
}
