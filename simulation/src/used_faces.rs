//! Which faces of a world a reference uses.

use nalgebra::Vector3;
use robot_model::Robot;

use crate::reference::{Reference, ReferenceState};
use crate::world::WorldBody;

/// What the contacts on a body of the world make of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Used {
    /// Middle of the box around all of them, in W, m.
    pub centre_W: Vector3<f64>,
    /// How far they are from there at most, m.
    pub reach_m: f64,
}

/// How each body of the world is used; `None` for bodies that nothing touches and for those that carry
/// the robot at the start.
///
/// A contact uses the body of which the surface is nearest to its place.
pub fn used_faces(
    robot: &Robot,
    world: &[WorldBody],
    reference: &impl Reference,
) -> Vec<Option<Used>> {
    let mut wanted = ReferenceState::at_rest(robot.neutral());
    let mut used: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); world.len()];
    let mut fixed = vec![false; world.len()];
    let steps = (reference.duration_s() / 0.05).ceil() as usize;
    for step in 0..=steps {
        reference.at(step as f64 * 0.05, &mut wanted);
        for contact in &wanted.contacts {
            let patch = &robot.patches[contact.patch];
            let normal_W = contact.X_WC.rotation * Vector3::z();
            let p_W =
                contact.X_WC.translation.vector - normal_W * patch.point_radius_m().unwrap_or(0.0);
            let away = world
                .iter()
                .map(|body| body.face_distance_m(&p_W, &normal_W));
            let nearest = away.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((k, _)) = nearest {
                fixed[k] |= step == 0;
                used[k].push(p_W);
            }
        }
    }
    let used = used.into_iter().zip(fixed);
    used.map(|(contacts, fixed)| {
        let first = *contacts.first().filter(|_| !fixed)?;
        let (low, high) = contacts
            .iter()
            .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let centre_W = (low + high) / 2.0;
        let reach_m = contacts
            .iter()
            .map(|p| (p - centre_W).norm())
            .fold(0.0, f64::max);
        Some(Used { centre_W, reach_m })
    })
    .collect()
}
