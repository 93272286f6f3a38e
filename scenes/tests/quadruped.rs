//! The quadruped's files are what the generator writes, and it can stand on three legs.
#![allow(non_snake_case)]

#[path = "../examples/make_quadruped/facts.rs"]
mod facts;
#[path = "../examples/make_quadruped/files.rs"]
mod files;
#[path = "../examples/legged/mod.rs"]
mod legged;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use robot_model::{Kinematics, PatchKind, Robot};

fn quadruped() -> Robot {
    scenes::builtin_robot("quadruped")
        .expect("it ships")
        .load(&robot_model::Config::default())
        .expect("it loads")
}

#[test]
fn files_are_what_the_generator_writes_now() {
    let shipped = scenes::builtin_robot("quadruped").expect("it ships");
    let embedded = [shipped.urdf, shipped.srdf, shipped.contacts];
    for ((name, text), embedded) in files::all().into_iter().zip(embedded) {
        assert!(text == embedded, "{name}: run the example make_quadruped");
    }
}

#[test]
fn it_stands_on_four_balls_below_its_thighs() {
    let robot = quadruped();
    assert_eq!((robot.nj(), robot.patches.len()), (12, 4));
    assert!((robot.mass_kg - 50.0).abs() < 1e-9, "{}", robot.mass_kg);
    assert!(robot.notes.is_empty(), "{:?}", robot.notes);
    let q = robot.posture("standing").expect("a posture");
    robot
        .check_joints(q.joints.as_slice(), -0.1)
        .expect("well inside the limits");
    let kinematics = Kinematics::new(&robot, &q);
    for (patch, (leg, [front, left])) in robot.patches.iter().zip(facts::LEGS) {
        assert_eq!(patch.name, leg);
        assert_eq!(
            patch.kind,
            PatchKind::Point {
                radius_m: facts::FOOT_RADIUS
            }
        );
        let p = kinematics.X_WC(patch).translation.vector;
        let [x, y] = facts::HIP;
        let expected = Vector3::new(
            front * x,
            left * (y + facts::ABDUCTION),
            facts::FOOT_RADIUS - facts::STANCE_HEIGHT,
        );
        // Angles are written with ten decimals.
        assert!((p - expected).norm() < 1e-9, "{leg}: {p}");
    }
}

/// τ = g(q) − Jᵀf with the weight on three feet, straight up, as the lever arms divide it.
#[test]
fn three_legs_hold_it_within_its_torques() {
    let robot = quadruped();
    let q = robot.posture("standing").expect("a posture");
    let kinematics = Kinematics::new(&robot, &q);
    let mut torque = DVector::zeros(robot.nv());
    kinematics.gravity_torques(&robot, &mut torque);
    let weight = robot.mass_kg * robot_model::GRAVITY_M_S2;
    let feet: Vec<_> = robot.patches.iter().take(3).collect();
    let touched = |patch: &robot_model::ContactPatch| {
        kinematics.X_WC(patch).translation.vector - Vector3::new(0.0, 0.0, facts::FOOT_RADIUS)
    };
    // Shares f with Σ f = 1 and Σ f p = c, where the centre of mass is moved to be inside.
    let middle = feet.iter().map(|p| touched(p)).sum::<Vector3<f64>>() / 3.0;
    let p = Matrix3::from_columns(&[0, 1, 2].map(|i| {
        let p = touched(feet[i]);
        Vector3::new(p.x, p.y, 1.0)
    }));
    let shares = p
        .lu()
        .solve(&Vector3::new(middle.x, middle.y, 1.0))
        .expect("no line");
    let mut J = DMatrix::zeros(3, robot.nv());
    for (patch, share) in feet.iter().zip(shares.iter()) {
        kinematics.point_jacobian(&robot, patch.body, &touched(patch), &mut J);
        torque -= J.transpose() * Vector3::new(0.0, 0.0, share * weight);
    }
    for (j, body) in robot.joint_bodies().iter().enumerate() {
        let used = torque[6 + j].abs() / body.effort;
        assert!(used <= 0.8, "{} uses {used} of its torque", body.joint);
    }
    // The limit is not idle.
    assert!(torque.rows(6, 12).amax() > 30.0);
}
