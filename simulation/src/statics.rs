//! The torques that hold a robot still.

use nalgebra::{DMatrix, DVector};
use robot_model::{Kinematics, Robot};

use crate::reference::ReferenceState;

/// τ = g(q) − Σ Jᵀ f of the joints; nj.
pub fn holding_torques(robot: &Robot, wanted: &ReferenceState) -> Vec<f64> {
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
