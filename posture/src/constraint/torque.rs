//! Every joint holds the posture: |τ_b| ≤ use·τ_max with
//!
//!   τ_b = −a_b·N_b,   N_b = Σ_{i beyond b} (p_i − o_b) × f_i        (revolute; −a_b·Σ f_i prismatic)
//!
//! over the weights of the links and the contact forces beyond the joint: g(q) − Jᵀf row by row.
//! With D_b = Σ (p_i − o_b) f_iᵀ, a rotation ω of everything beyond joint k changes N by
//! D_k ω − tr(D_k) ω, which gives the exact derivative without second-order kinematics. Where a
//! ball touches, p_i is the touched point in N and the ball's centre in D: the one moves as the
//! other does.

use nalgebra::{Matrix3, Vector3};
use robot_model::{GRAVITY_M_S2, JointKind};

use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Joints that carry no contact and use less than this part of their limit get no row: no single step
/// takes them over it.
const WATCHED_USE: f64 = 0.35;

/// Forces beyond every joint, summed.
#[derive(Default)]
pub(crate) struct Torques {
    /// Σ f, N.
    force: Vec<Vector3<f64>>,
    /// Σ p fᵀ, N·m, about W's origin.
    moment: Vec<Matrix3<f64>>,
    /// The same with the points of the bodies that move as the p do.
    carried: Vec<Matrix3<f64>>,
}

impl Torques {
    /// Sums the weights and the contact forces from the leaves to the root.
    pub fn update(&mut self, ctx: &Context, it: &Iterate) {
        let robot = ctx.robot();
        let n = robot.bodies.len();
        self.force.clear();
        self.moment.clear();
        self.carried.clear();
        for (body, pose) in robot.bodies.iter().zip(&it.kinematics.X_WB) {
            let weight = Vector3::new(0.0, 0.0, -body.mass_kg * GRAVITY_M_S2);
            let c = (pose * nalgebra::Point3::from(body.com_B)).coords;
            self.force.push(weight);
            self.moment.push(c * weight.transpose());
            self.carried.push(c * weight.transpose());
        }
        for (contact, columns) in ctx.layout.force.iter().enumerate() {
            let body = ctx.contacts[contact].body;
            for (v, &column) in ctx.contacts[contact].force_points.iter().zip(columns) {
                let f = ctx.weight * ctx.force_W(it, contact, column);
                let p = ctx.patch_point_W(it, contact, v);
                self.force[body] += f;
                let carried = ctx.carried_point_W(it, contact, v);
                self.moment[body] += p * f.transpose();
                self.carried[body] += carried * f.transpose();
            }
        }
        for i in (1..n).rev() {
            if let Some(p) = robot.bodies[i].parent {
                let (force, moment, carried) = (self.force[i], self.moment[i], self.carried[i]);
                self.force[p] += force;
                self.moment[p] += moment;
                self.carried[p] += carried;
            }
        }
    }

    /// Holding torque of the joint of body `b`, N·m (N where prismatic).
    pub fn holding(&self, ctx: &Context, it: &Iterate, b: usize) -> f64 {
        let axis = &it.kinematics.axis_W[b];
        match ctx.robot().bodies[b].kind {
            JointKind::Prismatic => -axis.dot(&self.force[b]),
            _ => -axis.dot(&self.moment_about(it, b)),
        }
    }

    /// N_b = Σ (p − o_b) × f.
    fn moment_about(&self, it: &Iterate, b: usize) -> Vector3<f64> {
        vee(&(self.moment[b] - it.kinematics.origin_W[b] * self.force[b].transpose()))
    }

    /// D_b = Σ (p − o_b) fᵀ, p the points that are carried.
    fn carried_about(&self, it: &Iterate, b: usize) -> Matrix3<f64> {
        self.carried[b] - it.kinematics.origin_W[b] * self.force[b].transpose()
    }

    pub fn rows(&mut self, ctx: &Context, it: &Iterate, rows: &mut Rows) {
        self.update(ctx, it);
        let mut loaded = vec![false; ctx.robot().bodies.len()];
        for (contact, columns) in ctx.layout.force.iter().enumerate() {
            if !columns.is_empty() {
                loaded[ctx.contacts[contact].body] = true;
            }
        }
        for i in (1..loaded.len()).rev() {
            if loaded[i]
                && let Some(p) = ctx.robot().bodies[i].parent
            {
                loaded[p] = true;
            }
        }
        for (b, _) in ctx.layout.joints() {
            let limit = ctx.robot().bodies[b].effort * ctx.config.torque_use;
            if !(limit > 0.0 && limit.is_finite()) {
                continue;
            }
            let value = self.holding(ctx, it, b) / limit;
            if value.abs() < WATCHED_USE && !loaded[b] {
                continue;
            }
            let row = rows.push(Tag::Torque(b), value, -1.0, 1.0);
            if !row.is_empty() {
                self.gradient(ctx, it, b, 1.0 / limit, row);
            }
        }
    }

    /// Adds `scale` times the gradient of the holding torque of joint `b`.
    pub fn gradient(&self, ctx: &Context, it: &Iterate, b: usize, scale: f64, row: &mut [f64]) {
        let robot = ctx.robot();
        let kin = &it.kinematics;
        let axis = &kin.axis_W[b];
        let revolute = robot.bodies[b].kind != JointKind::Prismatic;
        // Rotations ω of everything that carries the joint: −(ω × a)·N − aᵀ(D − tr D) ω.
        let turn = if revolute {
            let n = self.moment_about(it, b);
            let about = self.carried_about(it, b);
            -(axis.cross(&n) + about.transpose() * axis - about.trace() * axis)
        } else {
            -axis.cross(&self.force[b])
        };
        for k in 0..3 {
            row[3 + k] += scale * turn[k];
        }
        let parent = robot.bodies[b].parent;
        let mut k = if revolute { Some(b) } else { parent };
        while let Some(i) = k {
            if let Some(column) = ctx.layout.column[i]
                && robot.bodies[i].kind != JointKind::Prismatic
            {
                row[column] += scale * turn.dot(&kin.axis_W[i]);
            }
            k = robot.bodies[i].parent;
        }
        // Joints beyond it move only what is beyond them.
        if revolute {
            let beyond = |i: usize| i > b && robot.supports(b, i);
            for (i, column) in ctx.layout.joints().filter(|(i, _)| beyond(*i)) {
                let a = &kin.axis_W[i];
                let change = if robot.bodies[i].kind == JointKind::Prismatic {
                    a.cross(&self.force[i])
                } else {
                    let d = self.carried_about(it, i);
                    d * a - d.trace() * a
                };
                row[column] -= scale * axis.dot(&change);
            }
        }
        // Forces.
        for (contact, columns) in ctx.layout.force.iter().enumerate() {
            let body = ctx.contacts[contact].body;
            if !robot.supports(b, body) {
                continue;
            }
            for (v, &column) in ctx.contacts[contact].force_points.iter().zip(columns) {
                let p = ctx.patch_point_W(it, contact, v);
                let turns = axis.cross(&(p - kin.origin_W[b]));
                let lever = if revolute { turns } else { *axis };
                let axes = &ctx.contacts[contact].axes;
                for j in 0..3 {
                    row[column + j] -= scale * ctx.weight * lever.dot(&axes.column(j));
                }
            }
        }
    }
}

/// Σ p × f of Σ p fᵀ.
fn vee(m: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(
        m[(1, 2)] - m[(2, 1)],
        m[(2, 0)] - m[(0, 2)],
        m[(0, 1)] - m[(1, 0)],
    )
}
