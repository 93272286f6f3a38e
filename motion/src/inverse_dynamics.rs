//! What accelerates every body, and what the joints must exert for it.
//!
//!   f_b = m_b c̈_b,   n_b = I_b α_b + ω_b × I_b ω_b + (c_b − o_b) × f_b
//!   τ_b = a_b·Σ_{beyond b} (n + (o − o_b) × f)   (revolute),   a_b·Σ f   (prismatic)
//!
//! Source: \[featherstone2008\] section 5.3, written out in W about body origins.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};
use robot_model::{JointKind, Kinematics, Robot};

/// A force, and its moment about the body's origin, for every body; N and N·m, in W.
pub(crate) type BodyForces = Vec<(Vector3<f64>, Vector3<f64>)>;

/// Accelerations of bodies at one configuration, with their memory.
pub(crate) struct Accelerations {
    /// Centre of mass of every body from its origin, m, and its inertia about that, kg·m², in W.
    com_W: Vec<Vector3<f64>>,
    inertia_W: Vec<Matrix3<f64>>,
    pub omega_W: Vec<Vector3<f64>>,
    pub alpha_W: Vec<Vector3<f64>>,
    /// Of the bodies' origins.
    pub linear_W: Vec<Vector3<f64>>,
}

impl Accelerations {
    pub fn new(robot: &Robot) -> Self {
        let zero = vec![Vector3::zeros(); robot.bodies.len()];
        Self {
            com_W: zero.clone(),
            inertia_W: vec![Matrix3::zeros(); robot.bodies.len()],
            omega_W: zero.clone(),
            alpha_W: zero.clone(),
            linear_W: zero,
        }
    }

    /// Moves to a configuration.
    pub fn update(&mut self, robot: &Robot, kinematics: &Kinematics) {
        for (i, (body, X_WB)) in robot.bodies.iter().zip(&kinematics.X_WB).enumerate() {
            let R = X_WB.rotation.to_rotation_matrix().into_inner();
            self.com_W[i] = R * body.com_B;
            self.inertia_W[i] = R * body.inertia_B * R.transpose();
        }
    }

    /// Acceleration of every body's centre of mass, m/s².
    pub fn of_masses(&self) -> impl Iterator<Item = Vector3<f64>> {
        let coms = self.com_W.iter().enumerate();
        coms.map(|(body, com)| self.point(body, com))
    }

    /// Acceleration of the point of `body` that is at `r` from its origin.
    pub fn point(&self, body: usize, r: &Vector3<f64>) -> Vector3<f64> {
        let omega = &self.omega_W[body];
        self.linear_W[body] + self.alpha_W[body].cross(r) + omega.cross(&omega.cross(r))
    }

    /// What accelerates every body at velocity `v` and acceleration `a`, written over `out`.
    ///
    /// Shapes: v, a nv, as [`robot_model::Configuration`] has them.
    pub fn forces(
        &mut self,
        robot: &Robot,
        kinematics: &Kinematics,
        (v, a): (&[f64], &[f64]),
        out: &mut BodyForces,
    ) {
        let three = |x: &[f64], k: usize| Vector3::new(x[k], x[k + 1], x[k + 2]);
        out.clear();
        for (i, body) in robot.bodies.iter().enumerate() {
            let (omega, alpha, linear) = match body.parent {
                None => (three(v, 3), three(a, 3), three(a, 0)),
                Some(parent) => {
                    let r = kinematics.origin_W[i] - kinematics.origin_W[parent];
                    let axis = &kinematics.axis_W[i];
                    let (rate, change) = (axis * v[5 + i], axis * a[5 + i]);
                    let omega = self.omega_W[parent];
                    let alpha = self.alpha_W[parent];
                    let linear = self.point(parent, &r);
                    if body.kind == JointKind::Prismatic {
                        (omega, alpha, linear + change + omega.cross(&rate) * 2.0)
                    } else {
                        (omega + rate, alpha + change + omega.cross(&rate), linear)
                    }
                }
            };
            (self.omega_W[i], self.alpha_W[i], self.linear_W[i]) = (omega, alpha, linear);
            let (com, inertia) = (&self.com_W[i], &self.inertia_W[i]);
            let force = self.point(i, com) * body.mass_kg;
            let spin = inertia * alpha + omega.cross(&(inertia * omega));
            out.push((force, spin + com.cross(&force)));
        }
    }
}

/// Sums the forces of bodies toward the base, in place, and writes what each joint exerts, N·m or N;
/// the first of `forces` is then what the base needs and nothing gives.
pub(crate) fn joint_torques(
    robot: &Robot,
    kinematics: &Kinematics,
    forces: &mut BodyForces,
    out: &mut [f64],
) {
    for (i, body) in robot.bodies.iter().enumerate().rev() {
        let Some(parent) = body.parent else { continue };
        let (force, moment) = forces[i];
        let along = match body.kind {
            JointKind::Prismatic => force,
            _ => moment,
        };
        out[i - 1] = kinematics.axis_W[i].dot(&along);
        let r = kinematics.origin_W[i] - kinematics.origin_W[parent];
        forces[parent].0 += force;
        forces[parent].1 += moment + r.cross(&force);
    }
}
