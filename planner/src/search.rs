//! Best-first search over contact sets.
//!
//! The frontier holds *candidates*, not nodes: the best one is solved, and only a candidate that
//! has a posture becomes a node whose own candidates join the frontier. With several threads the
//! next best candidates are solved ahead of their turn; a solve depends on its candidate alone and
//! results are taken in the same order, so the tree is the same on any number of threads.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use motion::MotionContext;
use posture::Posture;
use rayon::prelude::*;

use crate::candidate::{self, Candidate, touch};
use crate::context::SearchContext;
use crate::foothold_proposal::alternatives;
use crate::goal::{Attempt, try_goal};
use crate::motions::Motions;
use crate::node::{Key, Node, key};
use crate::node_construction;
use crate::request::Request;
use crate::result::{Blocked, Progress, SearchResult, Stage, Status};
use crate::steepness::too_steep;
use crate::{Config, Error};
use plan::{Change, SearchSummary};

/// Order of the frontier: priority, then the number of the candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rank(u64, usize);

impl Rank {
    fn new(priority: f64, number: usize) -> Self {
        // Priorities are finite and not negative: their bits have their order.
        Self(priority.max(0.0).to_bits(), number)
    }
}

/// Price of a second try at a candidate, from other seeds, in contacts.
const RETRY_PRICE: f64 = 3.0;

type Solved = Result<candidate::Solved, Error>;

pub(crate) struct Search<'a> {
    pub context: SearchContext<'a>,
    pub posture_config: &'a posture::Config,
    pub motions: Motions<'a>,
    pub nodes: Vec<Node>,
    /// Nodes that no motion leads to, by index.
    pub dead: BTreeSet<usize>,
    frontier: BTreeMap<Rank, (Candidate, Option<Solved>)>,
    counted: usize,
    seen: BTreeSet<Key>,
    pub blocked: Vec<Blocked>,
    expanded: BTreeSet<usize>,
    pub solved: usize,
}

