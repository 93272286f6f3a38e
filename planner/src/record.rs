//! The path as stances of a plan file.

use plan::Stance;
use posture::{Contact, ContactState, Environment};
use robot_model::Robot;

use crate::result::PathStance;

/// The stances of a path, ready to be written.
pub fn stances(robot: &Robot, environment: &Environment, path: &[PathStance]) -> Vec<Stance> {
    let record = |(index, stance): (usize, &PathStance)| {
        let contacts = stance.contacts.iter().zip(&stance.posture.contacts);
        Stance {
            index,
            change: stance.change.clone(),
            contacts: contacts
                .map(|(contact, state)| record(robot, environment, contact, state))
                .collect(),
            q: stance.posture.q.to_q(),
            com_W: stance.posture.com_W.into(),
            margins: stance.posture.margins,
        }
    };
    path.iter().enumerate().map(record).collect()
}

fn record(
    robot: &Robot,
    environment: &Environment,
    contact: &Contact,
    state: &ContactState,
) -> plan::Contact {
    let patch = &robot.patches[contact.patch];
    let face = contact.face.map(|face| environment[face].id.clone());
    let triples = |points: &[nalgebra::Vector3<f64>]| points.iter().map(|&p| p.into()).collect();
    plan::Contact {
        patch: patch.name.clone(),
        link: patch.link.clone(),
        face: face.unwrap_or_default(),
        X_WC: (&state.X_WC).into(),
        rolls_from: contact.rolls_from_W().as_ref().map(Into::into),
        friction: contact.friction,
        loaded: contact.loaded,
        vertices_W: triples(&state.vertices_W),
        force_points_W: triples(&state.force_points_W),
        forces_W: triples(&state.forces_W),
    }
}
