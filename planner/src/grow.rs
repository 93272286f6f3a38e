//! Nodes: the root from the robot's own kinematics, children from solved candidates.
#![allow(non_snake_case)]

use std::sync::Arc;

use posture::{Contact, Outcome, Place, Problem};

use crate::Error;
use crate::answer::Blocked;
use crate::candidate::{Candidate, Move};
use crate::node::{Held, Node, fixed};
use crate::plan::Change;
use crate::request::Prepared;

/// The start as a node: its contacts where the robot's own kinematics has them.
pub(crate) fn root(prepared: &Prepared, config: &posture::Config) -> Result<Node, Error> {
    let request = prepared.request;
    let robot = request.robot;
    let configuration = &request.start.configuration;
    let kinematics = robot_model::Kinematics::new(robot, configuration);
    let mut contacts: Vec<Held> = request
        .start
        .contacts
        .iter()
        .map(|&(patch, surface)| {
            let mut X_WC = kinematics.X_WC(&robot.patches[patch]);
            // How a ball is turned does not matter: it takes the axes of what it touches.
            if robot.patches[patch].point_radius_m().is_some()
                && let Some(touched) = request.environment.surfaces.get(surface)
            {
                X_WC.rotation = touched.X_WS.rotation;
            }
            Held {
                patch,
                surface,
                X_WC,
            }
        })
        .collect();
    contacts.sort_by_key(|c| c.patch);
    let problem = Problem {
        robot,
        environment: request.environment,
        contacts: contacts
            .iter()
            .map(|held| fixed(prepared, held, true))
            .collect(),
        base_goal: None,
        reference: configuration,
        guess: configuration,
    };
    // As it stands, with nothing in reserve; then as near to that as the margins allow.
    let mut posture = None;
    for config in [&as_it_stands(config), config] {
        match posture::solve(&problem, config)? {
            Outcome::Feasible(found) => posture = Some(*found),
            other => {
                let reason = other
                    .violation()
                    .map_or_else(String::new, |v| v.describe(&problem));
                return Err(Error::Start { reason });
            }
        }
    }
    let posture = posture.ok_or_else(|| Error::Start {
        reason: "no posture".to_owned(),
    })?;
    let mut last = vec![None; robot.patches.len()];
    for held in &contacts {
        last[held.patch] = Some(held.place_W(prepared));
    }
    Ok(Node {
        parent: None,
        depth: 0,
        change: Change::Start,
        elsewhere: false,
        touching: contacts.iter().map(|c| (c.clone(), true)).collect(),
        contacts,
        posture: Arc::new(posture),
        last,
    })
}

/// Settings that leave the configuration where it is and ask for no margin: what holds then holds
/// as the robot stands.
fn as_it_stands(config: &posture::Config) -> posture::Config {
    /// No step to speak of, rad and m.
    const STILL: f64 = 1e-9;
    posture::Config {
        friction_use: 1.0,
        torque_use: 1.0,
        joint_margin_rad: 0.0,
        clearance_m: 0.0,
        self_clearance_m: 0.0,
        com_margin_m: 0.0,
        step_max_rad: STILL,
        step_max_m: STILL,
        restarts: 0,
        ..config.clone()
    }
}

/// The node of a solved candidate; where it has no posture, why.
pub(crate) fn child(
    prepared: &Prepared,
    candidate: &Candidate,
    parent: &Node,
    contacts: &[Contact],
    outcome: Outcome,
) -> Result<Node, Blocked> {
    let request = prepared.request;
    let change = describe(prepared, parent, &candidate.change);
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
            return Err(Blocked {
                change,
                held: held(prepared, parent),
                reason,
                distance_m: parent.distance_m(prepared),
            });
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
        last[held.patch] = Some(held.place_W(prepared));
    }
    Ok(Node {
        parent: Some(candidate.node),
        depth: parent.depth + 1,
        change,
        elsewhere: candidate.elsewhere,
        contacts: set,
        touching,
        posture: Arc::new(*posture),
        last,
    })
}

/// A move in the names of patch and surface.
fn describe(prepared: &Prepared, parent: &Node, change: &Move) -> Change {
    let request = prepared.request;
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

/// A node's contacts in words.
pub(crate) fn held(prepared: &Prepared, node: &Node) -> String {
    let request = prepared.request;
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
