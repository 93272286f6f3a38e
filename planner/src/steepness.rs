//! Ways on which nothing in reach can hold the robot.
//!
//! Wherever the base is on its way, the contacts that it may have there must be able to carry the
//! weight. With the friction cones K_i of all faces in reach
//!
//!   ẑ ∈ K_1 + K_2 + …
//!
//! is necessary whatever the posture; for one face it says that it is no steeper than atan μ. Where
//! it fails there is a w with w·ẑ > 0 and w·k ≤ 0 on every cone (Farkas). Where such places lie all about
//! those that the base comes to from the start, and the goal is not among these, there is no way: that is the proof.
//! It costs a millisecond, and says the angle where the search would try every stance before it.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use nalgebra::{Point3, Vector2, Vector3};
use posture::FaceIndex;
use robot_model::PatchId;

use crate::context::SearchContext;
use crate::result::Blocked;

/// Width of the squares of the level plane in one of which the base is, m.
const CELL_M: f64 = 0.2;
/// Squares that are looked at before nothing is said.
const CELLS_MAX: usize = 20_000;
/// No face is higher or lower, m.
const ANYWHERE_M: f64 = 1e6;
/// Cosine that a ray may have with the separating direction and still count as behind it.
const BEHIND: f64 = 1e-9;
/// Steps toward the vertical before the cones are taken to hold it.
const STEPS: usize = 500;
/// A rest of the vertical shorter than this is none.
const REACHED: f64 = 1e-3;

/// The friction cone of a face in reach, as plans may use it.
#[derive(Clone, Copy)]
struct Hold {
    normal: Vector3<f64>,
    mu: f64,
}

impl Hold {
    fn new(context: &SearchContext, patch: PatchId, face: FaceIndex) -> Self {
        let (request, face) = (context.request, &context.request.environment[face]);
        let friction = face.friction_with(request.robot.patches[patch].friction);
        Self {
            normal: face.normal_W(),
            mu: friction * context.friction_use,
        }
    }

    /// How steep the face is and how steep it may be, rad.
    fn angles(&self) -> (f64, f64) {
        (self.normal.z.clamp(-1.0, 1.0).acos(), self.mu.atan())
    }

    /// The unit ray of the cone that is farthest along w.
    fn farthest(&self, w: &Vector3<f64>) -> Vector3<f64> {
        let across = w - self.normal * self.normal.dot(w);
        let across = across.try_normalize(1e-12).unwrap_or_else(Vector3::zeros);
        let along = self.normal.dot(w);
        // Inside the cone, w itself.
        if along > 0.0 && (w - self.normal * along).norm() <= self.mu * along {
            return w.normalize();
        }
        (self.normal + across * self.mu).normalize()
    }
}

/// Whether a face that a patch touches is no steeper than the friction that plans use holds.
pub(crate) fn holds_alone(context: &SearchContext, patch: PatchId, face: FaceIndex) -> bool {
    let (slope, most) = Hold::new(context, patch, face).angles();
    slope <= most
}

/// Why the base comes to the goal on no way, as nothing in reach can hold the robot on them; nothing where
/// that is not known.
pub(crate) fn too_steep(context: &SearchContext) -> Option<Blocked> {
    let request = context.request;
    let mut touched = request.robot.patch_ids().flat_map(|patch| {
        let faces = request.usable[patch.index()].iter();
        faces.map(move |&face| (patch, face))
    });
    if touched.all(|(patch, face)| holds_alone(context, patch, face)) {
        return None;
    }
    let place = |cell: Cell| Vector2::new(cell.0 as f64, cell.1 as f64) * CELL_M;
    // What is left to the goal from the nearest place of a square, over the coordinates that the goal has.
    let left_m = |cell: Cell| {
        let (low, goal) = (place(cell), &request.goal.base.position_m);
        let left =
            |k: usize| goal[k].map_or(0.0, |x| (low[k] - x).max(x - low[k] - CELL_M).max(0.0));
        (left(0).hypot(left(1)) - request.goal.base.tolerance_m).max(0.0)
    };
    let first = request.start.configuration.p_WB / CELL_M;
    let first = (first.x.floor() as i64, first.y.floor() as i64);
    let rank = |cell: Cell| Reverse((left_m(cell).to_bits(), cell));
    let mut seen = BTreeSet::from([first]);
    let mut open = BinaryHeap::from([rank(first)]);
    let mut nearest: Option<(f64, BTreeMap<FaceIndex, Hold>)> = None;
    while let Some(Reverse((left, cell))) = open.pop() {
        if left == 0 || seen.len() > CELLS_MAX {
            return None;
        }
        for (x, y) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let beside = (cell.0 + x, cell.1 + y);
            if !seen.insert(beside) {
                continue;
            }
            // With the base anywhere over or under the square.
            let holds = holds(context, |reach_m| {
                let reach = Vector2::repeat(reach_m);
                let low = (place(beside) - reach).push(-ANYWHERE_M);
                let high = (place(beside) + Vector2::repeat(CELL_M) + reach).push(ANYWHERE_M);
                request.environment.faces_near(&low.into(), &high.into())
            });
            if carries(holds.values()) {
                open.push(rank(beside));
            } else if !holds.is_empty() {
                let left_m = left_m(beside);
                if nearest.as_ref().is_none_or(|(least, _)| left_m < *least) {
                    nearest = Some((left_m, holds));
                }
            }
        }
    }
    let (distance_m, holds) = nearest?;
    let reason = format!("{}; no way leads round it", slopes(context, &holds)?);
    Some(Blocked {
        distance_m,
        ..Blocked::of_goal(reason, true)
    })
}

