//! The stances of a plan as the simulation takes them.

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

/// Puts the coefficients of friction that the plan was made with in the place of the robot's: a patch has the
/// greatest that it has on any face, which may have less of its own.
///
/// # Errors
/// A patch that is not the robot's.
pub fn apply_friction(robot: &mut Robot, plan: &Plan) -> Result<()> {
    let contacts = || plan.stances.iter().flat_map(|stance| &stance.contacts);
    for contact in contacts() {
        let patch = robot.patch_index(&contact.patch)?;
        let own = contacts().filter(|other| other.patch == contact.patch);
        robot.patches[patch].friction = own.map(|other| other.friction).fold(0.0, f64::max);
    }
    Ok(())
}
