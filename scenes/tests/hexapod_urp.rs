//! The hexapod on sliding legs: its files are what the generator writes, it can stand on three legs,
//! and both hexapods take the published poses.
#![allow(non_snake_case)]

#[allow(dead_code)]
#[path = "../examples/make_hexapod/facts.rs"]
mod facts;
#[path = "../examples/make_hexapod_urp/files.rs"]
mod files;
#[allow(dead_code)]
#[path = "../examples/legged/mod.rs"]
mod legged;

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{Kinematics, Robot};
use scenes::{camera_set, stances};

fn robot(name: &str) -> Robot {
    scenes::builtin_robot(name)
        .expect("it ships")
        .load(&robot_model::Config::default())
        .expect("it loads")
}

#[test]
fn files_are_what_the_generator_writes_now() {
    let shipped = scenes::builtin_robot("hexapod_urp").expect("it ships");
    let embedded = [shipped.urdf, shipped.srdf, shipped.contacts];
    for ((name, text), embedded) in files::all().into_iter().zip(embedded) {
        assert!(text == embedded, "{name}: run the example make_hexapod_urp");
    }
}

#[test]
fn it_stands_where_the_other_tree_stands() {
    let robot = robot("hexapod_urp");
    assert_eq!((robot.nj(), robot.patches.len()), (18, 6));
    assert!((robot.mass_kg - 200.0).abs() < 1e-9, "{}", robot.mass_kg);
    assert!(robot.notes.is_empty(), "{:?}", robot.notes);
    let q = robot.posture("standing").expect("a posture");
    robot
        .check_joints(q.joints.as_slice(), -0.1)
        .expect("well inside the limits");
    assert!(robot.colliding_pairs(&q).is_empty());
    let kinematics = Kinematics::new(&robot, &q);
    for patch in &robot.patches {
        let p = kinematics.X_WC(patch).translation.vector;
        // Joint values are written with ten decimals.
        assert!((p.xy().norm() - facts::STANCE_RADIUS).abs() < 1e-9, "{p}");
        let height = facts::STANCE_HEIGHT - facts::FOOT_RADIUS;
        assert!((p.z + height).abs() < 1e-9, "{p}");
    }
}

/// τ = g(q) − Jᵀf with a third of the weight on every other foot, straight up.
#[test]
fn three_legs_hold_it_within_its_efforts() {
    let robot = robot("hexapod_urp");
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
    assert!(torque.rows(0, 6).norm() < 1e-6, "{torque}");
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        let used = torque[6 + j].abs() / body.effort;
        assert!(used <= 0.8, "{} uses {used} of its effort", body.joint);
    }
    // The estimate is not idle: a hip needs more than half of what it has.
    assert!(torque.iter().fold(0.0_f64, |a, t| a.max(t.abs())) > 300.0);
}

/// [chai2015] Table A1 is within both trees' reach, the feet where they stand.
#[test]
fn both_trees_take_the_52_poses() {
    for name in ["hexapod", "hexapod_urp"] {
        let robot = robot(name);
        for stance in stances::TABLE_A1 {
            let X_GR = stances::X_GR(stance);
            let q = camera_set::readings(&robot, "standing", &X_GR)
                .unwrap_or_else(|error| panic!("{name}, {stance:?}: {error}"));
            robot.check_joints(q.joints.as_slice(), 0.0).expect(name);
            let kinematics = Kinematics::new(&robot, &q);
            for patch in &robot.patches {
                let p = kinematics.X_WC(patch).translation.vector;
                let off = (p.xy().norm() - facts::STANCE_RADIUS).abs();
                assert!(off < 1e-8 && (p.z - facts::FOOT_RADIUS).abs() < 1e-8, "{p}");
            }
        }
    }
}