/// Where on the way of the base nothing can hold the robot, and why: no proof, as it may come there by another one.
pub(crate) fn steep_on_the_way(context: &SearchContext) -> Option<Blocked> {
    let route = &context.route;
    let length = route.length_m();
    let parts = (length / context.stride_m).ceil().max(1.0) as usize;
    (0..=parts).find_map(|i| {
        let along = length * i as f64 / parts as f64;
        let base = Point3::from(route.at(along).p);
        let holds = holds(context, |reach_m| {
            let reach = Vector3::repeat(reach_m);
            let mut near = context
                .request
                .environment
                .faces_near(&(base - reach), &(base + reach));
            near.retain(|&face| {
                let apart = context.request.environment.distances_m(face, &base);
                apart.is_some_and(|(beside, over)| beside.hypot(over) <= reach_m)
            });
            near
        });
        if holds.is_empty() || carries(holds.values()) {
            return None;
        }
        Some(Blocked {
            distance_m: length - along,
            ..Blocked::of_goal(slopes(context, &holds)?, false)
        })
    })
}

/// How steep the flattest of faces is, and how steep it may be.
fn slopes(context: &SearchContext, holds: &BTreeMap<FaceIndex, Hold>) -> Option<String> {
    let flattest = |a: &(&FaceIndex, &Hold), b: &(&FaceIndex, &Hold)| {
        a.1.angles().0.total_cmp(&b.1.angles().0)
    };
    let (face, least) = holds.iter().min_by(flattest)?;
    let (slope, allowed) = least.angles();
    Some(format!(
        "{} is too steep: it slopes by {:.1}°, and friction {:.2}, of which plans use {:.0} %, \
             holds up to {:.1}°",
        context.request.environment[*face].id,
        slope.to_degrees(),
        least.mu / context.friction_use,
        1e2 * context.friction_use,
        allowed.to_degrees()
    ))
}

/// A square of the level plane, by its low corner over [`CELL_M`].
type Cell = (i64, i64);

/// The faces that the robot may touch, of those that are `near` with a reach, m.
fn holds(
    context: &SearchContext,
    near: impl Fn(f64) -> Vec<FaceIndex>,
) -> BTreeMap<FaceIndex, Hold> {
    let request = context.request;
    let mut holds: BTreeMap<FaceIndex, Hold> = BTreeMap::new();
    for patch in request.robot.patch_ids().filter(|p| context.is_used(*p)) {
        let model = &request.robot.patches[patch];
        // It touches within this of its frame.
        let about_m = model.polygon.iter().map(|p| p.coords.norm());
        let about_m = about_m.fold(model.point_radius_m().unwrap_or(0.0), f64::max);
        for face in near(context.reach.base_m(patch) + about_m) {
            if context.may_touch(patch, face) || request.start.contacts.contains(&(patch, face)) {
                let here = Hold::new(context, patch, face);
                let hold = holds.entry(face).or_insert(here);
                hold.mu = hold.mu.max(here.mu);
            }
        }
    }
    holds
}

/// Whether the cones together hold the vertical: false only with a proof.
///
/// The rest of the vertical is shortened along the ray that is farthest along it, until none is.
fn carries<'h>(holds: impl Iterator<Item = &'h Hold> + Clone) -> bool {
    let mut w = Vector3::z();
    for _ in 0..STEPS {
        let rays = holds.clone().map(|hold| hold.farthest(&w));
        let Some(ray) = rays.max_by(|a, b| a.dot(&w).total_cmp(&b.dot(&w))) else {
            return false;
        };
        let along = ray.dot(&w);
        if along <= BEHIND * w.norm() {
            // Every cone is behind w: the proof, unless w is level.
            return w.z <= BEHIND;
        }
        w -= ray * along;
        if w.norm() < REACHED {
            return true;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(degrees: f64, mu: f64) -> Hold {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        Hold {
            normal: Vector3::new(-sin, 0.0, cos),
            mu,
        }
    }

    #[test]
    fn one_face_carries_up_to_the_angle_of_its_friction() {
        let mu = 0.5_f64;
        let most = mu.atan().to_degrees();
        assert!(carries([hold(0.0, mu)].iter()) && carries([hold(most - 0.1, mu)].iter()));
        assert!(!carries([hold(most + 0.1, mu)].iter()) && !carries([hold(80.0, mu)].iter()));
    }

    #[test]
    fn two_faces_that_lean_on_each_other_carry_where_none_does_alone() {
        assert!(carries([hold(50.0, 0.5), hold(-50.0, 0.5)].iter()));
        // Both of one side do not.
        assert!(!carries([hold(50.0, 0.5), hold(60.0, 0.5)].iter()));
        // Nor two walls without friction.
        assert!(!carries([hold(90.0, 0.0), hold(-90.0, 0.0)].iter()));
    }
}
