//! The generalized forces that hold a robot still against gravity.

use nalgebra::{DVector, Vector3};

use super::Kinematics;
use crate::{GRAVITY_M_S2, JointKind, Robot};

impl Kinematics {
    /// Generalized gravity: what holds the robot up where nothing else does.
    ///
    ///   g(q) = ∂U/∂q,  U = Σ mᵢ g zᵢ        joint torques with contacts: τ = g(q) − Jᵀ f
    ///
    /// Shapes: g nv.  Units: N, N·m (base force, base moment about B's origin, joints).
    /// Frames: the base's entries in W, as v's; Pinocchio's sign, but its base entries are in B.
    pub fn gravity_torques(&self, robot: &Robot, g: &mut DVector<f64>) {
        assert_eq!(g.len(), robot.nv(), "one entry a velocity");
        let up = Vector3::z() * GRAVITY_M_S2;
        let weight = up * self.subtree_mass[0];
        let moment = (self.com_W - self.origin_W[0]).cross(&weight);
        g.fixed_rows_mut::<3>(0).copy_from(&weight);
        g.fixed_rows_mut::<3>(3).copy_from(&moment);
        for (i, body) in robot.bodies.iter().enumerate().skip(1) {
            let axis = &self.axis_W[i];
            let weight = up * self.subtree_mass[i];
            g[5 + i] = match body.kind {
                JointKind::Prismatic => axis.dot(&weight),
                _ => axis.dot(&(self.subtree_com_W[i] - self.origin_W[i]).cross(&weight)),
            };
        }
    }

    /// Potential energy of the robot above W's origin; J.
    pub fn potential_energy(&self) -> f64 {
        self.subtree_mass[0] * GRAVITY_M_S2 * self.com_W.z
    }
}
