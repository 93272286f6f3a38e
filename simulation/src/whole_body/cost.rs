//! The tasks of the whole-body controller as one least-squares cost on accelerations and forces.

use nalgebra::{DMatrix, DVector, Vector3};
use robot_model::{Configuration, GRAVITY_M_S2};

use super::tasks::{Offset, Stack, Task, contact_axes, follow};
use super::{FORCE_UNIT_N, PERIOD_S, WholeBodyController};
use crate::reference::{ReferenceContact, ReferenceState};

/// The centre of mass follows its reference.
const COM: Task = task(400.0, 100.0, 20.0);
/// The base keeps its orientation.
const BASE: Task = task(100.0, 80.0, 18.0);
/// The patch in the air follows its reference, position and orientation.
const SWING: Task = task(200.0, 300.0, 35.0);
/// The joints follow their reference.
const POSTURE: Task = task(1.0, 60.0, 12.0);
/// Weight with which patches that are in the air and on their way to nothing follow their reference,
/// with the gains of [`SWING`].
const ALOFT_WEIGHT: f64 = 20.0;
/// Weight of contacts that do not accelerate, their damping, 1/s, and what draws them to where they closed, 1/s²: held
/// by its velocity alone, a hand that presses little creeps as the estimate of the base's velocity wanders. A ball rolls.
const CONTACT_WEIGHT: f64 = 1e4;
const CONTACT_DAMPING: f64 = 20.0;
const CONTACT_KP: f64 = 50.0;
/// Weight of the distance of the corner forces from those of the plan over what each corner of the contact is to
/// press, 1/N, and the part of the weight that it counts as pressing at least: a hand that is about to leave does
/// not slip for what a foot can bear as well.
const FORCE_WEIGHT: f64 = 7e-4;
const PRESSING: f64 = 0.005;
/// Speed at which a patch that should touch and does not is moved on toward its place, m/s.
const SEARCH_SPEED_M_S: f64 = 0.15;
/// Weight that keeps the base's accelerations definite: they follow from the tasks.
const BASE_WEIGHT: f64 = 1e-3;

const fn task(weight: f64, kp: f64, kd: f64) -> Task {
    Task { weight, kp, kd }
}

