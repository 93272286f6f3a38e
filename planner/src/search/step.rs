//! How a search begins, and what becomes of each candidate.

use std::collections::BTreeSet;
use std::collections::btree_map::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use motion::MotionContext;
use nalgebra::Vector3;

use crate::change::Candidate;
use crate::context::SearchContext;
use crate::estimate::at_least;
use crate::frontier::Frontier;
use crate::motions::Motions;
use crate::out_of_reach::out_of_reach;
use crate::result::{Blocked, Stage, Status};
use crate::staleness::Staleness;
use crate::steepness::{steep_on_the_way, too_steep};
use crate::{Error, candidate, node_construction};

use super::{Search, Told};

/// Price of another try at a candidate, from other seeds, in contacts, where the first came nowhere
/// near; less where it fails by less than so much.
const RETRY_PRICE: f64 = 3.0;
const FAR: f64 = 0.02;
/// Price of another place of a foot on a face where the one before has a posture, in contacts: what does
/// not go on from there rarely goes on from beside it, and every place has its own hands to try.
const SECOND_PRICE: f64 = 2.0;
/// Nodes and posture problems that are spent at most where even the longest steps lead nowhere, or the way leads over what
/// does not hold: that is no proof, but it is rarely wrong.
const GAP_NODES: usize = 40;
const GAP_SOLVED: usize = 100;

impl<'a> Search<'a> {
    /// A search without nodes.
    pub fn bare(
        context: SearchContext<'a>,
        posture_config: &'a posture::Config,
        motion_config: &'a motion::Config,
    ) -> Self {
        let (request, config) = (context.request, context.config);
        let asked = [config.nodes_max, config.candidates_max];
        Self {
            budget: asked.map(|most| context.budget(most)),
            context,
            posture_config,
            motions: Motions::new(MotionContext {
                robot: request.robot,
                environment: request.environment,
                posture: posture_config,
                config: motion_config,
            }),
            nodes: Vec::new(),
            dead: BTreeSet::new(),
            frontier: Frontier::default(),
            staleness: Staleness::new(),
            nearest: (f64::INFINITY, 0),
            seen: BTreeMap::new(),
            best: None,
            best_way: Vec::new(),
            reached: None,
            changes_min: 0,
            blocked: Vec::new(),
            failed: BTreeMap::new(),
            expanded: BTreeSet::new(),
            solved: 0,
            elsewhere: [0; 3],
        }
    }

    /// A search that has looked at the start; with how it ends where that says so.
    pub fn begin(
        context: SearchContext<'a>,
        posture_config: &'a posture::Config,
        motion_config: &'a motion::Config,
        progress: Told,
    ) -> Result<(Self, Option<Status>), Error> {
        let mut search = Self::bare(context, posture_config, motion_config);
        let gap = search.context.gap.clone();
        let gap = gap.map(|gap| Blocked::of_goal(gap, false));
        let doubt = gap.or_else(|| steep_on_the_way(&search.context));
        if doubt.is_some() {
            let config = search.context.config;
            search.budget = [
                config.nodes_max.min(GAP_NODES),
                config.candidates_max.min(GAP_SOLVED),
            ];
        }
        search.blocked.extend(doubt);
        let root = node_construction::root(&search.context, posture_config)?;
        let proof =
            out_of_reach(&search.context, &root.contacts).or_else(|| too_steep(&search.context));
        if let Some(blocked) = proof {
            search.nodes.push(root);
            search.blocked.clear();
            search.blocked.push(blocked);
            return Ok((search, Some(Status::NoPlan)));
        }
        search.changes_min = at_least(&search.context, &root.contacts);
        if let Some(last) = search.admit(root)? {
            search.finalize(0, last, progress)?;
        }
        Ok((search, None))
    }

    /// Nodes, nodes of which children were tried, and posture problems so far, with those of searches along other ways.
    pub fn spent(&self) -> [usize; 3] {
        let here = [self.nodes.len(), self.expanded.len(), self.solved];
        std::array::from_fn(|k| here[k] + self.elsewhere[k])
    }

    /// The least estimate to the goal of a node, in contacts; infinite where nothing is left to try.
    pub fn rest(&self) -> f64 {
        match self.frontier.first() {
            Some(_) => self.nearest.0,
            None => f64::INFINITY,
        }
    }

