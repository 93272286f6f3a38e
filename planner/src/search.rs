//! Best-first search over contact sets.
//!
//! The frontier holds *candidates*, not nodes: the best one is solved, and only a candidate that
//! has a posture becomes a node whose own candidates join the frontier. With several threads the
//! next best candidates are solved ahead of their turn; a solve depends on its candidate alone and
//! results are taken in the same order, so the tree is the same on any number of threads.

mod step;

use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};
use std::sync::Arc;

use posture::Posture;
use rayon::prelude::*;

use crate::change::{Candidate, Move};
use crate::context::SearchContext;
use crate::frontier::{Frontier, Outcome, Rank};
use crate::goal::{Attempt, try_goal};
use crate::motions::Motions;
use crate::node::{ChangeKey, Key, Node, change_key, key};
use crate::result::{Blocked, Progress, SearchResult, Stage, Tried};
use crate::staleness::Staleness;
use crate::{Error, candidate};
use plan::{Barrier, SearchSummary};

/// Price of a change from where the motion of another failed, in contacts.
const FAILURE_PRICE: f64 = 1.0;
/// Price of a change that failed before from a like contact set reached in another way, each time, in
/// contacts.
const FAILED_PRICE: f64 = 1.5;
/// Price of a metre by which the base is lower than legs go down as usual, in contacts: what reaches so far
/// rarely goes on, and the motion to there mostly fails.
const CROUCH_PRICE: f64 = 40.0;
/// Tries without coming nearer to the goal after which every other candidate is chosen by a smaller weight of
/// what is estimated to follow.
const PATIENCE: usize = 40;
const STUCK_WEIGHT: f64 = 1.0;

/// What hears how far a search is.
pub(crate) type Told<'t> = &'t (dyn Fn(Progress) + Sync);

pub(crate) struct Search<'a> {
    pub context: SearchContext<'a>,
    pub posture_config: &'a posture::Config,
    pub motions: Motions<'a>,
    pub nodes: Vec<Node>,
    /// Nodes that no motion leads to, by index.
    pub dead: BTreeSet<usize>,
    pub frontier: Frontier,
    pub staleness: Staleness,
    /// The least estimate to the goal of a node, in contacts, and the tries since it was reached.
    pub nearest: (f64, usize),
    /// The least number of changes to every contact set that was reached, to the cell.
    pub seen: BTreeMap<Key, usize>,
    /// The best plan so far.
    pub best: Option<SearchResult>,
    /// Its nodes.
    pub best_way: Vec<usize>,
    /// The last node that had the goal's posture.
    pub reached: Option<usize>,
    /// Nodes and posture problems up to which a plan is looked for and, once there is one, a shorter one.
    pub budget: [usize; 2],
    /// A number of contact changes that no plan falls short of.
    pub changes_min: usize,
    pub blocked: Vec<Blocked>,
    /// The nodes from which a change had no posture or no motion, by contact set and change.
    pub failed: BTreeMap<(Key, ChangeKey), BTreeSet<usize>>,
    pub expanded: BTreeSet<usize>,
    pub solved: usize,
    /// What searches along other ways spent, as in [`Self::spent`].
    pub elsewhere: [usize; 3],
}

impl<'a> Search<'a> {
    /// Takes the best candidate off the frontier, solved; solves the next best ones with it where
    /// there are threads for them.
    ///
    /// Where motions failed, and where much was tried already, others come first: a candidate is solved
    /// when its turn has come at the price that it has by then.
    fn next(&mut self) -> Option<(Candidate, Outcome)> {
        if self.best.is_none() && self.nearest.1 > PATIENCE && self.solved.is_multiple_of(2) {
            let less = self.context.weight - STUCK_WEIGHT;
            let (candidate, outcome) = self.frontier.pop_by(|c| c.priority - less * c.rest)?;
            let (context, motion) = (&self.context, &self.motions.context);
            let solve =
                || candidate::solve(context, motion, &self.nodes[candidate.node], &candidate);
            let outcome = outcome.unwrap_or_else(solve);
            return Some((candidate, outcome));
        }
        loop {
            let (first, is_solved) = self.frontier.first()?;
            let charge = self.charge(first);
            let is_useful = self.could_be_better(self.nodes[first.node].depth + 1);
            if is_useful && first.charged >= charge {
                if !is_solved {
                    self.solve_ahead();
                }
                let (candidate, outcome) = self.frontier.pop()?;
                return Some((candidate, outcome?));
            }
            let (candidate, outcome) = self.frontier.pop()?;
            if is_useful {
                let candidate = Candidate {
                    priority: candidate.priority + charge - candidate.charged,
                    charged: charge,
                    ..candidate
                };
                self.frontier.put(candidate, outcome);
            }
        }
    }