/// Searches for a sequence of stances from the start to the goal.
///
/// `progress` is called after every solved candidate; `cancel` stops the search, which then gives
/// the way to the best contact set found so far.
///
/// # Errors
/// [`Error`] where the request makes no sense or the start is no stance.
///
/// Source: best-first planning of [escande2013] as used in [brossette2013]; deviation: candidates
/// are solved one at a time in the order of an estimate instead of all children of a node.
pub fn search(
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<SearchResult, Error> {
    let context = SearchContext::new(request, config)?;
    motion_config.validate()?;
    let mut search = Search {
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
        frontier: BTreeMap::new(),
        counted: 0,
        seen: BTreeSet::new(),
        blocked: Vec::new(),
        expanded: BTreeSet::new(),
        solved: 0,
    };
    let root = node_construction::root(&search.context, posture_config)?;
    if let Some(blocked) = too_steep(&search.context, posture_config.friction_use) {
        search.nodes.push(root);
        search.blocked.push(blocked);
        return Ok(search.give_up(Status::NoPlan));
    }
    if let Some(last) = search.admit(root)?
        && let Some(answer) = search.finalize(0, last, progress)?
    {
        return Ok(answer);
    }
    loop {
        if cancel.load(Ordering::Relaxed) {
            return Ok(search.give_up(Status::Interrupted));
        }
        if search.nodes.len() >= config.nodes_max || search.solved >= config.candidates_max {
            return Ok(search.give_up(Status::BudgetSpent));
        }
        let Some((candidate, solved)) = search.next() else {
            return Ok(search.give_up(Status::NoPlan));
        };
        search.solved += 1;
        search.expanded.insert(candidate.node);
        let solved = solved?;
        let parent = &search.nodes[candidate.node];
        let child = node_construction::child(
            &search.context,
            &candidate,
            parent,
            solved.contacts,
            solved.outcome,
        );
        match (child, solved.lift_off_blocked) {
            (Ok(node), Some(reason)) => {
                search.block(candidate.node, node.change.clone(), reason);
                search.add_alternatives(&node, candidate.node);
            }
            (Ok(node), None) if search.is_new(&node) => {
                tracing::debug!(
                    "node {} from {}: {:?}",
                    search.nodes.len(),
                    candidate.node,
                    node.change
                );
                let index = search.nodes.len();
                if let Some(last) = search.admit(node)?
                    && let Some(answer) = search.finalize(index, last, progress)?
                {
                    return Ok(answer);
                }
            }
            (Ok(_), None) => {}
            (Err(blocked), _) if !candidate.retry => {
                // The reason so far, should its second turn never come.
                search.blocked.push(blocked);
                search.put(Candidate {
                    priority: candidate.priority + RETRY_PRICE,
                    retry: true,
                    ..candidate
                });
            }
            (Err(blocked), _) => {
                tracing::debug!(
                    "node {}: {:?}: {}",
                    candidate.node,
                    blocked.change,
                    blocked.reason
                );
                search.blocked.push(blocked);
            }
        }
        progress(search.progress(Stage::Search));
    }
}

impl<'a> Search<'a> {
    /// Takes the best candidate off the frontier, solved; solves the next best ones with it where
    /// there are threads for them.
    fn next(&mut self) -> Option<(Candidate, Solved)> {
        let threads = rayon::current_num_threads();
        let (_, (_, first)) = self.frontier.first_key_value()?;
        if first.is_none() {
            let due: Vec<(Rank, Candidate)> = self
                .frontier
                .iter()
                .filter(|(_, (_, solved))| solved.is_none())
                .take(threads)
                .map(|(rank, (candidate, _))| (*rank, candidate.clone()))
                .collect();
            let (context, nodes) = (&self.context, &self.nodes);
            let motion = &self.motions.context;
            let solve = |candidate: &Candidate| {
                candidate::solve(context, motion, &nodes[candidate.node], candidate)
            };
            let results: Vec<(Rank, Solved)> = if due.len() > 1 {
                due.par_iter().map(|(rank, c)| (*rank, solve(c))).collect()
            } else {
                due.iter().map(|(rank, c)| (*rank, solve(c))).collect()
            };
            for (rank, result) in results {
                if let Some(entry) = self.frontier.get_mut(&rank) {
                    entry.1 = Some(result);
                }
            }
        }
        let (_, (candidate, solved)) = self.frontier.pop_first()?;
        Some((candidate, solved?))
    }

    /// Whether the contact set was not reached before, to the cell.
    fn is_new(&mut self, node: &Node) -> bool {
        self.seen.insert(key(&node.contacts))
    }

    /// Adds a node and its candidates; the goal's posture if the node fulfils it.
    fn admit(&mut self, node: Node) -> Result<Option<Arc<Posture>>, Error> {
        let index = self.nodes.len();
        if index == 0 {
            self.seen.insert(key(&node.contacts));
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
                self.blocked.push(blocked);
            }
        }
        self.nodes.push(node);
        self.branch(index);
        Ok(None)
    }

    /// Notes what cannot be done at a node, and why.
    pub fn block(&mut self, node: usize, change: Change, reason: String) {
        tracing::debug!("node {node}: {change:?}: {reason}");
        self.blocked.push(Blocked {
            change,
            held: self.nodes[node].describe(&self.context),
            reason,
            distance_m: self.nodes[node].distance_m(&self.context),
        });
    }

    /// Adds candidates of the parent that touch beside where `node` does, which no motion leads to.
    pub fn add_alternatives(&mut self, node: &Node, parent: usize) {
        let before = &self.nodes[parent];
        let made = node.contacts.iter().find(|c| !before.holds(c.patch));
        let Some(made) = made.filter(|_| !node.alternative) else {
            return;
        };
        let places = alternatives(&self.context, made).into_iter();
        let candidates: Vec<Candidate> = places
            .map(|foothold| Candidate {
                alternative: true,
                ..touch(&self.context, parent, before, foothold)
            })
            .collect();
        for candidate in candidates {
            self.put(candidate);
        }
    }

    /// Adds a node's candidates to the frontier.
    pub fn branch(&mut self, index: usize) {
        for candidate in candidate::children(&self.context, index, &self.nodes[index]) {
            self.put(candidate);
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
                self.seen.remove(&key(&self.nodes[i].contacts));
            }
        }
        let dead = &self.dead;
        self.frontier
            .retain(|_, (candidate, _)| !dead.contains(&candidate.node));
    }

    /// How far the search is.
    pub fn progress(&self, stage: Stage) -> Progress {
        Progress {
            nodes: self.nodes.len(),
            solved: self.solved,
            best_distance_m: self.nodes[self.best()].distance_m(&self.context),
            stage,
        }
    }

    /// Puts a candidate on the frontier.
    fn put(&mut self, candidate: Candidate) {
        let rank = Rank::new(candidate.priority, self.counted);
        self.counted += 1;
        self.frontier.insert(rank, (candidate, None));
    }

    /// The node that is nearest to the goal.
    pub fn best(&self) -> usize {
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
        SearchSummary {
            nodes_generated: self.nodes.len(),
            nodes_expanded: self.expanded.len(),
            candidates_solved: self.solved,
            path_stances,
        }
    }
}
