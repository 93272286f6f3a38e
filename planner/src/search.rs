//! Best-first search over contact sets.
//!
//! The frontier holds *candidates*, not nodes: the best one is solved, and only a candidate that
//! has a posture becomes a node whose own candidates join the frontier. With several threads the
//! next best candidates are solved ahead of their turn; a solve depends on its candidate alone and
//! results are taken in the same order, so the tree is the same on any number of threads.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use motion::{Failure, MotionContext};
use posture::Posture;
use rayon::prelude::*;

use crate::candidate;
use crate::change::Candidate;
use crate::context::SearchContext;
use crate::goal::{Attempt, try_goal};
use crate::motions::Motions;
use crate::node::{Key, Node, key};
use crate::node_construction;
use crate::out_of_reach::out_of_reach;
use crate::request::Request;
use crate::result::{Blocked, PathStance, Progress, SearchResult, Stage, Status};
use crate::staleness::Staleness;
use crate::steepness::too_steep;
use crate::way;
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

/// Price of another try at a candidate, from other seeds, in contacts, where the first came nowhere
/// near; less where it fails by less than so much.
const RETRY_PRICE: f64 = 3.0;
const FAR: f64 = 0.02;
/// Price of another place of a foot on a face where the one before has a posture, in contacts: what does
/// not go on from there rarely goes on from beside it, and every place has its own hands to try.
const SECOND_PRICE: f64 = 2.0;
/// Price of a change from where the motion of another failed, in contacts.
const FAILURE_PRICE: f64 = 1.0;
/// Part of a motion up to which a failure is one of taking off.
const TAKE_OFF: f64 = 0.2;
/// A contact change is given its motion once the search has gone on by as many from there: what has
/// none is cut before much grows on it, and not every leaf is given one.
const SETTLED_BEHIND: usize = 2;

type Solved = Result<Option<candidate::Solved>, Error>;

