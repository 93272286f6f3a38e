//! Link poses, centre of mass, gravity torques and Jacobians against Pinocchio.
//!
//! The values were made by `tests/golden/make_golden.py`; its docstring has the command.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3};
use robot_model::{Configuration, Kinematics, Robot, RobotFiles, load};
use serde::Deserialize;

use crate::support;

/// Both sides round at 1e-16 of a few metres or hundreds of N·m.
const TOLERANCE: f64 = 1e-9;

#[derive(Deserialize)]
struct Golden {
    mass_kg: f64,
    configurations: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    p_WB: [f64; 3],
    quat_xyzw: [f64; 4],
    joints: BTreeMap<String, f64>,
    poses: BTreeMap<String, Pose>,
    com: [f64; 3],
    com_jacobian: Jacobian,
    gravity: Gravity,
    jacobians: BTreeMap<String, Jacobian>,
}

#[derive(Deserialize)]
struct Pose {
    p: [f64; 3],
    quat_xyzw: [f64; 4],
}

/// Rows of the base's six columns, and a column a joint.
#[derive(Deserialize)]
struct Jacobian {
    base: Vec<Vec<f64>>,
    joints: BTreeMap<String, Vec<f64>>,
}

#[derive(Deserialize)]
struct Gravity {
    force_W: [f64; 3],
    moment_W: [f64; 3],
    joints: BTreeMap<String, f64>,
}

#[test]
fn test_tree_agrees_with_pinocchio() {
    compare(&support::test_tree(), &support::golden("test_tree.json"));
}

#[test]
fn talos_agrees_with_pinocchio() {
    let Some(data) = support::robot_data() else {
        return;
    };
    let urdf = data.join("talos_data/robots/talos_reduced.urdf");
    let talos = load(&RobotFiles::new(urdf)).unwrap();
    compare(&talos, &support::golden("talos_reduced.json"));
}

fn compare(robot: &Robot, golden: &Path) {
    let golden: Golden = serde_json::from_str(&std::fs::read_to_string(golden).unwrap()).unwrap();
    assert!((robot.mass_kg - golden.mass_kg).abs() < TOLERANCE);
    assert!(!golden.configurations.is_empty());
    for sample in &golden.configurations {
        assert_eq!(sample.joints.len(), robot.nj(), "the same joints move");
        let joints = robot.joint_names().map(|name| sample.joints[name]);
        let base = sample.p_WB.iter().chain(&sample.quat_xyzw).copied();
        let q: Vec<f64> = base.chain(joints).collect();
        let kinematics = Kinematics::new(robot, &Configuration::from_q(&q).unwrap());
        compare_poses(robot, &kinematics, sample);
        compare_masses(robot, &kinematics, sample);
        compare_jacobians(robot, &kinematics, sample);
    }
}

fn compare_poses(robot: &Robot, kinematics: &Kinematics, sample: &Sample) {
    let (found, wanted) = (robot.frames.len(), sample.poses.len());
    assert_eq!(found, wanted, "every link has a pose");
    for (link, expected) in &sample.poses {
        let X_WL = kinematics.X_WL(robot, link).unwrap();
        let error = (X_WL.translation.vector - Vector3::from(expected.p)).norm();
        assert!(error < TOLERANCE, "{link}: {error}");
        let [i, j, k, w] = expected.quat_xyzw;
        let expected = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        // q and −q are one rotation, and the cosine is flat near 1.
        let inner = X_WL.rotation.dot(&expected);
        let error = (inner.abs() - 1.0).abs();
        assert!(error < TOLERANCE * TOLERANCE * 1e4, "{link}: {inner}");
    }
}

fn compare_masses(robot: &Robot, kinematics: &Kinematics, sample: &Sample) {
    assert!((kinematics.com_W - Vector3::from(sample.com)).norm() < TOLERANCE);
    let mut found = DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut found);
    let expected = &sample.gravity;
    let base = expected.force_W.iter().chain(&expected.moment_W);
    let joints = robot.joint_names().map(|name| &expected.joints[name]);
    let expected = DVector::from_iterator(robot.nv(), base.chain(joints).copied());
    let off = (&found - &expected).amax();
    assert!(off < TOLERANCE, "{found} {expected}");
}

fn compare_jacobians(robot: &Robot, kinematics: &Kinematics, sample: &Sample) {
    let mut J = DMatrix::zeros(6, robot.nv());
    for (link, expected) in &sample.jacobians {
        let frame = robot.frame(link).unwrap();
        let p_W = kinematics.X_WF(frame).translation.vector;
        kinematics.point_jacobian(robot, frame.body, &p_W, &mut J.rows_mut(0, 3));
        kinematics.angular_jacobian(robot, frame.body, &mut J.rows_mut(3, 3));
        compare_jacobian(robot, &J, expected);
    }
    let mut J = DMatrix::zeros(3, robot.nv());
    kinematics.com_jacobian(robot, &mut J);
    compare_jacobian(robot, &J, &sample.com_jacobian);
}

fn compare_jacobian(robot: &Robot, J: &DMatrix<f64>, expected: &Jacobian) {
    let names: Vec<&str> = robot.joint_names().collect();
    let entry = |row: usize, column: usize| match column {
        0..6 => expected.base[row][column],
        _ => expected.joints[names[column - 6]][row],
    };
    let expected = DMatrix::from_fn(expected.base.len(), robot.nv(), entry);
    assert!((J - &expected).amax() < TOLERANCE, "{J} {expected}");
}