    /// Where the base was to go from the node that is nearest to the goal, in W, m.
    pub fn stuck_W(&self) -> Vector3<f64> {
        let along_m = self.nodes[self.nearest()].along_m(&self.context);
        let ahead_m = along_m + self.context.stride_m;
        self.context.route.at(ahead_m).p
    }

    /// Goes on until so many nodes are there, or so many posture problems solved, and no plan; how it ends where it does
    /// before.
    pub fn run(
        &mut self,
        [nodes, solved]: [usize; 2],
        progress: Told,
        cancel: &AtomicBool,
    ) -> Result<Option<Status>, Error> {
        while self.best.is_some() || (self.nodes.len() < nodes && self.solved < solved) {
            if let Some(status) = self.step(progress, cancel)? {
                return Ok(Some(status));
            }
            progress(self.progress(Stage::Search));
        }
        Ok(None)
    }

    /// Solves the best candidate; how the search ends where it does.
    fn step(&mut self, progress: Told, cancel: &AtomicBool) -> Result<Option<Status>, Error> {
        if self.is_done() {
            return Ok(Some(Status::Found));
        }
        if cancel.load(Ordering::Relaxed) {
            return Ok(Some(Status::Interrupted));
        }
        if self.best.is_none() && self.is_spent() {
            return Ok(Some(Status::BudgetSpent));
        }
        let Some((candidate, solved)) = self.next() else {
            return Ok(Some(Status::Exhausted));
        };
        self.solved += 1;
        self.expanded.insert(candidate.node);
        let solved = solved?;
        if !self.settle(candidate.node)? {
            return Ok(None);
        }
        if !candidate.purpose.is_empty() {
            self.put_one_by_one(candidate, solved);
            return Ok(None);
        }
        let parent = &self.nodes[candidate.node];
        let is_first = candidate.tries == 0 && !candidate.is_variant();
        let next = candidate::next_place(&self.context, parent, &candidate).filter(|_| is_first);
        let Some(solved) = solved else {
            self.staleness.count(candidate.node, None);
            next.into_iter().for_each(|next| self.put(next));
            return Ok(None);
        };
        let (contacts, outcome) = (solved.contacts, solved.outcome);
        let nearest = outcome.nearest().map(|posture| posture.q.clone());
        let child = node_construction::child(&self.context, &candidate, parent, contacts, outcome);
        if let Some(mut next) = next {
            let is_foot = self.context.foot(next.change.patch()).is_some();
            if is_foot && child.is_ok() && solved.lift_off_blocked.is_none() {
                next.priority += SECOND_PRICE;
            }
            self.put(next);
        }
        let blocked = solved.lift_off_blocked;
        let is_node = blocked.is_none() && child.is_ok();
        let reached = child.as_ref().ok().filter(|_| is_node);
        let rest = reached.map(|node| node.rest(&self.context));
        let begins = self.staleness.count(candidate.node, rest);
        match rest {
            Some(rest) if rest < self.nearest.0 => self.nearest = (rest, 0),
            _ => self.nearest.1 += 1,
        }
        match (child, blocked) {
            (Ok(node), Some(reason)) => {
                self.block(candidate.node, Some(node), reason);
            }
            (Ok(node), None) if self.is_new(&node) || candidate.is_variant() => {
                tracing::debug!(
                    "node {} from {}: {:?}",
                    self.nodes.len(),
                    candidate.node,
                    node.change
                );
                let index = self.nodes.len();
                self.staleness.push(begins);
                self.follow(&candidate, index);
                if let Some(last) = self.admit(node)? {
                    self.finalize(index, last, progress)?;
                }
            }
            (Ok(_), None) => {}
            (Err(blocked), _) => {
                tracing::debug!(
                    "node {}: {:?}: {}",
                    candidate.node,
                    blocked.change,
                    blocked.reason
                );
                self.remember(candidate.node, &candidate.change);
                let open = !blocked.proof && !candidate.is_spent();
                let anew = self.place_anew(&candidate, blocked.amount, nearest.as_ref())?;
                anew.into_iter().for_each(|anew| self.put(anew));
                let supports = self.supports(&candidate);
                supports.into_iter().for_each(|support| self.put(support));
                let missed = blocked.amount.map_or(1.0, |m| (m / FAR).min(1.0));
                // The reason so far, should its next turn never come.
                self.blocked.push(*blocked);
                if open {
                    self.put(Candidate {
                        priority: candidate.priority + RETRY_PRICE * missed,
                        tries: candidate.tries + 1,
                        ..candidate
                    });
                }
            }
        }
        Ok(None)
    }
}
