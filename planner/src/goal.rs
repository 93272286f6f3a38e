//! The goal: constraints added to a node's posture problem.
//!
//! A node is final if that problem stays feasible. Source: [brossette2013] section II.

use std::sync::Arc;

use plan::Change;
use posture::{BaseGoal, Posture, Problem};

use crate::Error;
use crate::context::SearchContext;
use crate::node::Node;
use crate::node_construction::feasible;
use crate::nominal_posture::nominal_posture;
use crate::reserve::solve_with_reserve;
use crate::result::Blocked;

/// Weight of the base's tilt at the goal, 1/rad², and the part of the bound on tilts that it keeps to: who has
/// arrived stands upright, whatever the legs have to turn for it, or takes another step.
const STANDING: f64 = 5.0;
const STANDING_TILT: f64 = 0.6;

/// What came of trying the goal at a node.
pub(crate) enum Attempt {
    /// The wanted contacts are not there, or the goal is out of reach of those that are.
    TooEarly,
    /// The goal's posture.
    Reached(Arc<Posture>),
    /// The contacts are there, the posture is not.
    Missed(Box<Blocked>),
}

/// The node's posture problem with the goal's constraints, all contacts loaded.
///
/// # Errors
/// [`Error::Posture`] where the problem cannot be posed.
pub(crate) fn try_goal(
    context: &SearchContext,
    config: &posture::Config,
    node: &Node,
) -> Result<Attempt, Error> {
    let goal = &context.request.goal;
    let has_patches = goal.patches.iter().all(|&p| node.holds(p));
    let has = |patch, face| {
        let mut contacts = node.contacts.iter();
        contacts.any(|c| c.patch == patch && c.face == Some(face))
    };
    let has_contacts = goal.contacts.iter().all(|&(patch, face)| has(patch, face));
    // Every foot has to come along: a body that leans over to its goal is not there.
    let end = context.route.length_m();
    let near_m = context.stride_m.max(goal.beside_m);
    let behind = node.feet(context).iter().any(|f| end - f.along_m > near_m);
    if !has_patches || !has_contacts || behind || !near_goal(context, node, &goal.base) {
        return Ok(Attempt::TooEarly);
    }
    let feet = node
        .contacts
        .iter()
        .filter(|c| context.foot(c.patch).is_some());
    let feet = feet.map(|c| (c.patch, context.place_W(c)));
    let usual = || nominal_posture(context, &node.contacts, node.along_m(context));
    let wanted = context.goal_stance.as_ref().map(|wanted| wanted.over(feet));
    let guess = wanted.as_ref().unwrap_or(&node.posture.q).clone();
    let reference = wanted.unwrap_or_else(usual);
    let problem = Problem {
        base_goal: Some(goal.base.clone()),
        joint_goal: goal.joints.as_ref(),
        ..context.problem(node.contacts.clone(), &reference, &guess)
    };
    let mut upright = context.upright(&reference);
    upright.tilt_max_rad *= STANDING_TILT;
    // The node's posture is near: what other seeds would find is another way to the goal.
    let config = posture::Config {
        restarts: 0,
        solver: posture::Solver {
            upright: Some(upright),
            ..config.solver
        },
        weight_base: config.weight_base.max(STANDING),
        ..config.clone()
    };
    let outcome = solve_with_reserve(&problem, &config)?;
    Ok(match feasible(outcome, &problem) {
        Ok(posture) => Attempt::Reached(posture),
        Err(reason) => Attempt::Missed(Box::new(Blocked {
            change: Change::Goal,
            held: node.describe(context),
            reason,
            distance_m: node.distance_m(context),
            amount: None,
            proof: false,
            remedy: None,
            tried: None,
        })),
    })
}

/// Whether the base could be at the goal at all: within reach of every contact.
fn near_goal(context: &SearchContext, node: &Node, goal: &BaseGoal) -> bool {
    node.contacts.iter().all(|held| {
        let wanted = goal.position_m.iter();
        let pairs = wanted.zip(held.X_WC.translation.vector.iter());
        let apart: f64 = pairs.filter_map(|(g, x)| g.map(|g| (g - x).powi(2))).sum();
        apart.sqrt() <= context.reach.base_m(held.patch) + goal.tolerance_m
    })
}
