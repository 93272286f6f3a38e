//! The stances of a plan as the simulation takes them.
#![allow(non_snake_case)]

use anyhow::{Context, Result};
use nalgebra::Vector3;
use plan::{Plan, Stance};
use robot_model::Robot;
use simulation::reference::{ReferenceContact, ReferenceState};

use crate::export::frames::isometry;

/// A stance that is to be held.
///
/// # Errors
/// A configuration or a patch that is not the robot's.
pub fn standing(robot: &Robot, stance: &Stance) -> Result<ReferenceState> {
    let place = || format!("stance {}", stance.index);
    let configuration = robot.configuration(&stance.q).with_context(place)?;
    let vectors = |list: &[[f64; 3]]| -> Vec<Vector3<f64>> {
        list.iter().copied().map(Vector3::from).collect()
    };
    let contacts = stance.contacts.iter().map(|contact| {
        let patch = robot.patch_index(&contact.patch).with_context(place)?;
        Ok(ReferenceContact::new(
            patch,
            isometry(&contact.X_WC),
            contact.friction,
            &vectors(&contact.force_points_W),
            &vectors(&contact.forces_W),
        ))
    });
    let contacts = contacts.collect::<Result<_>>()?;
    Ok(ReferenceState::standing(configuration, contacts))
}

/// Puts the coefficients of friction that the plan was made with in the place of the robot's.
///
/// # Errors
/// A patch that is not the robot's.
pub fn apply_friction(robot: &mut Robot, plan: &Plan) -> Result<()> {
    for contact in plan.stances.iter().flat_map(|stance| &stance.contacts) {
        let patch = robot.patch_index(&contact.patch)?;
        robot.patches[patch].friction = contact.friction;
    }
    Ok(())
}
