//! What the search gives back.

use std::sync::Arc;

use motion::{MotionContext, Segment};
use nalgebra::Vector3;
use posture::{Contact, Posture, Relaxation};

use crate::node::Node;
use crate::request::Request;
use plan::{Barrier, Change, SearchSummary, Trace};

/// How the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A sequence of stances to the goal.
    Found,
    /// There is none, by a proof that needs no search.
    NoPlan,
    /// Everything was tried that the search thinks of: samples of places, which leave open whether there
    /// is one.
    Exhausted,
    /// A budget was spent first.
    BudgetSpent,
    /// The user stopped it.
    Interrupted,
}

/// How far the search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Contact sets with a posture, and the most that there may be.
    pub nodes: usize,
    /// See [`Self::nodes`].
    pub nodes_max: usize,
    /// Stances of the way to the best contact set, and with what is estimated to follow.
    pub stances: usize,
    /// See [`Self::stances`].
    pub stances_about: usize,
    /// Posture problems solved.
    pub solved: usize,
    /// Distance still to go along the guide path from the best contact set, m.
    pub best_distance_m: f64,
    /// What is done next.
    pub stage: Stage,
}

/// What the planner does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It searches for a sequence of contact sets.
    Search,
    /// It looks for the motions between the stances of a sequence that it found.
    Motion {
        /// As many are known.
        known: usize,
        /// Of so many.
        of: usize,
    },
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
    /// By how much it fails where that is a constraint of a posture, scaled as
    /// [`posture::Violation::amount`] is.
    pub amount: Option<f64>,
    /// How far from the goal it was along the route, m.
    pub distance_m: f64,
    /// Whether it is proved that it cannot be made from there, at the place that was tried.
    pub proof: bool,
    /// The one limit that is too tight, and what it would have to be, where that was looked for and is so.
    pub remedy: Option<Relaxation>,
    /// What refuses it, and where in the tree; nothing where no contact set was tried.
    pub(crate) tried: Option<Tried>,
}

/// Where in the tree a change was tried.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tried {
    /// The node.
    pub node: usize,
    /// Where the contact was to be made, or was, in W, m.
    pub at_W: Vector3<f64>,
    /// The price of the change, in contacts.
    pub price: f64,
    /// The contacts that no posture was found for; empty where something else fails.
    pub asked: Vec<Contact>,
    /// What refuses it.
    pub by: Barrier,
}

impl Blocked {
    /// Why no way leads to the goal, whatever is held.
    pub(crate) fn of_goal(reason: String, proof: bool) -> Self {
        Self {
            change: Change::Goal,
            held: String::new(),
            reason,
            amount: None,
            distance_m: 0.0,
            proof,
            remedy: None,
            tried: None,
        }
    }
}

/// A stance on the way, with the contacts of its posture.
#[derive(Clone, Debug)]
pub struct PathStance {
    /// What changed.
    pub change: Change,
    /// The contacts of the posture problem, settled.
    pub contacts: Vec<Contact>,
    /// The posture.
    pub posture: Arc<Posture>,
}

/// What the search found.
#[derive(Clone, Debug)]
pub struct SearchResult {
    /// How it ended.
    pub status: Status,
    /// The stances to the goal, or to the best contact set where there is no plan.
    pub path: Vec<PathStance>,
    /// The ways of the motion from each stance to the next, where there is a plan.
    pub segments: Vec<Segment>,
    /// The motion along the path, where there is a plan of more than one stance and it was [timed](Self::timed).
    pub motion: Option<plan::Motion>,
    /// Counts.
    pub summary: SearchSummary,
    /// What blocks the way, nearest to the goal first; empty where a plan was found.
    pub blocked: Vec<Blocked>,
    /// The tree, what was refused, and why the contacts of the path were chosen.
    pub trace: Trace,
}

impl SearchResult {
    /// With the motion along its path, in the shortest time that the limits allow; for the request that it is of.
    #[must_use]
    pub fn timed(
        self,
        request: &Request,
        posture: &posture::Config,
        config: &motion::Config,
    ) -> Self {
        let (robot, environment) = (request.robot, request.environment);
        let context = MotionContext::new(robot, environment, posture, config);
        let segments: Vec<&Segment> = self.segments.iter().collect();
        let motion = (!segments.is_empty()).then(|| motion::assemble(&context, &segments));
        Self { motion, ..self }
    }
}

impl From<&Node> for PathStance {
    fn from(node: &Node) -> Self {
        Self {
            change: node.change.clone(),
            contacts: node.touching.clone(),
            posture: node.posture.clone(),
        }
    }
}
