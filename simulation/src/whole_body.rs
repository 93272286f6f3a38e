//! The whole-body controller: accelerations and contact forces from one quadratic program.
//!
//!   min Σ w ‖A v̇ + b − a*‖² + w_f ‖f − f_plan‖²         x = [v̇, f]
//!   s.t.  M_b v̇ + h_b = J_bᵀ f                          floating base
//!         |M_a v̇ + h_a − J_aᵀ f| ≤ τ_max                joints
//!         |f_x|, |f_y| ≤ μ/√2 f_z   at every corner      friction, the planner's pyramid
//!
//! Forces act at the corners of each closed patch, drawn in by a margin: a corner outside the real
//! patch fells the robot. Torques follow as τ = M_a v̇ + h_a − J_aᵀ f.
#![allow(non_snake_case)]

mod tasks;

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Vector3};
use robot_model::{Configuration, Robot};

use crate::Error;
use crate::config::{Physics, Task, WholeBody};
use crate::corners::Corners;
use crate::course::{Wanted, WantedContact};
use crate::dynamics::Dynamics;
use crate::qp::{RowSet, Solver};
use tasks::{Offset, Stack, follow};

/// Forces enter the program in this unit, N: it is of the size of accelerations then.
const FORCE_UNIT_N: f64 = 100.0;

/// The controller of one robot, with its memory.
pub struct WholeBodyController<'a> {
    robot: &'a Robot,
    config: WholeBody,
    physics: Physics,
    corners: Vec<Corners>,
    solver: Solver,
    /// The robot as it is.
    now: Dynamics,
    /// The robot as it should be.
    reference: Dynamics,
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    rows: RowSet,
    torques: Vec<f64>,
    /// How far each patch was off its reference when it was last closed.
    offsets: Vec<Offset>,
}

