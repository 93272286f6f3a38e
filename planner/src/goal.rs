//! The goal: constraints added to a node's posture problem.
//!
//! A node is final if that problem stays feasible. Source: [brossette2013] section II.

use posture::{BaseGoal, Contact, Outcome, Posture, Problem};

use crate::Error;
use crate::answer::Blocked;
use crate::comfort::comfortable;
use crate::grow::held;
use crate::node::{Node, fixed};
use crate::plan::Change;
use crate::request::Prepared;

/// What came of trying the goal at a node.
pub(crate) enum Attempt {
    /// The wanted contacts are not there, or the goal is out of reach of those that are.
    TooEarly,
    /// The goal's posture.
    Reached(Box<Posture>),
    /// The contacts are there, the posture is not.
    Missed(Blocked),
}

/// The node's posture problem with the goal's constraints, all contacts loaded.
///
/// # Errors
/// [`Error::Posture`] where the problem cannot be posed.
pub(crate) fn try_goal(
    prepared: &Prepared,
    config: &posture::Config,
    node: &Node,
) -> Result<Attempt, Error> {
    let request = prepared.request;
    let goal = &request.goal;
    let has_patches = goal.patches.iter().all(|&p| node.holds(p));
    let has_contacts = goal
        .contacts
        .iter()
        .all(|&(p, s)| node.contacts.iter().any(|c| c.patch == p && c.surface == s));
    // The feet have to come along: a body that leans over to its goal is not there.
    let behind = node.distance_m(prepared) > 0.5 * prepared.stride_m + goal.base.tolerance_m;
    if !has_patches || !has_contacts || behind || !near_goal(prepared, node, &goal.base) {
        return Ok(Attempt::TooEarly);
    }
    let contacts: Vec<Contact> = node
        .contacts
        .iter()
        .map(|held| fixed(prepared, held, true))
        .collect();
    let reference = comfortable(prepared, &contacts);
    let problem = Problem {
        robot: request.robot,
        environment: request.environment,
        contacts,
        base_goal: Some(goal.base.clone()),
        reference: &reference,
        guess: &node.posture.q,
    };
    // The node's posture is near: what other starts would find is another way to the goal.
    let config = posture::Config {
        restarts: 0,
        ..config.clone()
    };
    Ok(match posture::solve(&problem, &config)? {
        Outcome::Feasible(posture) => Attempt::Reached(posture),
        other => Attempt::Missed(Blocked {
            change: Change::Goal,
            held: held(prepared, node),
            reason: other
                .violation()
                .map_or_else(String::new, |v| v.describe(&problem)),
            distance_m: node.distance_m(prepared),
        }),
    })
}

/// Whether the base could be at the goal at all: within reach of every contact.
fn near_goal(prepared: &Prepared, node: &Node, goal: &BaseGoal) -> bool {
    node.contacts.iter().all(|held| {
        let p = held.X_WC.translation.vector;
        let apart: f64 = goal
            .position_m
            .iter()
            .zip(p.iter())
            .filter_map(|(g, x)| g.map(|g| (g - x).powi(2)))
            .sum();
        apart.sqrt() <= prepared.reach_m[held.patch] + goal.tolerance_m
    })
}
