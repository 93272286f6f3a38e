//! The distances that a configuration along the path must keep, as the projection's inequalities.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::Kinematics;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::airborne::Airborne;
use crate::problem::{MotionContext, Task};
use crate::projection::Near;

/// Pairs whose distance is within this of the required one become inequalities, m.
const LOOK_M: f64 = 0.04;

/// Appends every pair that is near, with `extra_m` added to its required distance.
pub(crate) fn pairs(
    context: &MotionContext,
    task: &Task,
    kinematics: &Kinematics,
    extra_m: f64,
    out: &mut Vec<Near>,
) {
    let robot = context.robot;
    let mut found: Vec<Proximity> = Vec::new();
    let own = context.posture.self_clearance_m + extra_m;
    robot
        .collision
        .self_proximities(robot, kinematics, own + LOOK_M, &mut found);
    out.extend(found.iter().map(|pair| near(pair, kinematics, own)));

    found.clear();
    let air = task.swing.as_ref().map(|swing| {
        let patch = &robot.patches[swing.patch];
        let X_WC: Isometry3<f64> = kinematics.X_WC(patch);
        (patch.body, Airborne::new(context, swing, &X_WC))
    });
    let skip = |shape: BodyShape, obstacle: usize| {
        task.touches(context, shape.body, obstacle)
            || air
                .as_ref()
                .is_some_and(|(body, air)| *body == shape.body && air.touches(context, obstacle))
    };
    let beside = context.posture.clearance_m;
    let most = beside.max(context.config.swing_clearance_m) + extra_m;
    robot.collision.world_proximities(
        robot,
        kinematics,
        context.environment.world(),
        most + LOOK_M,
        &skip,
        &mut found,
    );
    out.extend(found.iter().map(|pair| {
        let required = match &air {
            Some((body, air)) if *body == pair.a.body => air.required_m(context, &pair.normal_W),
            _ => beside,
        };
        near(pair, kinematics, required + extra_m)
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
