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

/// A thing that ends this near to the plane of a contact on another, and meets it, belongs to it, m.
const SAME_PLANE_M: f64 = 0.015;

/// How the thing that each body of the world is a part of is used; `None` where nothing touches it, and where
/// it carries the robot at the start.
///
/// A contact uses the body of which the surface is nearest to its place. What ends at the plane of such a
/// contact, as the riser under a tread does, is used with it: left behind it would stand out of the tread.
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
    // Of each thing, by its first body: places and normals of the contacts in W.
    let mut touched: Vec<Vec<[Vector3<f64>; 2]>> = vec![Vec::new(); world.len()];
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
                touched[things[k]].push([p_W, normal_W]);
            }
        }
    }
    let used = |thing: usize| {
        let places = || touched[thing].iter().map(|[p_W, _]| *p_W);
        if fixed[thing] || places().next().is_none() {
            return None;
        }
        let (low, high) = bounds(places());
        let centre_W = (low + high) / 2.0;
        Some(Used {
            first: thing,
            centre_W,
            reach_m: places()
                .map(|p_W| (p_W - centre_W).norm())
                .fold(0.0, f64::max),
        })
    };
    let corners = |thing: usize| {
        let of = things
            .iter()
            .zip(world)
            .filter(move |(of, _)| **of == thing);
        of.flat_map(|(_, body)| body.corners_W())
            .map(|corner| corner.coords)
    };
    let belongs = |thing: usize, other: usize| {
        let ends_at = |[p_W, normal_W]: &[Vector3<f64>; 2]| {
            let heights = corners(thing).map(|corner| (corner - p_W).dot(normal_W));
            heights.fold(f64::NEG_INFINITY, f64::max).abs() < SAME_PLANE_M
        };
        let ((low, high), (from, to)) = (bounds(corners(thing)), bounds(corners(other)));
        touched[other].iter().any(ends_at) && low <= to && from <= high
    };
    let whole = |thing: &usize| {
        let owner = || (0..world.len()).find(|other| belongs(*thing, *other));
        touched[*thing]
            .is_empty()
            .then(owner)
            .flatten()
            .unwrap_or(*thing)
    };
    things.iter().map(|thing| used(whole(thing))).collect()
}

/// Lowest and highest coordinates of points.
fn bounds(points: impl Iterator<Item = Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let all = Vector3::repeat(f64::INFINITY);
    points.fold((all, -all), |(low, high), p| (low.inf(&p), high.sup(&p)))
}
