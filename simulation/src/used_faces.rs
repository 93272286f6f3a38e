//! Which things of a world a reference uses.

use std::collections::HashMap;

use nalgebra::Vector3;
use robot_model::Robot;

use crate::reference::{Reference, ReferenceState};
use crate::world::WorldBody;

/// What the contacts on a thing in the world make of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Used {
    /// The first of its bodies, by which its displacement is drawn.
    pub first: usize,
    /// Middle of the box around all of them, in W, m.
    pub centre_W: Vector3<f64>,
    /// How far they are from there at most, m.
    pub reach_m: f64,
}

/// How the thing that each body of the world is a part of is used; `None` where nothing touches it, and where
/// it carries the robot at the start.
///
/// A contact uses the body of which the surface is nearest to its place.
pub fn used_faces(
    robot: &Robot,
    world: &[WorldBody],
    reference: &impl Reference,
) -> Vec<Option<Used>> {
    let mut firsts: HashMap<&str, usize> = HashMap::new();
    let things = world.iter().enumerate();
    let things = things.map(|(k, body)| *firsts.entry(&body.part_of).or_insert(k));
    let things: Vec<usize> = things.collect();
    let mut wanted = ReferenceState::at_rest(robot.neutral());
    let mut touched: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); world.len()];
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
                fixed[things[k]] |= step == 0;
                touched[things[k]].push(p_W);
            }
        }
    }
    let used = |first: usize| {
        let contacts = &touched[first];
        let any = *contacts.first().filter(|_| !fixed[first])?;
        let (low, high) = contacts
            .iter()
            .fold((any, any), |(low, high), p| (low.inf(p), high.sup(p)));
        let centre_W = (low + high) / 2.0;
        let reach_m = contacts
            .iter()
            .map(|p| (p - centre_W).norm())
            .fold(0.0, f64::max);
        Some(Used {
            first,
            centre_W,
            reach_m,
        })
    };
    things.into_iter().map(used).collect()
}
