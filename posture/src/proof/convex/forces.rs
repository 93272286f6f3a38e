//! Forces that balance the weight, within the torques of joints.

use std::ops::AddAssign;

use nalgebra::{Point2, Point3, Vector3};
use robot_model::{JointKind, Kinematics};

use super::super::load;
use super::cones::Form;
use super::{Chain, TORQUE, held};
use crate::outcome::Constraint;

/// Part of the torques' limits that a seed may use with the axes of another configuration.
const SPARING: f64 = 0.95;

impl Chain<'_> {
    /// Where a contact bears, from the middle of all.
    fn bearing(&self, i: usize) -> Vec<Vector3<f64>> {
        let model = &self.ctx.contacts[i];
        let points = model
            .force_points
            .iter()
            .take(self.ctx.layout.force[i].len());
        let at = |v: &Point2<f64>| {
            let v = Point3::new(v.x, v.y, -model.radius.unwrap_or(0.0));
            (self.ctx.problem.contacts[i].X_WC * v).coords - self.middle
        };
        points.map(at).collect()
    }

    /// Forces in their cones that balance the weight, within torques.
    pub(super) fn balance(&mut self, com: &Form, near: Option<&Kinematics>) {
        let n = self.cones.n;
        let (mut force, mut moment) = (self.cones.constant(&-Vector3::z()), Form::zeros(n + 1));
        moment.row_mut(0).copy_from(&-com.row(1));
        moment.row_mut(1).copy_from(&com.row(0));
        let mut first = self.first_force;
        let mut loads = Vec::with_capacity(self.ctx.contacts.len());
        let points: Vec<Vec<Vector3<f64>>> = (0..self.ctx.contacts.len())
            .map(|i| self.bearing(i))
            .collect();
        let least_load = load(self.ctx, points.iter().flatten().map(|p| p.xy()));
        for (model, points) in self.ctx.contacts.iter().zip(points) {
            let (mut own_force, mut own_moment) = (Form::zeros(n + 1), Form::zeros(n + 1));
            for p in points {
                let mut f_W = model.axes * self.cones.friction(first, model.mu);
                f_W[(2, n)] += least_load;
                own_moment += p.cross_matrix() * &f_W;
                own_force += f_W;
                first += 3;
            }
            force += &own_force;
            moment += &own_moment;
            loads.push([own_force, own_moment]);
        }
        self.limit_torques(&loads, near);
        self.cones.violated(&force, Constraint::Equilibrium);
        self.cones.violated(&moment, Constraint::Balance);
    }

    /// Torques of the joints of bodies that contacts put; near a configuration those of all joints that bear a
    /// load, with the axes of there, which may be missed by s.
    fn limit_torques(&mut self, loads: &[[Form; 2]], near: Option<&Kinematics>) {
        let (ctx, n) = (self.ctx, self.cones.n);
        let robot = ctx.robot();
        for (b, body) in robot.bodies.iter().enumerate().skip(1) {
            let limit_m = body.effort * ctx.config.torque_use / ctx.weight;
            let limits = limit_m > 0.0 && limit_m.is_finite() && body.kind == JointKind::Revolute;
            let beyond = ctx.contacts.iter().zip(loads);
            let mut beyond = beyond
                .filter(|(model, _)| robot.supports(b, model.body))
                .peekable();
            if !limits || beyond.peek().is_none() {
                continue;
            }
            // The axis; what weights beyond exert about it, over the robot's, or may exert wherever they are.
            let (axis_W, o, weights_m, unsure_m) = match (near, &self.put[b]) {
                (Some(near), _) => {
                    let (axis_W, o) = (near.axis_W[b], near.origin_W[b]);
                    let lever = (near.subtree_com_W[b] - o).cross(&-Vector3::z());
                    let part = near.subtree_mass[b] / robot.mass_kg;
                    (axis_W, o, part * lever.dot(&axis_W), 0.0)
                }
                (None, Some(X)) => {
                    let (mass, radius_m) = held(ctx, b);
                    let unsure_m = mass / robot.mass_kg * radius_m + TORQUE * limit_m;
                    (X.rotation * body.axis, X.translation.vector, 0.0, unsure_m)
                }
                _ => continue,
            };
            let (part, by_s) = if near.is_some() {
                (SPARING, 1.0)
            } else {
                (1.0, 0.0)
            };
            let arm = (o - self.middle).cross_matrix();
            let mut torque = Form::zeros(n + 1);
            for (_, [f, m]) in beyond {
                let about = m - arm * f;
                torque.row_mut(0).add_assign(axis_W.transpose() * about);
            }
            torque[(0, n)] += weights_m;
            let mut rows = Form::zeros(n + 1);
            for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
                rows.row_mut(k).copy_from(&(torque.row(0) * side));
                rows[(k, n)] += limit_m * part + unsure_m;
                rows[(k, 0)] += by_s;
            }
            self.torques[b] = Some(self.cones.rows());
            self.cones.positive(&rows, &[0, 1]);
        }
    }
}
