//! The controller on the humanoid: at rest and drifting.

use nalgebra::{DMatrix, DVector};
use robot_model::{Kinematics, Robot};
use simulation::Config;
use simulation::physics::Physics;
use simulation::reference::ReferenceState;
use simulation::whole_body::WholeBodyController;

use crate::robot::{half_sitting, hrp2, standing};

fn torques(wanted: &ReferenceState, v: &DVector<f64>) -> Vec<f64> {
    let robot = hrp2();
    let physics = Physics::from(&Config::default());
    let mut controller = WholeBodyController::new(&robot, &physics).unwrap();
    let touching = vec![true; robot.patches.len()];
    let found = controller.torques(&wanted.configuration, v, wanted, &touching);
    found.unwrap().to_vec()
}

#[test]
fn at_rest_the_torques_are_those_that_hold() {
    let robot = hrp2();
    let stance = standing(&robot, half_sitting(&robot), &["left_foot", "right_foot"]);
    let found = torques(&stance, &DVector::zeros(robot.nv()));
    let expected = holding_torques(&robot, &stance);
    for (j, (a, b)) in found.iter().zip(&expected).enumerate() {
        // Forces are a task of little weight, so they come out a little off the plan's.
        assert!((a - b).abs() < 0.5, "joint {j}: {a} N·m, {b} N·m");
    }
}

#[test]
fn a_robot_that_drifts_is_pulled_back() {
    let robot = hrp2();
    let stance = standing(&robot, half_sitting(&robot), &["left_foot", "right_foot"]);
    let mut v = DVector::zeros(robot.nv());
    // The base moves forward: both ankles push the toes down.
    v[0] = 0.2;
    let at_rest = torques(&stance, &DVector::zeros(robot.nv()));
    let drifting = torques(&stance, &v);
    for name in ["LLEG_JOINT4", "RLEG_JOINT4"] {
        let joint = robot.joint_index(name).unwrap();
        assert!(drifting[joint] > at_rest[joint] + 1.0, "{name}");
    }
}

/// A foot that has crept by a few millimetres, slower than any estimator sees, is drawn to where it closed.
#[test]
fn a_contact_that_creeps_is_drawn_back() {
    let robot = hrp2();
    let feet = ["left_foot", "right_foot"];
    let hip = robot.joint_index("RLEG_JOINT1").unwrap();
    let closed = standing(&robot, half_sitting(&robot), &feet);
    let mut turned = half_sitting(&robot);
    turned.joints[hip] += 0.01;
    let crept = standing(&robot, turned, &feet);
    let (physics, v) = (
        Physics::from(&Config::default()),
        DVector::zeros(robot.nv()),
    );
    let touching = vec![true; robot.patches.len()];
    let hip_torque = |states: &[&ReferenceState]| {
        let mut controller = WholeBodyController::new(&robot, &physics).unwrap();
        let mut torque = |state: &&ReferenceState| {
            let found = controller.torques(&state.configuration, &v, state, &touching);
            found.unwrap()[hip]
        };
        states.iter().map(&mut torque).last().unwrap()
    };
    let (back, new) = (hip_torque(&[&closed, &crept]), hip_torque(&[&crept]));
    assert!(
        back < new - 0.2,
        "{back} N·m, {new} N·m where it closed there"
    );
}

/// τ = g(q) − Σ Jᵀ f of the joints; nj.
fn holding_torques(robot: &Robot, wanted: &ReferenceState) -> Vec<f64> {
    let kinematics = Kinematics::new(robot, &wanted.configuration);
    let mut whole = DVector::zeros(robot.nv());
    kinematics.gravity_torques(robot, &mut whole);
    let mut J = DMatrix::zeros(3, robot.nv());
    for contact in &wanted.contacts {
        let body = robot.patches[contact.patch].body;
        kinematics.point_jacobian(robot, body, &contact.X_WC.translation.vector, &mut J);
        whole -= J.tr_mul(&contact.force_W);
        kinematics.angular_jacobian(robot, body, &mut J);
        whole -= J.tr_mul(&contact.moment_W);
    }
    whole.as_slice()[6..].to_vec()
}