/// How a patch is treated.
enum Role<'w> {
    /// It touches and bears force.
    Closed(&'w WantedContact),
    /// It should touch and does not yet: on toward the surface.
    Searching(&'w WantedContact),
    /// It follows its reference through the air, on its way to a place or not.
    Swinging,
    Aloft,
}

impl<'a> WholeBodyController<'a> {
    /// A controller.
    ///
    /// # Errors
    /// [`Error::Robot`] where a patch is too small for the corners' inset.
    pub fn new(robot: &'a Robot, config: &WholeBody, physics: &Physics) -> Result<Self, Error> {
        let corners = robot
            .patches
            .iter()
            .map(|patch| Corners::new(patch, config.corner_inset_m))
            .collect::<Result<_, _>>()?;
        let start = robot.neutral();
        Ok(Self {
            robot,
            config: config.clone(),
            physics: physics.clone(),
            corners,
            solver: Solver::default(),
            now: Dynamics::new(robot, &start),
            reference: Dynamics::new(robot, &start),
            hessian: DMatrix::zeros(0, 0),
            gradient: DVector::zeros(0),
            rows: RowSet::default(),
            torques: vec![0.0; robot.nj()],
            offsets: vec![Offset::default(); robot.patches.len()],
        })
    }

    /// The joint torques at a state; `touching` says which patches do, by the robot's patches.
    ///
    /// Shapes: v nv, result nj.  Units: N·m (N where prismatic).
    /// # Errors
    /// [`Error::Controller`] where the program has no solution.
    pub fn torques(
        &mut self,
        configuration: &Configuration,
        v: &DVector<f64>,
        wanted: &Wanted,
        touching: &[bool],
    ) -> Result<&[f64], Error> {
        let robot = self.robot;
        let nv = robot.nv();
        self.now.update(robot, configuration, v);
        self.reference
            .update_motion(robot, &wanted.configuration, &wanted.v);
        for j in 6..nv {
            self.now.M[(j, j)] += self.physics.armature;
            self.now.h[j] += self.physics.damping * v[j];
        }
        // A patch that lands early bears from then on.
        let closed: Vec<&WantedContact> = wanted
            .contacts
            .iter()
            .chain(&wanted.landing)
            .filter(|c| touching[c.patch])
            .collect();
        let J = self.corner_jacobian(&closed);
        let n = nv + J.nrows();
        self.cost(configuration, v, wanted, &closed, n);
        self.constraints(&closed, &J);
        let x = self
            .solver
            .solve(&self.hessian, self.gradient.as_slice(), &self.rows)?;
        let v_dot = DVector::from_column_slice(&x[..nv]);
        let f = DVector::from_column_slice(&x[nv..]) * FORCE_UNIT_N;
        let whole = &self.now.M * v_dot + &self.now.h - J.tr_mul(&f);
        self.torques.copy_from_slice(&whole.as_slice()[6..]);
        Ok(&self.torques)
    }

    /// Jacobian of all corners of the closed contacts in the contacts' own axes, 3k × nv: the
    /// dual forces are in C's axes, where the friction pyramid is.
    fn corner_jacobian(&self, closed: &[&WantedContact]) -> DMatrix<f64> {
        let count: usize = closed.iter().map(|c| self.corners[c.patch].count()).sum();
        let mut J = DMatrix::zeros(3 * count, self.robot.nv());
        let mut row = 0;
        for contact in closed {
            let patch = &self.robot.patches[contact.patch];
            let kinematics = &self.now.kinematics;
            let X_WC = kinematics.X_WC(patch);
            let R_CW = contact_axes(&X_WC, contact, patch.point_radius_m().is_some()).transpose();
            for p_W in self.corners[contact.patch].points_W(&X_WC, contact) {
                let mut block = DMatrix::zeros(3, self.robot.nv());
                kinematics.point_jacobian(self.robot, patch.body, &p_W, &mut block);
                J.rows_mut(row, 3).copy_from(&(R_CW * block));
                row += 3;
            }
        }
        J
    }

    /// H and g.
    fn cost(
        &mut self,
        configuration: &Configuration,
        v: &DVector<f64>,
        wanted: &Wanted,
        closed: &[&WantedContact],
        n: usize,
    ) {
        let (robot, config) = (self.robot, self.config.clone());
        let nv = robot.nv();
        let mut stack = Stack::new(nv, 6 + 6 * robot.patches.len());
        let (now, reference) = (&self.now, &self.reference);

        // Centre of mass.
        let J = stack.block();
        now.kinematics.com_jacobian(robot, J);
        let mut J_ref = DMatrix::zeros(3, nv);
        reference.kinematics.com_jacobian(robot, &mut J_ref);
        let a_ref =
            Vector3::from_iterator((J_ref * &wanted.a).iter().copied()) + reference.com_bias_W;
        let a_com = a_ref
            + (reference.kinematics.com_W - now.kinematics.com_W) * config.com.kp
            + (reference.com_velocity_W - now.com_velocity_W) * config.com.kd;
        stack.close(config.com.weight, &(a_com - now.com_bias_W));

        // Orientation of the base.
        let J = stack.block();
        now.kinematics.angular_jacobian(robot, 0, J);
        let turn = (wanted.configuration.R_WB * configuration.R_WB.inverse()).scaled_axis();
        let a_base = wanted.a.fixed_rows::<3>(3)
            + turn * config.base.kp
            + (wanted.v.fixed_rows::<3>(3) - v.fixed_rows::<3>(3)) * config.base.kd;
        stack.close(config.base.weight, &a_base);

        // Patches: closed ones stay, those in the air follow their reference.
        for (index, patch) in robot.patches.iter().enumerate() {
            let planned = wanted.contacts.iter().find(|c| c.patch == index);
            let role = match (planned, closed.iter().find(|c| c.patch == index)) {
                (_, Some(contact)) => Role::Closed(contact),
                (Some(contact), None) => Role::Searching(contact),
                (None, None) if wanted.swing == Some(index) => Role::Swinging,
                (None, None) => Role::Aloft,
            };
            let X_WC = now.kinematics.X_WC(patch);
            let X_ref = reference.kinematics.X_WC(patch);
            if let Role::Closed(_) = role {
                self.offsets[index] = Offset::of(&X_WC, &X_ref);
            }
            let is_point = patch.point_radius_m().is_some();
            let p_W = match role {
                // A ball rolls: it is the touching point that stays.
                Role::Closed(contact) if is_point => {
                    self.corners[index].points_W(&X_WC, contact)[0]
                }
                _ => X_WC.translation.vector,
            };
            let (velocity, omega) = (
                now.point_velocity(patch.body, &p_W),
                now.omega_W[patch.body],
            );
            let (mut linear, mut angular) = match role {
                Role::Closed(_) => (
                    velocity * -config.contact_damping,
                    omega * -config.contact_damping,
                ),
                Role::Searching(contact) => {
                    let down = contact.X_WC.rotation * -Vector3::z() * config.search_speed_m_s;
                    let turn = (contact.X_WC.rotation * X_WC.rotation.inverse()).scaled_axis();
                    (
                        (down - velocity) * config.swing.kd,
                        turn * config.swing.kp - omega * config.swing.kd,
                    )
                }
                Role::Swinging | Role::Aloft => {
                    let X_to = self.offsets[index].applied(&X_ref, config.period_s);
                    let states = (now, reference);
                    follow(&config.swing, robot, index, &X_to, states, &wanted.a)
                }
            };
            linear -= now.point_bias(patch.body, &p_W);
            angular -= now.bias_alpha_W[patch.body];
            let weight = match role {
                Role::Closed(_) => config.contact_weight,
                Role::Searching(_) | Role::Swinging => config.swing.weight,
                Role::Aloft => config.aloft_weight,
            };
            let J = stack.block();
            now.kinematics.point_jacobian(robot, patch.body, &p_W, J);
            stack.close(weight, &linear);
            if !is_point {
                let J = stack.block();
                now.kinematics.angular_jacobian(robot, patch.body, J);
                stack.close(weight, &angular);
            }
        }

        // Gauss–Newton of the stack, then posture and forces on the diagonal.
        let (A, b) = stack.finish();
        self.hessian = DMatrix::zeros(n, n);
        self.gradient = DVector::zeros(n);
        self.hessian
            .view_mut((0, 0), (nv, nv))
            .gemm_tr(1.0, &A, &A, 0.0);
        self.gradient.rows_mut(0, nv).gemv_tr(-1.0, &A, &b, 0.0);
        let Task { weight, kp, kd } = config.posture;
        for j in 0..nv {
            // The base's freedoms follow from the tasks; a little weight keeps H definite.
            let (w, a) = if j < 6 {
                (1e-3, wanted.a[j])
            } else {
                let e = wanted.configuration.joints[j - 6] - configuration.joints[j - 6];
                (weight, wanted.a[j] + kp * e + kd * (wanted.v[j] - v[j]))
            };
            self.hessian[(j, j)] += w;
            self.gradient[j] -= w * a;
        }
        let mut at = nv;
        let w = config.force_weight * FORCE_UNIT_N * FORCE_UNIT_N;
        for contact in closed {
            let patch = &robot.patches[contact.patch];
            let X_WC = now.kinematics.X_WC(patch);
            let R = contact_axes(&X_WC, contact, patch.point_radius_m().is_some());
            for f in self.corners[contact.patch].spread(contact, &R) {
                for axis in 0..3 {
                    self.hessian[(at, at)] += w;
                    self.gradient[at] -= w * f[axis] / FORCE_UNIT_N;
                    at += 1;
                }
            }
        }
    }

    /// Floating base, torque limits, friction.
    fn constraints(&mut self, closed: &[&WantedContact], J: &DMatrix<f64>) {
        let nv = self.robot.nv();
        let (M, h, rows) = (&self.now.M, &self.now.h, &mut self.rows);
        rows.clear();
        for i in 0..nv {
            let (lower, upper) = if i < 6 {
                (-h[i], -h[i])
            } else {
                let effort = self.robot.bodies[i - 5].effort;
                if !effort.is_finite() {
                    continue;
                }
                (-effort - h[i], effort - h[i])
            };
            for j in 0..nv {
                rows.entry(j, M[(i, j)]);
            }
            for k in 0..J.nrows() {
                rows.entry(nv + k, -J[(k, i)] * FORCE_UNIT_N);
            }
            rows.end(lower, upper);
        }
        let mut at = nv;
        for contact in closed {
            let mu = contact.friction * self.config.friction_use * std::f64::consts::FRAC_1_SQRT_2;
            for _ in 0..self.corners[contact.patch].count() {
                for axis in 0..2 {
                    for sign in [1.0, -1.0] {
                        rows.entry(at + axis, sign);
                        rows.entry(at + 2, mu);
                        rows.end(0.0, f64::INFINITY);
                    }
                }
                at += 3;
            }
        }
    }
}

/// The axes in which a contact's friction pyramid stands: those of the patch, or of the planned
/// contact where the patch is a ball.
fn contact_axes(X_WC: &Isometry3<f64>, contact: &WantedContact, is_point: bool) -> Matrix3<f64> {
    let axes = |X: &Isometry3<f64>| X.rotation.to_rotation_matrix().into_inner();
    if is_point {
        robot_model::pyramid_axes_W(&axes(&contact.X_WC))
    } else {
        axes(X_WC)
    }
}

#[cfg(test)]
mod tests;
