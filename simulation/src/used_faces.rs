//! Which faces of a world a reference uses.

use nalgebra::Vector3;
use robot_model::Robot;

use crate::reference::{Reference, ReferenceState};
use crate::world::WorldBody;

/// The normal of the first contact that uses each body of the world; `None` for bodies that
/// nothing touches and for those that carry the robot at the start.
///
/// A contact uses the body of which the surface is nearest to its place.
pub fn touched_normals_W(
    robot: &Robot,
    world: &[WorldBody],
    reference: &impl Reference,
) -> Vec<Option<Vector3<f64>>> {
    let mut wanted = ReferenceState::at_rest(robot.neutral());
    let mut normals = vec![None; world.len()];
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
                normals[k].get_or_insert(normal_W);
            }
        }
    }
    let touched = normals.into_iter().zip(fixed);
    touched
        .map(|(normal, fixed)| normal.filter(|_| !fixed))
        .collect()
}
