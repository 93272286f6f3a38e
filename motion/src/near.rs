//! The distances that a configuration on the way must keep, for the projection.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Vector3};
use robot_model::Kinematics;
use robot_model::collision::{BodyShape, Other, Proximity};

use crate::airborne::Airborne;
use crate::problem::{Setting, Task};
use crate::projection::Near;

/// Pairs within this distance of what they must keep are looked at, m.
const LOOK_M: f64 = 0.04;

/// Appends every pair that is near, with `extra_m` more than what is asked of it.
pub(crate) fn pairs(
    setting: &Setting,
    task: &Task,
    kinematics: &Kinematics,
    extra_m: f64,
    out: &mut Vec<Near>,
) {
    let robot = setting.robot;
    let mut found: Vec<Proximity> = Vec::new();
    let own = setting.posture.self_clearance_m + extra_m;
    robot
        .collision
        .self_proximities(robot, kinematics, own + LOOK_M, &mut found);
    out.extend(found.iter().map(|pair| near(pair, kinematics, own)));

    found.clear();
    let air = task.swing.as_ref().map(|swing| {
        let patch = &robot.patches[swing.patch];
        let X_WC: Isometry3<f64> = kinematics.X_WC(patch);
        (patch.body, Airborne::new(setting, swing, &X_WC))
    });
    let skip = |shape: BodyShape, obstacle: usize| {
        task.touches(setting, shape.body, obstacle)
            || air
                .as_ref()
                .is_some_and(|(body, air)| *body == shape.body && air.touches(setting, obstacle))
    };
    let beside = setting.posture.clearance_m;
    let most = beside.max(setting.config.swing_clearance_m) + extra_m;
    robot.collision.world_proximities(
        robot,
        kinematics,
        &setting.environment.world,
        most + LOOK_M,
        &skip,
        &mut found,
    );
    out.extend(found.iter().map(|pair| {
        let required = match &air {
            Some((body, air)) if *body == pair.a.body => air.required_m(setting, &pair.normal_W),
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