/// How a patch is treated.
enum Role<'w> {
    /// It touches and bears force.
    Closed(&'w ReferenceContact),
    /// It should touch and does not yet: on toward the surface.
    Searching(&'w ReferenceContact),
    /// It follows its reference through the air, on its way to a place or not.
    Swinging,
    Aloft,
}

impl WholeBodyController<'_> {
    /// Sets H and g at a state: n columns, the accelerations and the forces of the closed contacts.
    pub(super) fn cost(
        &mut self,
        configuration: &Configuration,
        v: &DVector<f64>,
        wanted: &ReferenceState,
        closed: &[&ReferenceContact],
        n: usize,
    ) {
        let nv = self.robot.nv();
        let mut stack = Stack::new(nv, 6 + 6 * self.robot.patches.len());
        self.centre_of_mass(wanted, &mut stack);
        self.base(configuration, v, wanted, &mut stack);
        for index in 0..self.robot.patches.len() {
            self.patch(index, wanted, closed, &mut stack);
        }

        // Gauss–Newton of the stack, then posture and forces on the diagonal.
        let (A, b) = stack.finish();
        self.hessian = DMatrix::zeros(n, n);
        self.gradient = DVector::zeros(n);
        self.hessian
            .view_mut((0, 0), (nv, nv))
            .gemm_tr(1.0, &A, &A, 0.0);
        self.gradient.rows_mut(0, nv).gemv_tr(-1.0, &A, &b, 0.0);
        for j in 0..nv {
            let (w, a) = if j < 6 {
                (BASE_WEIGHT, wanted.a[j])
            } else {
                let e = wanted.configuration.joints[j - 6] - configuration.joints[j - 6];
                let a = wanted.a[j] + POSTURE.kp * e + POSTURE.kd * (wanted.v[j] - v[j]);
                (POSTURE.weight, a)
            };
            self.hessian[(j, j)] += w;
            self.gradient[j] -= w * a;
        }
        self.planned_forces(closed);
    }

    /// The centre of mass follows its reference.
    fn centre_of_mass(&self, wanted: &ReferenceState, stack: &mut Stack) {
        let (robot, now, reference) = (self.robot, &self.now, &self.reference);
        now.kinematics.com_jacobian(robot, stack.block());
        let mut J_ref = DMatrix::zeros(3, robot.nv());
        reference.kinematics.com_jacobian(robot, &mut J_ref);
        let a_ref =
            Vector3::from_iterator((J_ref * &wanted.a).iter().copied()) + reference.com_bias_W;
        let a_com = a_ref
            + (reference.kinematics.com_W - now.kinematics.com_W) * COM.kp
            + (reference.com_velocity_W - now.com_velocity_W) * COM.kd;
        stack.close(COM.weight, &(a_com - now.com_bias_W));
    }

    /// The base keeps its orientation.
    fn base(
        &self,
        configuration: &Configuration,
        v: &DVector<f64>,
        wanted: &ReferenceState,
        stack: &mut Stack,
    ) {
        self.now
            .kinematics
            .angular_jacobian(self.robot, 0, stack.block());
        let turn = (wanted.configuration.R_WB * configuration.R_WB.inverse()).scaled_axis();
        let a_base = wanted.a.fixed_rows::<3>(3)
            + turn * BASE.kp
            + (wanted.v.fixed_rows::<3>(3) - v.fixed_rows::<3>(3)) * BASE.kd;
        stack.close(BASE.weight, &a_base);
    }

    /// A closed patch stays; one in the air follows its reference.
    fn patch(
        &mut self,
        index: usize,
        wanted: &ReferenceState,
        closed: &[&ReferenceContact],
        stack: &mut Stack,
    ) {
        let (robot, now, reference) = (self.robot, &self.now, &self.reference);
        let patch = &robot.patches[index];
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
        } else {
            self.held_W[index] = None;
        }
        let is_point = patch.point_radius_m().is_some();
        let p_W = match role {
            // A ball rolls: it is the touching point that stays.
            Role::Closed(contact) if is_point => self.corners[index].points_W(&X_WC, contact)[0],
            _ => X_WC.translation.vector,
        };
        let (velocity, omega) = (
            now.point_velocity(patch.body, &p_W),
            now.omega_W[patch.body],
        );
        let (mut linear, mut angular) = match role {
            Role::Closed(_) => {
                let held_W = *self.held_W[index].get_or_insert(p_W);
                let back = (held_W - p_W) * if is_point { 0.0 } else { CONTACT_KP };
                (back - velocity * CONTACT_DAMPING, omega * -CONTACT_DAMPING)
            }
            Role::Searching(contact) => {
                let down = contact.X_WC.rotation * -Vector3::z() * SEARCH_SPEED_M_S;
                let turn = (contact.X_WC.rotation * X_WC.rotation.inverse()).scaled_axis();
                (
                    (down - velocity) * SWING.kd,
                    turn * SWING.kp - omega * SWING.kd,
                )
            }
            Role::Swinging | Role::Aloft => {
                let X_to = self.offsets[index].applied(&X_ref, PERIOD_S);
                let states = (now, reference);
                follow(&SWING, robot, index, &X_to, states, &wanted.a)
            }
        };
        linear -= now.point_bias(patch.body, &p_W);
        angular -= now.bias_alpha_W[patch.body];
        let weight = match role {
            Role::Closed(_) => CONTACT_WEIGHT,
            Role::Searching(_) | Role::Swinging => SWING.weight,
            Role::Aloft => ALOFT_WEIGHT,
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

    /// Forces come near those of the plan.
    fn planned_forces(&mut self, closed: &[&ReferenceContact]) {
        let least_n = PRESSING * self.robot.mass_kg * GRAVITY_M_S2;
        let mut at = self.robot.nv();
        for contact in closed {
            let patch = &self.robot.patches[contact.patch];
            let X_WC = self.now.kinematics.X_WC(patch);
            let R = contact_axes(&X_WC, contact, patch.point_radius_m().is_some());
            let corners = &self.corners[contact.patch];
            let each_n = contact.normal_n() / corners.count() as f64;
            let w = FORCE_WEIGHT / each_n.max(least_n) * FORCE_UNIT_N * FORCE_UNIT_N;
            for f in corners.spread(contact, &R) {
                for axis in 0..3 {
                    self.hessian[(at, at)] += w;
                    self.gradient[at] -= w * f[axis] / FORCE_UNIT_N;
                    at += 1;
                }
            }
        }
    }
}