    /// Solves the best candidates that are not solved, as many as there are threads.
    fn solve_ahead(&mut self) {
        let due = self.frontier.due(rayon::current_num_threads());
        let (context, nodes) = (&self.context, &self.nodes);
        let motion = &self.motions.context;
        let solve = |(rank, candidate): &(Rank, Candidate)| {
            let node = &nodes[candidate.node];
            (*rank, candidate::solve(context, motion, node, candidate))
        };
        let results: Vec<(Rank, Outcome)> = match due.len() {
            0..=1 => due.iter().map(solve).collect(),
            _ => due.par_iter().map(solve).collect(),
        };
        for (rank, result) in results {
            self.frontier.solved(rank, result);
        }
    }

    /// How many other nodes of the same contact set a change failed from.
    pub fn failed_elsewhere(&self, candidate: &Candidate) -> usize {
        let set = key(&self.context, &self.nodes[candidate.node].contacts);
        let failed = self
            .failed
            .get(&(set, change_key(&self.context, &candidate.change)));
        let others = failed.into_iter().flatten();
        others.filter(|&&other| other != candidate.node).count()
    }

    /// What a candidate costs for what failed or came no nearer about its node, in contacts; nothing more where
    /// it was planned together with those that follow: what failed there is what they mend, and that they end
    /// in a posture is known, which of all others is a guess.
    fn charge(&self, candidate: &Candidate) -> f64 {
        if candidate.then.is_some() {
            return candidate.charged;
        }
        let node = &self.nodes[candidate.node];
        FAILURE_PRICE * node.failures as f64
            + CROUCH_PRICE * node.crouch_m
            + FAILED_PRICE * self.failed_elsewhere(candidate) as f64
            + self.staleness.price(candidate.node)
    }

    /// Remembers that a change failed from a node: from its contact set, reached in another way, it waits.
    pub fn remember(&mut self, node: usize, change: &Move) {
        let set = key(&self.context, &self.nodes[node].contacts);
        let failed = self.failed.entry((set, change_key(&self.context, change)));
        failed.or_default().insert(node);
    }

    /// Whether the contact set was not reached before, to the cell; while a plan is improved, by as few
    /// changes.
    fn is_new(&mut self, node: &Node) -> bool {
        let known = self.seen.entry(key(&self.context, &node.contacts));
        let is_new = match &known {
            Entry::Vacant(_) => true,
            Entry::Occupied(least) => self.best.is_some() && node.depth < *least.get(),
        };
        if is_new {
            known.insert_entry(node.depth);
        }
        is_new
    }

    /// Adds a node and its candidates; the goal's posture if the node fulfils it.
    fn admit(&mut self, node: Node) -> Result<Option<Arc<Posture>>, Error> {
        let index = self.nodes.len();
        if index == 0 {
            self.seen.insert(key(&self.context, &node.contacts), 0);
        }
        match try_goal(&self.context, self.posture_config, &node)? {
            Attempt::TooEarly => {}
            Attempt::Reached(posture) => {
                self.solved += 1;
                self.nodes.push(node);
                return Ok(Some(posture));
            }
            Attempt::Missed(blocked) => {
                self.solved += 1;
                tracing::debug!("node {index} misses the goal: {}", blocked.reason);
                let tried = Some(Tried {
                    node: index,
                    at_W: node.posture.q.p_WB,
                    price: node.price,
                    asked: Vec::new(),
                    by: Barrier::Goal,
                });
                self.blocked.push(Blocked { tried, ..*blocked });
            }
        }
        self.nodes.push(node);
        self.branch(index);
        Ok(None)
    }

    /// Adds a node's candidates to the frontier.
    pub fn branch(&mut self, index: usize) {
        for candidate in candidate::children(&self.context, index, &self.nodes[index]) {
            self.put(candidate);
        }
    }

    /// How far the search is.
    pub fn progress(&self, stage: Stage) -> Progress {
        let best = &self.nodes[self.nearest()];
        let rest = best.rest(&self.context);
        let [nodes, _, solved] = self.spent();
        Progress {
            nodes,
            nodes_max: self.budget[0],
            stances: best.depth + 1,
            stances_about: best.depth + 1 + rest.ceil() as usize,
            solved,
            best_distance_m: best.distance_m(&self.context),
            stage,
        }
    }

    /// Puts a candidate on the frontier.
    pub fn put(&mut self, candidate: Candidate) {
        self.frontier.put(candidate, None);
    }

    /// The node that is nearest to the goal.
    pub fn nearest(&self) -> usize {
        (0..self.nodes.len())
            .filter(|i| !self.dead.contains(i))
            .min_by(|&a, &b| {
                let distance = |i: usize| self.nodes[i].distance_m(&self.context);
                distance(a).total_cmp(&distance(b))
            })
            .unwrap_or(0)
    }

    /// Counts of what was done.
    pub fn summary(&self, path_stances: usize) -> SearchSummary {
        let route = self.context.route.poses().iter();
        let [nodes_generated, nodes_expanded, candidates_solved] = self.spent();
        SearchSummary {
            nodes_generated,
            nodes_expanded,
            candidates_solved,
            path_stances,
            changes_min: self.changes_min,
            route: route
                .map(|pose| [pose.p.x, pose.p.y, pose.p.z, pose.heading])
                .collect(),
            unsolved: None,
        }
    }
}
