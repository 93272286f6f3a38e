//! Best-first search over contact sets.
//!
//! The frontier holds *candidates*, not nodes: the best one is solved, and only a candidate that
//! has a posture becomes a node whose own candidates join the frontier. With several threads the
//! next best candidates are solved ahead of their turn; a solve depends on its candidate alone and
//! results are taken in the same order, so the tree is the same on any number of threads.
#![allow(non_snake_case)]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use posture::{BaseGoal, Contact, Outcome, Place, Posture, Problem};
use rayon::prelude::*;

use crate::candidate::{self, Candidate, Move};
use crate::node::{Held, Node, fixed, key};
use crate::plan::{Change, SearchSummary};
use crate::request::{Prepared, Request};
use crate::shorten::shorten;
use crate::{Config, Error};

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A sequence of stances to the goal.
    Found,
    /// Every contact set within reach was tried.
    NoPlan,
    /// A budget was spent first.
    BudgetSpent,
    /// The user stopped it.
    Interrupted,
}

/// How far the search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Contact sets with a posture.
    pub nodes: usize,
    /// Posture problems solved.
    pub solved: usize,
    /// Distance still to go along the guide path from the best contact set, m.
    pub best_distance_m: f64,
}

/// A contact change that could not be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocked {
    /// What was tried.
    pub change: Change,
    /// The contacts that the robot held.
    pub held: String,
    /// The constraint that fails, by how much.
    pub reason: String,
    /// How far from the goal it was along the guide path, m.
    pub distance_m: f64,
}

/// A stance on the way, with the contacts of its posture.
#[derive(Clone, Debug)]
pub struct PathStance {
    /// What changed.
    pub change: Change,
    /// Contacts of the posture problem: patch, surface, whether loaded.
    pub contacts: Vec<(usize, usize, bool)>,
    /// The posture.
    pub posture: Arc<Posture>,
}

/// What the search found.
#[derive(Clone, Debug)]
pub struct Answer {
    /// How it ended.
    pub status: Status,
    /// The stances to the goal, or to the best contact set where there is no plan.
    pub path: Vec<PathStance>,
    /// Counts.
    pub summary: SearchSummary,
    /// What blocks the way, nearest to the goal first; empty where a plan was found.
    pub blocked: Vec<Blocked>,
}

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
    let root = search.root()?;
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
        match search.child(&candidate, &contacts, outcome) {
            Some(node) if search.is_new(&node) => {
                let index = search.nodes.len();
                if let Some(last) = search.admit(node)? {
                    return search.answer(Status::Found, index, Some(last));
                }
            }
            _ => {}
        }
        let best = search.best();
        progress(Progress {
            nodes: search.nodes.len(),
            solved: search.solved,
            best_distance_m: search.distance(&search.nodes[best]),
        });
    }
}

impl<'a> Search<'a> {
    /// The start as a node: its contacts where the robot's own kinematics has them.
    fn root(&self) -> Result<Node, Error> {
        let request = self.prepared.request;
        let robot = request.robot;
        let configuration = &request.start.configuration;
        let kinematics = robot_model::Kinematics::new(robot, configuration);
        let mut contacts: Vec<Held> = request
            .start
            .contacts
            .iter()
            .map(|&(patch, surface)| Held {
                patch,
                surface,
                X_WC: kinematics.X_WC(&robot.patches[patch]),
            })
            .collect();
        contacts.sort_by_key(|c| c.patch);
        let problem = Problem {
            robot,
            environment: request.environment,
            contacts: contacts
                .iter()
                .map(|held| fixed(&self.prepared, held, true))
                .collect(),
            base_goal: None,
            reference: configuration,
            guess: configuration,
        };
        let posture = match posture::solve(&problem, self.posture_config)? {
            Outcome::Feasible(posture) => posture,
            other => {
                let reason = other
                    .violation()
                    .map_or_else(String::new, |v| v.describe(&problem));
                return Err(Error::Start { reason });
            }
        };
        let mut last = vec![None; robot.patches.len()];
        for held in &contacts {
            last[held.patch] = Some(held.X_WC.translation.vector);
        }
        Ok(Node {
            parent: None,
            depth: 0,
            change: Change::Start,
            touching: contacts.iter().map(|c| (c.clone(), true)).collect(),
            contacts,
            posture: Arc::new(*posture),
            last,
        })
    }

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
                candidate::solve(prepared, &nodes[candidate.node], &candidate.change, config)
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

