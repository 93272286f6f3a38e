//! The swinging link alone against the environment: a cheap test of a path before the whole body is
//! computed. For a leg that ends in a ball only the ball is tested.

use nalgebra::{Isometry3, Vector3};
use posture::PlacedShape;
use robot_model::collision::{Shape, ShapeGeometry, closest};

use crate::airborne::Airborne;
use crate::problem::{MotionContext, Task};
use crate::route::extra_m;
use crate::swing_path::SwingPath;

/// Poses along the path that are tested.
const POSES: usize = 40;
/// Bodies farther than this are not measured, m.
const LOOK_M: f64 = 0.05;

/// What the link would hit.
pub(crate) enum Hit {
    /// A body of the environment, by index.
    Environment(usize),
    /// A link that a closed contact holds in place.
    Robot(String),
}

/// What the link comes too near to, by how much (m), where on the path (0…1) and which way leads from
/// it (W), at the worst pose.
pub(crate) struct Shortfall {
    pub hit: Hit,
    pub short_m: f64,
    pub at: f64,
    pub away_W: Vector3<f64>,
}

/// What the link comes too near to on a path, by the distances that the whole body keeps; nothing
/// where the path is free.
pub(crate) fn shortfall(
    context: &MotionContext,
    task: &Task,
    path: &SwingPath,
) -> Option<Shortfall> {
    let swing = task.swing.as_ref()?;
    let robot = context.robot;
    let patch = &robot.patches[swing.patch];
    let to_body = patch.X_BC.inverse();
    let collision = &robot.collision;
    let shapes = collision.shapes().iter().enumerate();
    let own = shapes.filter(|(_, shape)| shape.body == patch.body);
    let own: Vec<_> = own.collect();
    // A ball's path does not say how its link is turned: only the ball itself is known.
    let sphere = |radius_m| (ShapeGeometry::Sphere { radius_m }, patch.X_BC);
    let ball = patch.point_radius_m().map(sphere);
    let swept: Vec<(&ShapeGeometry, &Isometry3<f64>)> = match &ball {
        Some((sphere, X_BG)) => vec![(sphere, X_BG)],
        None => own.iter().map(|(_, s)| (&s.geometry, &s.X_BG)).collect(),
    };
    // A bounding ball around each, to skip what is far away.
    let around = swept.iter().map(|(geometry, _)| {
        let (centre, half) = geometry.bounds();
        (centre, half.norm())
    });
    let balls: Vec<_> = around.collect();
    // Links that closed contacts hold in place do not move: obstacles like the environment's. A link
    // on a ball turns about it, and the contact's axes are not its own.
    let watched = |a: usize, b: usize| collision.pairs().contains(&(a.min(b), a.max(b)));
    let mut standing = Vec::new();
    for closed in &task.closed {
        let patch = &robot.patches[closed.patch];
        if patch.point_radius_m().is_some() {
            continue;
        }
        let X_WB = closed.X_WC * patch.X_BC.inverse();
        for (b, shape) in collision.shapes().iter().enumerate() {
            let meets = |a: &(usize, &Shape)| watched(a.0, b);
            if shape.body == patch.body && own.iter().any(meets) {
                standing.push((shape, X_WB * shape.X_BG));
            }
        }
    }
    let world = context.environment.world();
    let mut worst: Option<Shortfall> = None;
    let mut keep = |short_m: f64, at: f64, away_W: Vector3<f64>, hit: &dyn Fn() -> Hit| {
        // The postures at the ends keep their clearance only to the solver's tolerance.
        if short_m > 1e-4 && worst.as_ref().is_none_or(|w| short_m > w.short_m) {
            worst = Some(Shortfall {
                hit: hit(),
                short_m,
                at,
                away_W,
            });
        }
    };
    for i in 0..=POSES {
        let u = i as f64 / POSES as f64;
        let X_WC = path.pose(u);
        let air = Airborne::new(context, swing, &X_WC);
        let X_WB = X_WC * to_body;
        for (&(geometry, X_BG), &(centre, radius)) in swept.iter().zip(&balls) {
            let X_WG = X_WB * X_BG;
            let (middle, reach) = (X_WG * centre, Vector3::repeat(radius));
            for o in world.near(&(middle - reach), &(middle + reach), LOOK_M) {
                let obstacle = &world.obstacles()[o];
                if obstacle.is_beyond(&middle, radius + LOOK_M) || air.may_touch(context, o) {
                    continue;
                }
                let (other, pose) = (obstacle.geometry(), obstacle.pose());
                if let Some(found) = closest(geometry, &X_WG, other, pose, LOOK_M) {
                    let normal_W = &found.normal_W;
                    let placed = PlacedShape {
                        geometry,
                        X_BG,
                        X_WG: &X_WG,
                        is_pad: true,
                        nearest_W: found.p_a_W,
                        normal_W: *normal_W,
                    };
                    let gently = air.beside_contact_m(context, &placed, o, 0.0);
                    let required = || air.required_m(context, normal_W, extra_m(path, u));
                    let short = gently.unwrap_or_else(required) - found.distance;
                    keep(short, u, *normal_W, &|| Hit::Environment(o));
                }
            }
            for (other, X_WO) in &standing {
                if let Some(found) = closest(geometry, &X_WG, &other.geometry, X_WO, LOOK_M) {
                    let required = context.posture.self_clearance_m + extra_m(path, u);
                    let short = required - found.distance;
                    keep(short, u, found.normal_W, &|| Hit::Robot(other.link.clone()));
                }
            }
        }
    }
    worst
}
