//! The distances that a configuration along the path must keep, as the projection's inequalities.

use nalgebra::{Point3, Vector3};
use posture::PlacedShape;
use robot_model::Kinematics;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::airborne::{Airborne, touching_m};
use crate::generate::STEP_PART;
use crate::problem::{MotionContext, Task};

/// Pairs whose distance is within this of the required one become inequalities, m.
const LOOK_M: f64 = 0.04;
/// The same of what a link in contact may touch, m.
const CONTACT_LOOK_M: f64 = 2e-3;

/// A distance to keep.
pub(crate) struct Near {
    /// What is asked, m.
    pub required_m: f64,
    /// From b toward a.
    pub normal_W: Vector3<f64>,
    /// Body and the nearest point on it, in its frame.
    pub a: (usize, Point3<f64>),
    /// The same of the other body; a point of W where it is the environment's.
    pub b: (Option<usize>, Point3<f64>),
}

/// Appends every pair that is near, with `extra_m` added to its required distance.
pub(crate) fn pairs(
    context: &MotionContext,
    task: &Task,
    kinematics: &Kinematics,
    extra_m: f64,
    out: &mut Vec<Near>,
) {
    let robot = context.robot;
    let collision = &robot.collision;
    let mut found: Vec<Proximity> = Vec::new();
    let own = context.posture.self_clearance_m + extra_m;
    collision.self_proximities(kinematics, own + LOOK_M, &mut found);
    out.extend(found.iter().map(|pair| near(pair, kinematics, own)));

    found.clear();
    let air = task.swing.as_ref().map(|swing| {
        let patch = &robot.patches[swing.patch];
        let airborne = Airborne::new(context, swing, &kinematics.X_WC(patch));
        (patch.body, airborne)
    });
    let moves_m = STEP_PART * context.posture.clearance_m;
    let in_air = |shape: BodyShape| {
        let own = air.as_ref().filter(|(body, _)| *body == shape.body);
        own.map(|(_, air)| air)
    };
    let touching = |shape: BodyShape, obstacle: usize| {
        let shape = &collision.shapes()[shape.shape];
        let air = air.as_ref().map(|(_, air)| air);
        touching_m(context, task, air, shape, obstacle, moves_m)
    };
    let gently = |pair: &Proximity, obstacle: usize| {
        let air = in_air(pair.a);
        let shape = &collision.shapes()[pair.a.shape];
        let placed = PlacedShape {
            geometry: &shape.geometry,
            X_BG: &shape.X_BG,
            X_WG: &collision.X_WG(kinematics, pair.a.shape),
            is_pad: shape.is_pad,
            nearest_W: Point3::from(pair.p_a_W),
            normal_W: pair.normal_W,
        };
        air.and_then(|air| air.beside_contact_m(context, &placed, obstacle, moves_m))
            .or_else(|| task.beside_contact_m(context, (shape.body, &placed), obstacle))
    };
    let skip = |shape, obstacle| touching(shape, obstacle) == Some(f64::NEG_INFINITY);
    let beside = context.posture.clearance_m;
    let most = beside.max(context.config.swing_clearance_m) + extra_m + LOOK_M;
    let world = context.environment.world();
    collision.world_proximities(kinematics, world, most, &skip, &mut found);
    out.extend(found.iter().filter_map(|pair| {
        let Other::Obstacle(obstacle) = pair.b else {
            return None;
        };
        if let Some(required) = touching(pair.a, obstacle).or_else(|| gently(pair, obstacle)) {
            // What is to stay off is looked for from twice that on.
            let is_near = pair.distance < required + CONTACT_LOOK_M.max(required);
            return is_near.then(|| near(pair, kinematics, required));
        }
        let required = match in_air(pair.a) {
            Some(air) => air.required_m(context, &pair.normal_W, extra_m),
            None => beside + extra_m,
        };
        Some(near(pair, kinematics, required))
    }));
}

fn near(pair: &Proximity, kinematics: &Kinematics, required_m: f64) -> Near {
    let on = |body: usize, p: &Vector3<f64>| {
        kinematics.X_WB[body].inverse_transform_point(&Point3::from(*p))
    };
    Near {
        required_m,
        normal_W: pair.normal_W,
        a: (pair.a.body, on(pair.a.body, &pair.p_a_W)),
        b: match pair.b {
            Other::Shape(b) => (Some(b.body), on(b.body, &pair.p_b_W)),
            Other::Obstacle(_) => (None, Point3::from(pair.p_b_W)),
        },
    }
}
