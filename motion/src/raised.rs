//! Whether a patch can leave the place that it touches, or come to it, at all.
#![allow(non_snake_case)]

use nalgebra::Translation3;
use posture::{Contact, Place, Problem};

use crate::Error;
use crate::problem::{End, Setting};

/// Why no posture on the other contacts of a stance has a patch straight above the place that it
/// touches, `motion.swing_height_m` along the normal; nothing where one has.
///
/// Every way through the air passes near that pose: one posture near a known one tells what would
/// take a motion's search to find out.
///
/// # Errors
/// [`Error::Posture`] where the posture cannot be asked for.
pub fn raised(setting: &Setting, stance: End, patch: usize) -> Result<Option<String>, Error> {
    let states = stance.contacts.iter().zip(&stance.posture.contacts);
    let contacts: Vec<Contact> = states
        .map(|(&(held, surface, loaded), state)| {
            let n = setting.environment.surfaces[surface].normal_W();
            let lift = Translation3::from(n * setting.config.swing_height_m);
            let in_air = held == patch;
            Contact {
                patch: held,
                place: Place::Fixed {
                    X_WC: if in_air {
                        lift * state.X_WC
                    } else {
                        state.X_WC
                    },
                    yaw_free: false,
                    surface: (!in_air).then_some(surface),
                },
                loaded: loaded && !in_air,
                friction: setting.robot.patches[held].friction,
            }
        })
        .collect();
    let problem = Problem {
        robot: setting.robot,
        environment: setting.environment,
        contacts,
        base_goal: None,
        reference: &stance.posture.q,
        guess: &stance.posture.q,
    };
    let outcome = posture::solve(&problem, setting.posture)?;
    Ok(outcome.violation().map(|v| v.describe(&problem)))
}
