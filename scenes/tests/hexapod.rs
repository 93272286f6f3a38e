//! The hexapod's files are what the generator writes, and it can stand on three legs.
#![allow(non_snake_case)]

#[path = "../examples/make_hexapod/facts.rs"]
mod facts;
#[path = "../examples/make_hexapod/files.rs"]
mod files;
#[path = "../examples/legged/mod.rs"]
mod legged;

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{Kinematics, PatchKind, Robot};

fn hexapod() -> Robot {
    scenes::builtin_robot("hexapod")
        .expect("it ships")
        .load(&robot_model::Config::default())
        .expect("it loads")
}

#[test]
fn files_are_what_the_generator_writes_now() {
    let shipped = scenes::builtin_robot("hexapod").expect("it ships");
    let embedded = [shipped.urdf, shipped.srdf, shipped.contacts];
    for ((name, text), embedded) in files::all().into_iter().zip(embedded) {
        assert!(text == embedded, "{name}: run the example make_hexapod");
    }
}

#[test]
fn it_stands_on_six_balls_in_a_circle() {
    let robot = hexapod();
    assert_eq!((robot.nj(), robot.patches.len()), (18, 6));
    assert!((robot.mass_kg - 200.0).abs() < 1e-9, "{}", robot.mass_kg);
    assert!(robot.notes.is_empty(), "{:?}", robot.notes);
    let q = robot.posture("standing").expect("a posture");
    robot
        .check_joints(q.joints.as_slice(), -0.1)
        .expect("well inside the limits");
    let kinematics = Kinematics::new(&robot, &q);
    for patch in &robot.patches {
        assert_eq!(
            patch.kind,
            PatchKind::Point {
                radius_m: facts::FOOT_RADIUS
            }
        );
        let p = kinematics.X_WC(patch).translation.vector;
        // Angles are written with ten decimals.
        assert!((p.xy().norm() - facts::STANCE_RADIUS).abs() < 1e-9, "{p}");
        let height = facts::STANCE_HEIGHT - facts::FOOT_RADIUS;
        assert!((p.z + height).abs() < 1e-9, "{p}");
    }
}

/// τ = g(q) − Jᵀf with a third of the weight on every other foot, straight up.
#[test]
fn three_legs_hold_it_within_its_torques() {
    let robot = hexapod();
    let q = robot.posture("standing").expect("a posture");
    let kinematics = Kinematics::new(&robot, &q);
    let mut torque = DVector::zeros(robot.nv());
    kinematics.gravity_torques(&robot, &mut torque);
    let mut J = DMatrix::zeros(3, robot.nv());
    for patch in robot.patches.iter().step_by(2) {
        let ball = kinematics.X_WC(patch).translation.vector;
        let touched = ball - Vector3::new(0.0, 0.0, facts::FOOT_RADIUS);
        kinematics.point_jacobian(&robot, patch.body, &touched, &mut J);
        let share = robot.mass_kg * robot_model::GRAVITY_M_S2 / 3.0;
        torque -= J.transpose() * Vector3::new(0.0, 0.0, share);
    }
    // The base is in balance: the three feet are around its middle.
    assert!(torque.rows(0, 6).norm() < 1e-6, "{torque}");
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        let used = torque[6 + j].abs() / body.effort;
        assert!(used <= 0.8, "{} uses {used} of its torque", body.joint);
    }
    // The estimate is not idle: the thigh needs more than half of it.
    assert!(torque.iter().fold(0.0_f64, |a, t| a.max(t.abs())) > 200.0);
}