pub(crate) struct Search<'a> {
    pub context: SearchContext<'a>,
    pub posture_config: &'a posture::Config,
    pub motions: Motions<'a>,
    pub nodes: Vec<Node>,
    /// Nodes that no motion leads to, by index.
    pub dead: BTreeSet<usize>,
    frontier: BTreeMap<Rank, (Candidate, Option<Solved>)>,
    counted: usize,
    staleness: Staleness,
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
/// Source: best-first planning of \[escande2013\] as used in \[brossette2013\]; deviation: candidates
/// are solved one at a time in the order of an estimate instead of all children of a node.
pub fn search(
    request: &Request,
    config: &Config,
    posture_config: &posture::Config,
    motion_config: &motion::Config,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<SearchResult, Error> {
    let context = way::laid(SearchContext::new(request, config, posture_config)?);
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
        staleness: Staleness::new(),
        seen: BTreeSet::new(),
        blocked: Vec::new(),
        expanded: BTreeSet::new(),
        solved: 0,
    };
    search.blocked.extend(search.context.no_way());
    let root = node_construction::root(&search.context, posture_config)?;
    let proof = out_of_reach(&search.context)
        .or_else(|| too_steep(&search.context, posture_config.friction_use));
    if let Some(blocked) = proof {
        search.nodes.push(root);
        search.blocked.clear();
        search.blocked.push(blocked);
        return Ok(search.give_up(Status::NoPlan));
    }
    if let Some(last) = search.admit(root)?
        && let Some(answer) = search.finalize(0, last, progress)?
    {
        return Ok(answer);
    }
    let nodes_max = search.context.budget(config.nodes_max);
    let solved_max = search.context.budget(config.candidates_max);
    loop {
        if cancel.load(Ordering::Relaxed) {
            return Ok(search.give_up(Status::Interrupted));
        }
        if search.nodes.len() >= nodes_max || search.solved >= solved_max {
            return Ok(search.give_up(Status::BudgetSpent));
        }
        let Some((candidate, solved)) = search.next() else {
            let proved = search.blocked.iter().all(|blocked| blocked.proof);
            let status = if proved {
                Status::NoPlan
            } else {
                Status::Exhausted
            };
            return Ok(search.give_up(status));
        };
        // Where motions failed, and where much was tried already, others wait.
        let charge = search.charge(&candidate);
        if candidate.charged < charge {
            let priority = candidate.priority + charge - candidate.charged;
            let (rank, solved) = (search.rank(priority), Some(solved));
            let candidate = Candidate {
                priority,
                charged: charge,
                ..candidate
            };
            search.frontier.insert(rank, (candidate, solved));
            continue;
        }
        search.solved += 1;
        search.expanded.insert(candidate.node);
        let solved = solved?;
        if !search.settle(candidate.node)? {
            continue;
        }
        let parent = &search.nodes[candidate.node];
        let is_first = candidate.tries == 0 && candidate.near.is_none();
        let next = candidate::next_place(&search.context, parent, &candidate).filter(|_| is_first);
        let Some(solved) = solved else {
            search.staleness.count(candidate.node, None);
            next.into_iter().for_each(|next| search.put(next));
            continue;
        };
        let (contacts, outcome) = (solved.contacts, solved.outcome);
        let child =
            node_construction::child(&search.context, &candidate, parent, contacts, outcome);
        if let Some(mut next) = next {
            let is_foot = search.context.foot(next.change.patch()).is_some();
            if is_foot && child.is_ok() && solved.lift_off_blocked.is_none() {
                next.priority += SECOND_PRICE;
            }
            search.put(next);
        }
        let blocked = solved.lift_off_blocked;
        let is_node = blocked.is_none() && child.is_ok();
        let estimate = child.as_ref().ok().filter(|_| is_node);
        let estimate = estimate.map(|node| search.context.estimate(&node.feet(&search.context)));
        let begins = search.staleness.count(candidate.node, estimate);
        match (child, blocked) {
            (Ok(node), Some(reason)) => {
                search.block(candidate.node, node.change.clone(), reason);
            }
            (Ok(node), None) if search.is_new(&node) || candidate.near.is_some() => {
                tracing::debug!(
                    "node {} from {}: {:?}",
                    search.nodes.len(),
                    candidate.node,
                    node.change
                );
                let index = search.nodes.len();
                search.staleness.push(begins);
                if let Some(last) = search.admit(node)?
                    && let Some(answer) = search.finalize(index, last, progress)?
                {
                    return Ok(answer);
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
                let open = !blocked.proof && !candidate.is_spent();
                let missed = blocked.amount.map_or(1.0, |m| (m / FAR).min(1.0));
                // The reason so far, should its next turn never come.
                search.blocked.push(*blocked);
                if open {
                    search.put(Candidate {
                        priority: candidate.priority + RETRY_PRICE * missed,
                        tries: candidate.tries + 1,
                        ..candidate
                    });
                }
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

    /// What a candidate costs for what failed or came no nearer about its node, in contacts.
    fn charge(&self, candidate: &Candidate) -> f64 {
        let node = &self.nodes[candidate.node];
        FAILURE_PRICE * node.failures as f64 + self.staleness.price(candidate.node)
    }

    /// Whether the contact set was not reached before, to the cell.
    fn is_new(&mut self, node: &Node) -> bool {
        self.seen.insert(key(&self.context, &node.contacts))
    }

    /// Adds a node and its candidates; the goal's posture if the node fulfils it.
    fn admit(&mut self, node: Node) -> Result<Option<Arc<Posture>>, Error> {
        let index = self.nodes.len();
        if index == 0 {
            self.seen.insert(key(&self.context, &node.contacts));
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
            amount: None,
            proof: false,
        });
    }

    /// Gives the contact changes on the way to a node their motions, but for the last few; whether
    /// all have one. One that has none is cut.
    fn settle(&mut self, node: usize) -> Result<bool, Error> {
        let ancestors = std::iter::successors(Some(node), |&i| self.nodes[i].parent);
        let open = ancestors.skip(SETTLED_BEHIND);
        let mut open: Vec<usize> = open.take_while(|&i| !self.nodes[i].settled).collect();
        while let Some(index) = open.pop() {
            let Some(parent) = self.nodes[index].parent else {
                continue;
            };
            let pair = [parent, index].map(|i| PathStance::from(&self.nodes[i]));
            if let Some((_, failure)) = self.motions.along(&pair)? {
                let change = self.nodes[index].change.clone();
                self.block(parent, change, format!("no motion: {}", failure.describe()));
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
                self.seen
                    .remove(&key(&self.context, &self.nodes[i].contacts));
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
        let rank = self.rank(candidate.priority);
        self.frontier.insert(rank, (candidate, None));
    }

    /// The rank of the next candidate.
    fn rank(&mut self, priority: f64) -> Rank {
        self.counted += 1;
        Rank::new(priority, self.counted)
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
        let route = self.context.route.poses().iter();
        SearchSummary {
            nodes_generated: self.nodes.len(),
            nodes_expanded: self.expanded.len(),
            candidates_solved: self.solved,
            path_stances,
            route: route
                .map(|pose| [pose.p.x, pose.p.y, pose.p.z, pose.heading])
                .collect(),
            unsolved: None,
        }
    }
}
