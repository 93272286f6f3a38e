//! Jacobians, all in W with respect to v = [v_B, ω_B, joint rates…].
//!
//! Each fills the whole 3 × nv matrix that it is handed (columns of joints that do not move the
//! body become zero); a view of a greater matrix will do, and nothing is allocated.

use nalgebra::{Dim, Matrix, RawStorageMut, StorageMut, Vector3};

use super::Kinematics;
use crate::{JointKind, Robot};

impl Kinematics {
    /// Velocity of the point of `body` that is at `p_W` now.
    ///
    ///   J = [ 1₃   −[p − p_WB]×   …  a_j × (p − o_j)  or  a_j  … ]
    ///
    /// Shapes: J 3×nv.  Units: m/s per m/s, m per rad.  Frames: W.
    pub fn point_jacobian<R: Dim, C: Dim, S: StorageMut<f64, R, C>>(
        &self,
        robot: &Robot,
        body: usize,
        p_W: &Vector3<f64>,
        J: &mut Matrix<f64, R, C, S>,
    ) {
        check_shape(robot, J);
        J.fill(0.0);
        set_base(J, &(p_W - self.origin_W[0]));
        self.for_each_joint_of(robot, body, |i, kind, axis| {
            let column = match kind {
                JointKind::Prismatic => *axis,
                _ => axis.cross(&(p_W - self.origin_W[i])),
            };
            set_column(J, 5 + i, &column);
        });
    }

    /// Angular velocity of `body`.
    ///
    ///   J = [ 0₃   1₃   …  a_j  or  0  … ]
    ///
    /// Shapes: J 3×nv.  Frames: W.
    pub fn angular_jacobian<R: Dim, C: Dim, S: StorageMut<f64, R, C>>(
        &self,
        robot: &Robot,
        body: usize,
        J: &mut Matrix<f64, R, C, S>,
    ) {
        check_shape(robot, J);
        J.fill(0.0);
        for k in 0..3 {
            J[(k, 3 + k)] = 1.0;
        }
        self.for_each_joint_of(robot, body, |i, kind, axis| {
            if kind == JointKind::Revolute {
                set_column(J, 5 + i, axis);
            }
        });
    }

    /// Velocity of the robot's centre of mass.
    ///
    ///   column j = (m_j / m) · (a_j × (c_j − o_j)  or  a_j),  m_j and c_j what joint j carries
    ///
    /// Shapes: J 3×nv.  Frames: W.
    pub fn com_jacobian<R: Dim, C: Dim, S: StorageMut<f64, R, C>>(
        &self,
        robot: &Robot,
        J: &mut Matrix<f64, R, C, S>,
    ) {
        check_shape(robot, J);
        J.fill(0.0);
        set_base(J, &(self.com_W - self.origin_W[0]));
        for (i, body) in robot.bodies.iter().enumerate().skip(1) {
            let share = self.subtree_mass[i] / self.subtree_mass[0];
            let axis = &self.axis_W[i];
            let column = match body.kind {
                JointKind::Prismatic => axis * share,
                _ => axis.cross(&(self.subtree_com_W[i] - self.origin_W[i])) * share,
            };
            set_column(J, 5 + i, &column);
        }
    }

    /// Adds `scale` · nᵀ J to `row`, J the point Jacobian of `body` at `p_W`.
    ///
    /// The gradient of a signed distance with normal n (from b toward a) is this with +1 at a's
    /// witness point and −1 at b's.
    ///
    /// Shapes: row nv.
    pub fn add_point_row(
        &self,
        robot: &Robot,
        body: usize,
        p_W: &Vector3<f64>,
        n_W: &Vector3<f64>,
        scale: f64,
        row: &mut [f64],
    ) {
        assert_eq!(row.len(), robot.nv(), "one entry a velocity");
        let n = n_W * scale;
        let turn = (p_W - self.origin_W[0]).cross(&n);
        for k in 0..3 {
            row[k] += n[k];
            row[3 + k] += turn[k];
        }
        self.for_each_joint_of(robot, body, |i, kind, axis| {
            row[5 + i] += match kind {
                JointKind::Prismatic => axis.dot(&n),
                _ => axis.dot(&(p_W - self.origin_W[i]).cross(&n)),
            };
        });
    }

    /// Calls `visit(joint's body, its kind, its axis)` for each joint between `body` and the base.
    fn for_each_joint_of(
        &self,
        robot: &Robot,
        body: usize,
        mut visit: impl FnMut(usize, JointKind, &Vector3<f64>),
    ) {
        let mut i = body;
        while let Some(parent) = robot.bodies[i].parent {
            visit(i, robot.bodies[i].kind, &self.axis_W[i]);
            i = parent;
        }
    }
}

/// The base's columns for a point at `r` from B's origin: [1₃, −[r]×].
fn set_base<R: Dim, C: Dim, S: RawStorageMut<f64, R, C>>(
    J: &mut Matrix<f64, R, C, S>,
    r: &Vector3<f64>,
) {
    for k in 0..3 {
        J[(k, k)] = 1.0;
    }
    J[(0, 4)] = r.z;
    J[(0, 5)] = -r.y;
    J[(1, 3)] = -r.z;
    J[(1, 5)] = r.x;
    J[(2, 3)] = r.y;
    J[(2, 4)] = -r.x;
}

fn set_column<R: Dim, C: Dim, S: RawStorageMut<f64, R, C>>(
    J: &mut Matrix<f64, R, C, S>,
    at: usize,
    column: &Vector3<f64>,
) {
    for k in 0..3 {
        J[(k, at)] = column[k];
    }
}

fn check_shape<R: Dim, C: Dim, S: RawStorageMut<f64, R, C>>(
    robot: &Robot,
    J: &Matrix<f64, R, C, S>,
) {
    assert_eq!(J.shape(), (3, robot.nv()), "a Jacobian is 3 × nv");
}
