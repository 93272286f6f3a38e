//! The robots that ship: their files are what the generator writes, and they can stand.

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{GRAVITY_M_S2, Kinematics, PatchKind, Robot};
use scenes::{camera_set, stances};

use crate::make_robots;

/// Of the hexapods: distance of the feet from the body's middle and height of the hips while they
/// stand, and the radius of the feet's balls.
const HEXAPOD_STANCE: [f64; 3] = [0.78, 0.68, 0.02];
/// Of the quadruped: the thighs' axes ahead and to the side, height of the hips while it stands, and
/// the radius of the feet's balls.
const QUADRUPED_STANCE: [f64; 4] = [0.33, 0.21, 0.55, 0.015];
/// The quadruped's legs, ahead and to the left.
const QUADRUPED_LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("rear_left", [-1.0, 1.0]),
    ("rear_right", [-1.0, -1.0]),
    ("front_right", [1.0, -1.0]),
];

/// A robot that ships.
pub fn shipped(name: &str) -> Robot {
    scenes::robot(name).expect("it ships")
}

#[test]
fn files_are_what_the_generator_writes_now() {
    for name in make_robots::NAMES {
        let shipped = scenes::builtin_robot(name).expect("it ships");
        let embedded = [shipped.urdf, shipped.srdf, shipped.contacts];
        for ((file, text), embedded) in make_robots::files(name).unwrap().into_iter().zip(embedded)
        {
            let file = file.display();
            assert!(text == embedded, "{file}: run the example make_robots");
        }
    }
}

#[test]
fn they_weigh_what_they_should_and_nothing_is_assumed_of_them() {
    for (name, joints, patches, mass_kg, posture, inside) in [
        ("hrp2", 30, 4, 58.0, "half_sitting", 0.0),
        ("hexapod", 18, 6, 200.0, "standing", 0.1),
        ("hexapod_urp", 18, 6, 200.0, "standing", 0.1),
        ("quadruped", 12, 4, 50.0, "standing", 0.1),
    ] {
        let robot = shipped(name);
        let counted = (robot.nj(), robot.patches.len());
        assert_eq!(counted, (joints, patches), "{name}");
        let weighed = robot.mass_kg;
        assert!((weighed - mass_kg).abs() < 1e-6, "{name}: {weighed} kg");
        assert!(robot.notes.is_empty(), "{name}: {:?}", robot.notes);
        let q = robot.posture(posture).expect("a posture");
        robot
            .check_joints(q.joints.as_slice(), -inside)
            .expect("inside the limits");
        assert!(robot.colliding_pairs(&q).is_empty(), "{name}");
        for body in &robot.bodies {
            let moments = body.inertia_B.symmetric_eigenvalues();
            let (least, greatest) = (moments.min(), moments.max());
            // Positive definite, and the triangle inequality.
            let spare = moments.sum() - 2.0 * greatest;
            assert!(least > 0.0 && spare > 0.0, "{}: {moments}", body.name);
        }
    }
}

#[test]
fn balls_stand_where_the_postures_should_put_them() {
    let [around, height, radius_m] = HEXAPOD_STANCE;
    for name in ["hexapod", "hexapod_urp"] {
        let robot = shipped(name);
        let kinematics = Kinematics::new(&robot, &robot.posture("standing").unwrap());
        for patch in &robot.patches {
            assert_eq!(patch.kind, PatchKind::Point { radius_m });
            let p = kinematics.X_WC(patch).translation.vector;
            // Joint values are written with ten decimals.
            assert!((p.xy().norm() - around).abs() < 1e-9, "{p}");
            assert!((p.z + height - radius_m).abs() < 1e-9, "{p}");
        }
    }
    let robot = shipped("quadruped");
    let kinematics = Kinematics::new(&robot, &robot.posture("standing").unwrap());
    for (patch, (leg, [front, left])) in robot.patches.iter().zip(QUADRUPED_LEGS) {
        let [x, y, height, radius_m] = QUADRUPED_STANCE;
        let expected = (leg, PatchKind::Point { radius_m });
        assert_eq!((patch.name.as_str(), patch.kind), expected);
        let expected = Vector3::new(front * x, left * y, radius_m - height);
        let p = kinematics.X_WC(patch).translation.vector;
        assert!((p - expected).norm() < 1e-9, "{leg}: {p}");
    }
}

/// τ = g(q) − Jᵀf with a third of the weight on each of three feet, straight up.
#[test]
fn three_legs_hold_them_within_their_efforts() {
    // Robot, feet, whether they are around its middle, and what the busiest joint needs at least:
    // the estimates of efforts are not idle.
    for (name, feet, is_balanced, least) in [
        ("hexapod", [0, 2, 4], true, 200.0),
        ("hexapod_urp", [0, 2, 4], true, 300.0),
        ("quadruped", [0, 1, 2], false, 30.0),
    ] {
        let robot = shipped(name);
        let kinematics = Kinematics::new(&robot, &robot.posture("standing").unwrap());
        let mut torque = DVector::zeros(robot.nv());
        kinematics.gravity_torques(&robot, &mut torque);
        let mut J = DMatrix::zeros(3, robot.nv());
        for patch in feet.map(|foot| &robot.patches[foot]) {
            let touched = kinematics.X_WC(patch).translation.vector
                - Vector3::z() * patch.point_radius_m().unwrap();
            kinematics.point_jacobian(&robot, patch.body, &touched, &mut J);
            let share = robot.mass_kg * GRAVITY_M_S2 / 3.0;
            torque -= J.transpose() * Vector3::new(0.0, 0.0, share);
        }
        let balanced = torque.rows(0, 6).norm() < 1e-6;
        assert_eq!(balanced, is_balanced, "{name}: {torque}");
        for (j, body) in robot.joint_bodies().iter().enumerate() {
            let used = torque[6 + j].abs() / body.effort;
            assert!(used <= 0.8, "{name}: {} uses {used}", body.joint);
        }
        assert!(torque.rows(6, robot.nj()).amax() > least, "{name}");
    }
}

/// [chai2015] Table A1 is within both trees' reach, the feet where they stand.
#[test]
fn both_hexapods_take_the_52_poses() {
    let [around, _, radius_m] = HEXAPOD_STANCE;
    for name in ["hexapod", "hexapod_urp"] {
        let robot = shipped(name);
        for stance in stances::TABLE_A1 {
            let X_GR = stances::X_GR(stance);
            let q = camera_set::readings(&robot, "standing", &X_GR)
                .unwrap_or_else(|error| panic!("{name}, {stance:?}: {error}"));
            robot.check_joints(q.joints.as_slice(), 0.0).expect(name);
            let kinematics = Kinematics::new(&robot, &q);
            for patch in &robot.patches {
                let p = kinematics.X_WC(patch).translation.vector;
                let off = (p.xy().norm() - around).abs();
                let above = (p.z - radius_m).abs();
                assert!(off < 1e-8 && above < 1e-8, "{p}");
            }
        }
    }
}
