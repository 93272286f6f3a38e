//! Points of the contacts at an iterate, and the gradients of points, rotations and the centre of
//! mass by the variables of a step.

use nalgebra::{Isometry3, Point2, Vector3};
use robot_model::JointKind::Prismatic;

use crate::iterate::{Context, Iterate};

impl Context<'_> {
    /// Force in W, over the weight, at the point whose first column is `column`.
    pub fn force_W(&self, it: &Iterate, contact: usize, column: usize) -> Vector3<f64> {
        let k = column - self.layout.nq;
        self.contacts[contact].axes * Vector3::new(it.force[k], it.force[k + 1], it.force[k + 2])
    }

    /// Where a contact is wanted, in W: its fixed place, or the wanted one on its surface, or where
    /// it is.
    pub fn wanted_W(&self, it: &Iterate, contact: usize) -> Vector3<f64> {
        let asked = &self.problem.contacts[contact];
        match asked.area() {
            None => self.robot().patches[asked.patch].touched_W(&asked.X_WC),
            Some(area) => area.toward.map_or_else(
                || self.patch_point_W(it, contact, &Point2::origin()),
                |toward| toward.coords,
            ),
        }
    }

    /// A point of a contact's patch, in W; of a ball the point that touches, `centre − radius·z`
    /// with z the touched surface's normal.
    pub fn patch_point_W(&self, it: &Iterate, contact: usize, p: &Point2<f64>) -> Vector3<f64> {
        let carried = self.carried_point_W(it, contact, p);
        let model = &self.contacts[contact];
        match model.radius {
            Some(radius) => carried - radius * model.axes.column(2),
            None => carried,
        }
    }

    /// The point of the contact's body that moves as [`Context::patch_point_W`] does, in W: the
    /// point itself, but the centre of a ball, over which the touched point slides as it turns.
    pub fn carried_point_W(&self, it: &Iterate, contact: usize, p: &Point2<f64>) -> Vector3<f64> {
        let X_BC = &self.robot().patches[self.problem.contacts[contact].patch].X_BC;
        let X_WB = &it.kinematics.X_WB[self.contacts[contact].body];
        (X_WB * (X_BC * nalgebra::Point3::new(p.x, p.y, 0.0))).coords
    }

    /// Pose of a contact's patch, in W.
    pub fn X_WC(&self, it: &Iterate, contact: usize) -> Isometry3<f64> {
        let patch = &self.robot().patches[self.problem.contacts[contact].patch];
        it.kinematics.X_WB[patch.body] * patch.X_BC
    }

    /// Adds `scale` times the gradient of `direction · p` to a row, p being the point `p_W` of a
    /// body.
    pub fn add_point_gradient(
        &self,
        it: &Iterate,
        body: usize,
        p_W: &Vector3<f64>,
        direction: &Vector3<f64>,
        row: &mut [f64],
    ) {
        let about_base = (p_W - it.q.p_WB).cross(direction);
        for k in 0..3 {
            row[k] += direction[k];
            row[3 + k] += about_base[k];
        }
        let mut b = body;
        while let Some(parent) = self.robot().bodies[b].parent {
            if let Some(column) = self.layout.column[b] {
                let axis = &it.kinematics.axis_W[b];
                let lever = p_W - it.kinematics.origin_W[b];
                row[column] += match self.robot().bodies[b].kind {
                    Prismatic => axis.dot(direction),
                    _ => axis.cross(&lever).dot(direction),
                };
            }
            b = parent;
        }
    }

    /// Adds the gradient of `direction · φ` to a row, φ being the rotation (in W) of a body.
    pub fn add_rotation_gradient(
        &self,
        it: &Iterate,
        body: usize,
        direction: &Vector3<f64>,
        row: &mut [f64],
    ) {
        for k in 0..3 {
            row[3 + k] += direction[k];
        }
        let mut b = body;
        while let Some(parent) = self.robot().bodies[b].parent {
            if let Some(column) = self.layout.column[b]
                && self.robot().bodies[b].kind != Prismatic
            {
                row[column] += it.kinematics.axis_W[b].dot(direction);
            }
            b = parent;
        }
    }

    /// Adds the gradient of `direction · c` to a row, c being the centre of mass.
    pub fn add_com_gradient(&self, it: &Iterate, direction: &Vector3<f64>, row: &mut [f64]) {
        let kin = &it.kinematics;
        let about_base = (kin.com_W - it.q.p_WB).cross(direction);
        for k in 0..3 {
            row[k] += direction[k];
            row[3 + k] += about_base[k];
        }
        for (b, column) in self.layout.joints() {
            let share = kin.subtree_mass[b] / self.robot().mass_kg;
            let (axis, lever) = (&kin.axis_W[b], kin.subtree_com_W[b] - kin.origin_W[b]);
            let moved = match self.robot().bodies[b].kind {
                Prismatic => axis.dot(direction),
                _ => axis.cross(&lever).dot(direction),
            };
            row[column] += share * moved;
        }
    }
}
