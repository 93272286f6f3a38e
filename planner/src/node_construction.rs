//! Nodes: the root from the robot's own kinematics, children from solved candidates.

use std::sync::Arc;

use plan::{Barrier, Change};
use posture::{Constraint, Contact, Freedom, Outcome, Posture, Problem};
use robot_model::Kinematics;

use crate::Error;
use crate::change::{Candidate, Move};
use crate::context::SearchContext;
use crate::node::Node;
use crate::nominal_posture::nominal_posture;
use crate::result::{Blocked, Tried};

/// Legs go down by this part of their height as usual.
const CROUCHED: f64 = 0.25;

/// The start as a node: its contacts where the robot's own kinematics has them.
pub(crate) fn root(context: &SearchContext, config: &posture::Config) -> Result<Node, Error> {
    let request = context.request;
    let robot = request.robot;
    let configuration = &request.start.configuration;
    let contacts = request.start.touching(robot, request.environment);
    let problem = context.problem(contacts.clone(), configuration, configuration);
    // As it stands, with nothing in reserve; then as near to that as the margins allow.
    feasible(posture::solve(&problem, &as_it_stands(config))?, &problem)
        .map_err(|reason| Error::Start { reason })?;
    let posture = feasible(posture::solve(&problem, config)?, &problem)
        .map_err(|reason| Error::Start { reason })?;
    let contacts = rolling(context, contacts, &posture);
    let mut footing = vec![None; robot.patches.len()];
    for contact in &contacts {
        let (place, yaw) = (context.place_W(contact), context.yaw(contact));
        let standing = context.footing(contact.patch, &place, yaw, Some(0.0));
        footing[contact.patch.index()] = Some(standing);
    }
    let kinematics = Kinematics::new(robot, &posture.q);
    for foot in request.start.in_air() {
        let place = robot.patches[foot].touched_W(&kinematics.X_WC(&robot.patches[foot]));
        footing[foot.index()] = Some(context.footing(foot, &place, None, Some(0.0)));
    }
    Ok(Node {
        parent: None,
        depth: 0,
        change: Change::Start,
        touching: contacts.clone(),
        contacts,
        posture,
        footing,
        origin: None,
        price: 0.0,
        crouch_m: 0.0,
        failures: 0,
        settled: true,
    })
}

/// Why a posture cannot be where a ball has rolled beside the face that it was put on; nothing where none has.
pub(crate) fn rolled_off(
    context: &SearchContext,
    contacts: &[Contact],
    posture: &Posture,
) -> Option<String> {
    let request = context.request;
    let rolls = contacts.iter().zip(&posture.contacts);
    let mut rolls = rolls.filter(|(contact, _)| contact.stood_WB.is_some());
    rolls.find_map(|(contact, state)| {
        let patch = &request.robot.patches[contact.patch];
        let touched_W = patch.touched_W(&state.X_WC).into();
        let (beside_m, _) = request.environment.distances_m(contact.face?, &touched_W)?;
        (beside_m > 0.0).then(|| {
            let on = contact.describe(request.robot, request.environment);
            format!("{on} rolls off it by {:.1} mm", 1e3 * beside_m)
        })
    })
}

/// Contacts of which the balls that have not stood before roll from where a posture has them.
fn rolling(context: &SearchContext, mut contacts: Vec<Contact>, posture: &Posture) -> Vec<Contact> {
    let robot = context.request.robot;
    let kinematics = Kinematics::new(robot, &posture.q);
    for contact in &mut contacts {
        let patch = &robot.patches[contact.patch];
        if patch.point_radius_m().is_some() {
            let stands_WB = kinematics.X_WB[patch.body].rotation;
            contact.stood_WB = contact.stood_WB.or(Some(stands_WB));
        }
    }
    contacts
}

/// The posture of an outcome, or the constraint that fails, in words.
pub(crate) fn feasible(outcome: Outcome, problem: &Problem) -> Result<Arc<Posture>, String> {
    match outcome {
        Outcome::Feasible(posture) => Ok(Arc::new(*posture)),
        Outcome::Infeasible(violation) | Outcome::Undecided { violation, .. } => {
            Err(violation.describe(problem))
        }
    }
}

/// Settings that leave the configuration where it is and ask for no margin: what holds then holds
/// as the robot stands.
fn as_it_stands(config: &posture::Config) -> posture::Config {
    /// No step to speak of.
    const STILL: f64 = 1e-9;
    posture::Config {
        friction_use: 1.0,
        torque_use: 1.0,
        joint_margin_rad: 0.0,
        clearance_m: 0.0,
        self_clearance_m: 0.0,
        com_margin_m: 0.0,
        solver: posture::Solver {
            step_scale: STILL,
            ..config.solver
        },
        restarts: 0,
        ..config.clone()
    }
}

