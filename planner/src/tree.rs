//! What a search leaves behind that another may go on with.

use std::collections::{BTreeMap, BTreeSet};

use motion::{MotionContext, keeps_off};

use crate::frontier::Frontier;
use crate::lattice::Preference;
use crate::motions::Known;
use crate::node::{ChangeKey, Key, Node};
use crate::result::{Blocked, SearchResult};
use crate::route::Route;
use crate::staleness::Staleness;

/// What a search grew that has found a plan.
pub struct Tree {
    /// Bodies of the surroundings that it was begun in.
    pub(crate) bodies: usize,
    pub(crate) preference: Preference,
    pub(crate) route: Route,
    pub(crate) nodes: Vec<Node>,
    pub(crate) dead: BTreeSet<usize>,
    pub(crate) frontier: Frontier,
    pub(crate) staleness: Staleness,
    pub(crate) seen: BTreeMap<Key, usize>,
    pub(crate) changes_min: usize,
    pub(crate) blocked: Vec<Blocked>,
    pub(crate) failed: BTreeMap<(Key, ChangeKey), BTreeSet<usize>>,
    pub(crate) expanded: BTreeSet<usize>,
    pub(crate) solved: usize,
    pub(crate) elsewhere: [usize; 3],
    pub(crate) motions: Known,
    /// The node that has the goal's posture.
    pub(crate) reached: usize,
}

impl Tree {
    /// Nodes, nodes of which children were tried, and posture problems, with those of searches along other ways.
    pub(crate) fn spent(&self) -> [usize; 3] {
        let here = [self.nodes.len(), self.expanded.len(), self.solved];
        std::array::from_fn(|k| here[k] + self.elsewhere[k])
    }

    /// Whether the first half of the way that was found is clear of the bodies that were not there then.
    pub(crate) fn keeps_most(&self, context: &MotionContext) -> bool {
        let bodies = self.bodies..context.environment.world().obstacles().len();
        let way = std::iter::successors(Some(self.reached), |&i| self.nodes[i].parent);
        let mut way: Vec<usize> = way.collect();
        way.reverse();
        let first = way[..way.len().div_ceil(2)].iter();
        let postures = first.map(|&i| &self.nodes[i].posture.q);
        keeps_off(context, postures, &bodies)
    }

    /// What another search found and grew, counted with what this one spent.
    pub(crate) fn and(
        &self,
        mut result: SearchResult,
        mut other: Option<Self>,
    ) -> (SearchResult, Option<Self>) {
        let spent = self.spent();
        let summary = &mut result.summary;
        summary.nodes_generated += spent[0];
        summary.nodes_expanded += spent[1];
        summary.candidates_solved += spent[2];
        if let Some(other) = &mut other {
            other.elsewhere = std::array::from_fn(|k| other.elsewhere[k] + spent[k]);
        }
        (result, other)
    }
}
