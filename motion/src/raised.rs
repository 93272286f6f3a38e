//! Whether a patch can leave the place that it touches, or come to it, at all.

use nalgebra::Translation3;
use posture::{Contact, Freedom, Problem};
use robot_model::PatchId;

use crate::Error;
use crate::problem::{MotionContext, StanceRef};

/// Why no posture on the other contacts of a stance has a patch straight above the place that it
/// touches, `motion.swing_height_m` along the normal; nothing where one has.
///
/// Every path through the air passes near that pose: one posture near a known one tells what would
/// take a motion's search to find out.
///
/// # Errors
/// [`Error::Posture`] where the posture cannot be asked for.
pub fn raised(
    context: &MotionContext,
    stance: StanceRef,
    patch: PatchId,
) -> Result<Option<String>, Error> {
    let states = stance.contacts.iter().zip(&stance.posture.contacts);
    let contacts: Vec<Contact> = states
        .map(|(contact, state)| {
            if contact.patch != patch {
                return contact.placed(state.X_WC);
            }
            let lift = Translation3::from(contact.normal_W() * context.config.swing_height_m);
            Contact {
                X_WC: lift * state.X_WC,
                freedom: Freedom::Fixed,
                stood_WB: None,
                face: None,
                loaded: false,
                ..contact.clone()
            }
        })
        .collect();
    let problem = Problem {
        robot: context.robot,
        environment: context.environment,
        contacts,
        base_goal: None,
        joint_goal: None,
        reference: &stance.posture.q,
        guess: &stance.posture.q,
    };
    let mut config = context.posture.clone();
    config.solver.upright = stance.posture.upright;
    let outcome = posture::solve(&problem, &config)?;
    Ok(outcome.violation().map(|v| v.describe(&problem)))
}