    /// The node of a solved candidate; where it has no posture, why.
    fn child(
        &mut self,
        candidate: &Candidate,
        contacts: &[Contact],
        outcome: Outcome,
    ) -> Option<Node> {
        let request = self.prepared.request;
        let parent = &self.nodes[candidate.node];
        let change = self.describe(parent, &candidate.change);
        let posture = match outcome {
            Outcome::Feasible(posture) => posture,
            other => {
                let reason = other.violation().map_or_else(String::new, |v| {
                    v.describe(&Problem {
                        robot: request.robot,
                        environment: request.environment,
                        contacts: contacts.to_vec(),
                        base_goal: None,
                        reference: &request.reference,
                        guess: &request.reference,
                    })
                });
                let distance_m = self.distance(parent);
                tracing::debug!("node {}: {change:?}: {reason}", candidate.node);
                self.blocked.push(Blocked {
                    change,
                    held: self.held(parent),
                    reason,
                    distance_m,
                });
                return None;
            }
        };
        let touching: Vec<(Held, bool)> = contacts
            .iter()
            .zip(&posture.contacts)
            .map(|(contact, state)| {
                // A fixed contact stays to the bit where it was put.
                let X_WC = match &contact.place {
                    Place::Fixed { X_WC, .. } => *X_WC,
                    Place::OnSurface { .. } => state.X_WC,
                };
                let surface = contact.place.surface().unwrap_or(usize::MAX);
                (
                    Held {
                        patch: contact.patch,
                        surface,
                        X_WC,
                    },
                    contact.loaded,
                )
            })
            .collect();
        let removed = match candidate.change {
            Move::Remove { patch } => Some(patch),
            Move::Add { .. } => None,
        };
        let mut set: Vec<Held> = touching
            .iter()
            .map(|(held, _)| held.clone())
            .filter(|held| Some(held.patch) != removed)
            .collect();
        set.sort_by_key(|c| c.patch);
        let mut last = parent.last.clone();
        for held in &set {
            last[held.patch] = Some(held.X_WC.translation.vector);
        }
        tracing::debug!(
            "node {} from {}: {change:?}",
            self.nodes.len(),
            candidate.node
        );
        Some(Node {
            parent: Some(candidate.node),
            depth: parent.depth + 1,
            change,
            contacts: set,
            touching,
            posture: Arc::new(*posture),
            last,
        })
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
        if let Some(posture) = self.at_goal(&node)? {
            self.nodes.push(node);
            return Ok(Some(posture));
        }
        for candidate in candidate::children(&self.prepared, index, &node) {
            let rank = Rank::new(candidate.priority, self.counted);
            self.counted += 1;
            self.frontier.insert(rank, (candidate, None));
        }
        self.nodes.push(node);
        Ok(None)
    }

    /// The node's posture problem with the goal's constraints, all contacts loaded.
    fn at_goal(&mut self, node: &Node) -> Result<Option<Posture>, Error> {
        let request = self.prepared.request;
        let goal = &request.goal;
        let has_patches = goal.patches.iter().all(|&p| node.holds(p));
        let has_contacts = goal
            .contacts
            .iter()
            .all(|&(p, s)| node.contacts.iter().any(|c| c.patch == p && c.surface == s));
        if !has_patches || !has_contacts || !self.near_goal(node, &goal.base) {
            return Ok(None);
        }
        let contacts: Vec<Contact> = node
            .contacts
            .iter()
            .map(|held| fixed(&self.prepared, held, true))
            .collect();
        let reference = candidate::comfortable(&self.prepared, &contacts);
        let problem = Problem {
            robot: request.robot,
            environment: request.environment,
            contacts,
            base_goal: Some(goal.base.clone()),
            reference: &reference,
            guess: &node.posture.q,
        };
        self.solved += 1;
        match posture::solve(&problem, self.posture_config)? {
            Outcome::Feasible(posture) => Ok(Some(*posture)),
            other => {
                let reason = other
                    .violation()
                    .map_or_else(String::new, |v| v.describe(&problem));
                tracing::debug!("at the goal, but {reason}");
                self.blocked.push(Blocked {
                    change: Change::Goal,
                    held: self.held(node),
                    reason,
                    distance_m: self.distance(node),
                });
                Ok(None)
            }
        }
    }

    /// Whether the base could be at the goal at all: within reach of every contact.
    fn near_goal(&self, node: &Node, goal: &BaseGoal) -> bool {
        node.contacts.iter().all(|held| {
            let p = held.X_WC.translation.vector;
            let apart: f64 = goal
                .position_m
                .iter()
                .zip(p.iter())
                .filter_map(|(g, x)| g.map(|g| (g - x).powi(2)))
                .sum();
            apart.sqrt() <= self.prepared.reach_m[held.patch] + goal.tolerance_m
        })
    }

    /// Distance along the guide path that the feet still have to go, on the mean, m.
    fn distance(&self, node: &Node) -> f64 {
        let end = self.prepared.request.guide.length_m();
        let feet = node.feet(&self.prepared);
        let behind: f64 = feet.iter().map(|f| (end - f.along_m).max(0.0)).sum();
        behind / feet.len().max(1) as f64
    }

    /// The node that is nearest to the goal.
    fn best(&self) -> usize {
        (0..self.nodes.len())
            .min_by(|&a, &b| {
                self.distance(&self.nodes[a])
                    .total_cmp(&self.distance(&self.nodes[b]))
            })
            .unwrap_or(0)
    }

    fn describe(&self, parent: &Node, change: &Move) -> Change {
        let request = self.prepared.request;
        let surface_id = |s: usize| {
            request
                .environment
                .surfaces
                .get(s)
                .map_or_else(String::new, |s| s.id.clone())
        };
        match *change {
            Move::Remove { patch } => Change::Remove {
                patch: request.robot.patches[patch].name.clone(),
                surface: parent
                    .contacts
                    .iter()
                    .find(|c| c.patch == patch)
                    .map_or_else(String::new, |c| surface_id(c.surface)),
            },
            Move::Add { patch, surface, .. } => Change::Add {
                patch: request.robot.patches[patch].name.clone(),
                surface: surface_id(surface),
            },
        }
    }

    fn held(&self, node: &Node) -> String {
        let request = self.prepared.request;
        node.contacts
            .iter()
            .map(|c| {
                let surface = request
                    .environment
                    .surfaces
                    .get(c.surface)
                    .map_or("", |s| s.id.as_str());
                format!("{} on {surface}", request.robot.patches[c.patch].name)
            })
            .collect::<Vec<_>>()
            .join(", ")
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
        let mut path: Vec<PathStance> = way.iter().map(stance).collect();
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

/// A node as a stance on the way.
fn stance(node: &Node) -> PathStance {
    PathStance {
        change: node.change.clone(),
        contacts: node
            .touching
            .iter()
            .map(|(held, loaded)| (held.patch, held.surface, *loaded))
            .collect(),
        posture: node.posture.clone(),
    }
}
