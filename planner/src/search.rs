//! Best-first search over contact sets.
//!
//! The frontier holds *candidates*, not nodes: the best one is solved, and only a candidate that
//! has a posture becomes a node whose own candidates join the frontier. With several threads the
//! next best candidates are solved ahead of their turn; a solve depends on its candidate alone and
//! results are taken in the same order, so the tree is the same on any number of threads.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use posture::{Contact, Outcome, Posture};
use rayon::prelude::*;

use crate::answer::{Answer, Blocked, PathStance, Progress, Status};
use crate::candidate::{self, Candidate};
use crate::goal::{Attempt, try_goal};
use crate::grow;
use crate::node::{Node, key};
use crate::plan::{Change, SearchSummary};
use crate::request::{Prepared, Request};
use crate::shorten::shorten;
use crate::{Config, Error};

/// Order of the frontier: priority, then the number of the candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rank(u64, usize);

impl Rank {
    fn new(priority: f64, number: usize) -> Self {
        // Priorities are finite and not negative: their bits have their order.
        Self(priority.max(0.0).to_bits(), number)
    }
}

type Solved = Result<(Vec<Contact>, Outcome), posture::Error>;

struct Search<'a> {
    prepared: Prepared<'a>,
    posture_config: &'a posture::Config,
    nodes: Vec<Node>,
    frontier: BTreeMap<Rank, (Candidate, Option<Solved>)>,
    counted: usize,
    seen: BTreeSet<Vec<(usize, usize, [i64; 3])>>,
    blocked: Vec<Blocked>,
    expanded: BTreeSet<usize>,
    solved: usize,
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
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Answer, Error> {
    let prepared = Prepared::new(request, config)?;
    let mut search = Search {
        prepared,
        posture_config,
        nodes: Vec::new(),
        frontier: BTreeMap::new(),
        counted: 0,
        seen: BTreeSet::new(),
        blocked: Vec::new(),
        expanded: BTreeSet::new(),
        solved: 0,
    };
    let root = grow::root(&search.prepared, posture_config)?;
    if let Some(last) = search.admit(root)? {
        return search.answer(Status::Found, 0, Some(last));
    }
    loop {
        if cancel.load(Ordering::Relaxed) {
            let best = search.best();
            return search.answer(Status::Interrupted, best, None);
        }
        if search.nodes.len() >= config.nodes_max || search.solved >= config.candidates_max {
            let best = search.best();
            return search.answer(Status::BudgetSpent, best, None);
        }
        let Some((candidate, solved)) = search.next() else {
            let best = search.best();
            return search.answer(Status::NoPlan, best, None);
        };
        search.solved += 1;
        search.expanded.insert(candidate.node);
        let (contacts, outcome) = solved?;
        let parent = &search.nodes[candidate.node];
        match grow::child(&search.prepared, &candidate, parent, &contacts, outcome) {
            Ok(node) if search.is_new(&node) => {
                tracing::debug!(
                    "node {} from {}: {:?}",
                    search.nodes.len(),
                    candidate.node,
                    node.change
                );
                let index = search.nodes.len();
                if let Some(last) = search.admit(node)? {
                    return search.answer(Status::Found, index, Some(last));
                }
            }
            Ok(_) => {}
            Err(_) if !candidate.again && config.posture_restarts > 0 => {
                search.put(Candidate {
                    priority: candidate.priority + config.again_price,
                    again: true,
                    ..candidate
                });
            }
            Err(blocked) => {
                tracing::debug!(
                    "node {}: {:?}: {}",
                    candidate.node,
                    blocked.change,
                    blocked.reason
                );
                search.blocked.push(blocked);
            }
        }
        let best = search.best();
        progress(Progress {
            nodes: search.nodes.len(),
            solved: search.solved,
            best_distance_m: search.nodes[best].distance_m(&search.prepared),
        });
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
            let (prepared, nodes, config) = (&self.prepared, &self.nodes, self.posture_config);
            let solve = |candidate: &Candidate| {
                candidate::solve(prepared, &nodes[candidate.node], candidate, config)
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
        // A foot in the air is where it was last: leaving from two places makes two sets.
        let mut state = key(&node.contacts, self.prepared.config.same_place_m);
        state.sort();
        self.seen.insert(state)
    }

    /// Adds a node and its candidates; the goal's posture if the node fulfils it.
    fn admit(&mut self, node: Node) -> Result<Option<Posture>, Error> {
        let index = self.nodes.len();
        if index == 0 {
            self.seen
                .insert(key(&node.contacts, self.prepared.config.same_place_m));
        }
        match try_goal(&self.prepared, self.posture_config, &node)? {
            Attempt::TooEarly => {}
            Attempt::Reached(posture) => {
                self.solved += 1;
                self.nodes.push(node);
                return Ok(Some(*posture));
            }
            Attempt::Missed(blocked) => {
                self.solved += 1;
                tracing::debug!("node {index} misses the goal: {}", blocked.reason);
                self.blocked.push(blocked);
            }
        }
        for candidate in candidate::children(&self.prepared, index, &node) {
            self.put(candidate);
        }
        self.nodes.push(node);
        Ok(None)
    }

    /// Puts a candidate on the frontier.
    fn put(&mut self, candidate: Candidate) {
        let rank = Rank::new(candidate.priority, self.counted);
        self.counted += 1;
        self.frontier.insert(rank, (candidate, None));
    }

    /// The node that is nearest to the goal.
    fn best(&self) -> usize {
        (0..self.nodes.len())
            .min_by(|&a, &b| {
                let distance = |i: usize| self.nodes[i].distance_m(&self.prepared);
                distance(a).total_cmp(&distance(b))
            })
            .unwrap_or(0)
    }

    /// The way from the root to a node, shortened, and the goal's posture after it.
    fn answer(
        mut self,
        status: Status,
        index: usize,
        last: Option<Posture>,
    ) -> Result<Answer, Error> {
        let mut way = Vec::new();
        let mut at = Some(index);
        while let Some(i) = at {
            way.push(self.nodes[i].clone());
            at = self.nodes[i].parent;
        }
        way.reverse();
        if status == Status::Found {
            let (shorter, solved) = shorten(&self.prepared, self.posture_config, way)?;
            way = shorter;
            self.solved += solved;
        }
        let path_stances = way.len();
        let mut path: Vec<PathStance> = way.iter().map(PathStance::from).collect();
        if let Some(posture) = last {
            let held = &self.nodes[index].contacts;
            path.push(PathStance {
                change: Change::Goal,
                contacts: held.iter().map(|c| (c.patch, c.surface, true)).collect(),
                posture: Arc::new(posture),
            });
        }
        let mut blocked = std::mem::take(&mut self.blocked);
        if status == Status::Found {
            blocked.clear();
        }
        blocked.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        Ok(Answer {
            status,
            path,
            summary: SearchSummary {
                nodes_generated: self.nodes.len(),
                nodes_expanded: self.expanded.len(),
                candidates_solved: self.solved,
                path_stances,
            },
            blocked,
        })
    }
}