/// The node of a solved candidate; where it has no posture, why.
pub(crate) fn child(
    context: &SearchContext,
    candidate: &Candidate,
    parent: &Node,
    asked: Vec<Contact>,
    outcome: Outcome,
) -> Result<Node, Box<Blocked>> {
    let change = describe(context, parent, &candidate.change);
    let reference = &context.request.reference;
    let problem = context.problem(asked, reference, reference);
    let proof = matches!(outcome, Outcome::Infeasible(_));
    let amount = outcome.violation().map(|v| v.amount);
    let tried = outcome.violation().map(|v| Tried {
        node: candidate.node,
        at_W: parent.place_of_W(&candidate.change),
        price: candidate.price(context.weight),
        asked: problem.contacts.clone(),
        by: barrier(&v.constraint),
    });
    let posture = feasible(outcome, &problem).and_then(|posture| {
        let off = rolled_off(context, &problem.contacts, &posture);
        off.map_or(Ok(posture), Err)
    });
    let posture = match posture {
        Ok(posture) => posture,
        Err(reason) => {
            return Err(Box::new(Blocked {
                change,
                held: parent.describe(context),
                reason,
                distance_m: parent.distance_m(context),
                amount,
                proof,
                remedy: None,
                tried,
            }));
        }
    };
    let places = problem.contacts.iter().zip(&posture.contacts);
    let touching = places.map(|(contact, state)| match contact.freedom {
        // A fixed contact stays to the bit where it was put.
        Freedom::Fixed => contact.clone(),
        _ => contact.placed(state.X_WC),
    });
    let touching = rolling(context, touching.collect(), &posture);
    let removed = |c: &Contact| matches!(candidate.change, Move::Remove(patch) if patch == c.patch);
    let stay = touching.iter().filter(|c| !removed(c)).cloned();
    let mut contacts: Vec<Contact> = stay.map(|c| c.loaded(true)).collect();
    contacts.sort_by_key(|c| c.patch);
    let mut footing = parent.footing.clone();
    if let Move::Add(foothold) = &candidate.change {
        let made = contacts.iter().filter(|c| c.patch == foothold.patch);
        for contact in made {
            let (place, yaw) = (context.place_W(contact), context.yaw(contact));
            let near = Some(foothold.along_m);
            let standing = context.footing(contact.patch, &place, yaw, near);
            footing[contact.patch.index()] = Some(standing);
        }
    }
    let mut child = Node {
        parent: Some(candidate.node),
        depth: parent.depth + 1,
        change,
        contacts,
        touching,
        posture,
        footing,
        origin: Some(candidate.clone()),
        price: candidate.price(context.weight),
        crouch_m: 0.0,
        failures: 0,
        settled: false,
    };
    let usual = nominal_posture(context, &child.contacts, child.along_m(context));
    let heights = context.feet.iter().map(|foot| -context.offset(*foot).z);
    let low_m = usual.p_WB.z - CROUCHED * heights.fold(0.0, f64::max);
    child.crouch_m = (low_m - child.posture.q.p_WB.z).max(0.0);
    Ok(child)
}

/// What a constraint that fails stands for.
fn barrier(constraint: &Constraint) -> Barrier {
    match constraint {
        Constraint::Closure(_) => Barrier::Reach,
        Constraint::Inclusion(_) => Barrier::Room,
        Constraint::Equilibrium | Constraint::Balance => Barrier::Balance,
        Constraint::Friction(_) => Barrier::Friction,
        Constraint::Torque(_) => Barrier::Torque,
        Constraint::JointLimit(_) => Barrier::JointLimit,
        Constraint::SelfClearance(..) | Constraint::Clearance(..) => Barrier::Collision,
        Constraint::BaseGoal => Barrier::Goal,
        Constraint::BaseTilt => Barrier::Tilt,
    }
}

/// A move in the names of patch and face.
pub(crate) fn describe(context: &SearchContext, parent: &Node, change: &Move) -> Change {
    let request = context.request;
    let patch = request.robot.patches[change.patch()].name.clone();
    let name = |face| request.environment[face].id.clone();
    match change {
        Move::Remove(released) => {
            let held = parent.contacts.iter().find(|c| c.patch == *released);
            Change::Remove {
                patch,
                face: held.and_then(|c| c.face).map(name).unwrap_or_default(),
            }
        }
        Move::Add(foothold) => Change::Add {
            patch,
            face: name(foothold.face),
        },
    }
}
