//! Tasks of the whole-body controller: how a patch follows its reference, and the rows of least
//! squares they are written in.

use motion::time_scaling::quintic;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, UnitQuaternion, Vector3};
use robot_model::{JointKind, Robot};

use crate::dynamics::Dynamics;
use crate::reference::ReferenceContact;

/// Time over which a patch in the air comes from where it was to where it was planned to be, s, and the
/// way that it makes meanwhile at least, m: three times what a surface is off, so that it still goes away from one
/// that is nearer than planned.
const FADE_S: f64 = 0.3;
const FADE_M: f64 = 0.03;

/// The part that is kept of what a patch was off where it stood, so long after it left and so far from there.
pub(crate) fn kept(since_s: f64, away_m: f64) -> f64 {
    1.0 - quintic((since_s / FADE_S).min(away_m / FADE_M))
}

/// A second-order task: a* = a_ref + kp·e + kd·ė.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Weight of the squared deviation from a*.
    pub weight: f64,
    /// 1/s².
    pub kp: f64,
    /// 1/s.
    pub kd: f64,
}

/// How far a closed patch is off its reference: the world is not quite what was planned in. A patch
/// that leaves keeps this and loses it on the way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Offset {
    shift_W: Vector3<f64>,
    turn_W: Vector3<f64>,
    /// Where the reference was then.
    from_W: Vector3<f64>,
    since_s: f64,
    /// The part that is left of it.
    pub left: f64,
}

impl Offset {
    /// That of a patch that is closed now.
    pub fn of(X_WC: &Isometry3<f64>, reference: &Isometry3<f64>) -> Self {
        Self {
            shift_W: X_WC.translation.vector - reference.translation.vector,
            turn_W: (X_WC.rotation * reference.rotation.inverse()).scaled_axis(),
            from_W: reference.translation.vector,
            since_s: 0.0,
            left: 1.0,
        }
    }

    /// The reference of a patch that has been in the air for some time, and `dt_s` longer from now.
    pub fn applied(&mut self, reference: &Isometry3<f64>, dt_s: f64) -> Isometry3<f64> {
        let p = reference.translation.vector;
        let left = kept(self.since_s, (p - self.from_W).norm());
        self.since_s += dt_s;
        self.left = left;
        let rotation = UnitQuaternion::from_scaled_axis(self.turn_W * left) * reference.rotation;
        let p = p + self.shift_W * left;
        Isometry3::from_parts(p.into(), rotation)
    }
}

/// Accelerations, linear and angular, with which a patch follows its reference.
///
/// `X_to` is where it is to be: the reference's pose, or that one displaced.
pub(super) fn follow(
    task: &Task,
    robot: &Robot,
    index: usize,
    X_to: &Isometry3<f64>,
    (now, reference): (&Dynamics, &Dynamics),
    a_ref: &DVector<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let patch = &robot.patches[index];
    let X = now.kinematics.X_WC(patch);
    let p = X.translation.vector;
    let p_ref = reference.kinematics.X_WC(patch).translation.vector;
    let (alpha_ref, acceleration_ref) =
        chain_acceleration(robot, patch.body, &p_ref, reference, a_ref);
    let linear = acceleration_ref
        + (X_to.translation.vector - p) * task.kp
        + (reference.point_velocity(patch.body, &p_ref) - now.point_velocity(patch.body, &p))
            * task.kd;
    let turn = (X_to.rotation * X.rotation.inverse()).scaled_axis();
    let angular = alpha_ref
        + turn * task.kp
        + (reference.omega_W[patch.body] - now.omega_W[patch.body]) * task.kd;
    (linear, angular)
}

/// Angular acceleration of a body and acceleration of a point on it: J a + J̇v.
fn chain_acceleration(
    robot: &Robot,
    body: usize,
    p_W: &Vector3<f64>,
    dynamics: &Dynamics,
    a: &DVector<f64>,
) -> (Vector3<f64>, Vector3<f64>) {
    let kinematics = &dynamics.kinematics;
    let base = Vector3::new(a[3], a[4], a[5]);
    let mut alpha = dynamics.bias_alpha_W[body] + base;
    let mut linear = dynamics.point_bias(body, p_W)
        + Vector3::new(a[0], a[1], a[2])
        + base.cross(&(p_W - kinematics.origin_W[0]));
    let mut i = body;
    while let Some(parent) = robot.bodies[i].parent {
        let along = kinematics.axis_W[i] * a[5 + i];
        if robot.bodies[i].kind == JointKind::Prismatic {
            linear += along;
        } else {
            alpha += along;
            linear += along.cross(&(p_W - kinematics.origin_W[i]));
        }
        i = parent;
    }
    (alpha, linear)
}

/// Weighted rows √w (A v̇ − b), written block by block.
pub(super) struct Stack {
    A: DMatrix<f64>,
    b: DVector<f64>,
    block: DMatrix<f64>,
    filled: usize,
}

impl Stack {
    pub fn new(nv: usize, rows: usize) -> Self {
        Self {
            A: DMatrix::zeros(rows, nv),
            b: DVector::zeros(rows),
            block: DMatrix::zeros(3, nv),
            filled: 0,
        }
    }

    /// Room for the next block's Jacobian.
    pub fn block(&mut self) -> &mut DMatrix<f64> {
        &mut self.block
    }

    /// Adds the block with its right-hand side.
    pub fn close(&mut self, weight: f64, right: &Vector3<f64>) {
        let root = weight.sqrt();
        self.A
            .rows_mut(self.filled, 3)
            .copy_from(&(&self.block * root));
        self.b.rows_mut(self.filled, 3).copy_from(&(right * root));
        self.filled += 3;
    }

    pub fn finish(self) -> (DMatrix<f64>, DVector<f64>) {
        let rows = self.filled;
        (
            self.A.resize_vertically(rows, 0.0),
            self.b.resize_vertically(rows, 0.0),
        )
    }
}

/// The axes in which a contact's friction pyramid stands: those of the patch, or of the planned
/// contact where the patch is a ball.
pub(super) fn contact_axes(
    X_WC: &Isometry3<f64>,
    contact: &ReferenceContact,
    is_point: bool,
) -> Matrix3<f64> {
    let axes = |X: &Isometry3<f64>| X.rotation.to_rotation_matrix().into_inner();
    if is_point {
        robot_model::pyramid_axes_W(&axes(&contact.X_WC), &-Vector3::z())
    } else {
        axes(X_WC)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_that_leaves_slowly_is_not_drawn_into_what_it_stood_on() {
        // A surface that is 10 mm nearer than planned, and a reference that goes away at 30 mm/s.
        let at = |z: f64| Isometry3::translation(0.0, 0.0, z);
        let mut offset = Offset::of(&at(0.01), &at(0.0));
        let mut lowest = f64::INFINITY;
        for step in 0..500 {
            let reference = at(0.03 * 0.002 * f64::from(step));
            let z = offset.applied(&reference, 0.002).translation.z;
            lowest = lowest.min(z);
        }
        assert!(lowest > 0.01 - 1e-9, "{lowest}");
        // Once away it is on its way.
        let off = offset.applied(&at(0.05), 0.002).translation.z - 0.05;
        assert!(off.abs() < 1e-9, "{off}");
    }
}
