//! Ways on which nothing in reach can hold the robot.
//!
//! Wherever the base is on its way, the contacts that it may have there must be able to carry the
//! weight. With the friction cones K_i of all faces in reach
//!
//!   ẑ ∈ K_1 + K_2 + …
//!
//! is necessary whatever the posture; for one face it says that it is no steeper than atan μ. Where
//! it fails there is a w with w·ẑ > 0 and w·k ≤ 0 on every cone (Farkas), which is the proof. It costs
//! microseconds, and says the angle where the search would try every stance before it.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use posture::FaceIndex;

use crate::context::SearchContext;
use crate::result::Blocked;

/// Cosine that a ray may have with the separating direction and still count as behind it.
const BEHIND: f64 = 1e-9;
/// Steps toward the vertical before the cones are taken to hold it.
const STEPS: usize = 500;
/// A rest of the vertical shorter than this is none.
const REACHED: f64 = 1e-3;

/// The friction cone of a face in reach, as plans may use it.
struct Hold {
    normal: Vector3<f64>,
    mu: f64,
}

impl Hold {
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

/// Where on the route nothing can hold the robot, and why.
pub(crate) fn too_steep(context: &SearchContext, friction_use: f64) -> Option<Blocked> {
    let route = &context.route;
    let length = route.length_m();
    let parts = (length / context.stride_m).ceil().max(1.0) as usize;
    (0..=parts).find_map(|i| {
        let along = length * i as f64 / parts as f64;
        let holds = in_reach(context, &route.at(along).p, friction_use);
        if holds.is_empty() || carries(holds.values()) {
            return None;
        }
        let (face, least) = holds
            .iter()
            .min_by(|a, b| a.1.angles().0.total_cmp(&b.1.angles().0))?;
        let (slope, allowed) = least.angles();
        let reason = format!(
            "{} is too steep: it slopes by {:.1}°, and friction {:.2}, of which plans use {:.0} %, \
                 holds up to {:.1}°",
            context.request.environment[*face].id,
            slope.to_degrees(),
            least.mu / friction_use,
            1e2 * friction_use,
            allowed.to_degrees()
        );
        Some(Blocked {
            distance_m: length - along,
            ..Blocked::of_goal(reason, true)
        })
    })
}

/// The faces that the robot may touch with its base at a place of the route.
fn in_reach(
    context: &SearchContext,
    base: &Vector3<f64>,
    friction_use: f64,
) -> BTreeMap<FaceIndex, Hold> {
    let request = context.request;
    let environment = request.environment;
    let mut holds: BTreeMap<FaceIndex, Hold> = BTreeMap::new();
    let used = request.robot.patch_ids().filter(|p| context.is_used(*p));
    for patch in used {
        let friction = request.robot.patches[patch].friction;
        let reach = Vector3::repeat(context.reach.base_m(patch));
        let (low, high) = (Point3::from(base - reach), Point3::from(base + reach));
        for face in environment.faces_near(&low, &high) {
            if !context.may_touch(patch, face) {
                continue;
            }
            let Some((beside, over)) = environment.distances_m(face, &Point3::from(*base)) else {
                continue;
            };
            if beside.hypot(over) <= context.reach.base_m(patch) {
                let normal = environment[face].normal_W();
                let mu = environment[face].friction_with(friction) * friction_use;
                let hold = holds.entry(face).or_insert(Hold { normal, mu });
                hold.mu = hold.mu.max(mu);
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
