//! The equations of a projection: where patches and the centre of mass are to be.
//!
//!   r = (p − s − p*, log R R*ᵀ) a patch, (c − c*)_xy
//!
//! with s how far its ball has rolled, where it does.

use nalgebra::{DMatrix, DMatrixViewMut, Isometry3, Vector3};
use posture::Rolling;
use robot_model::{Kinematics, PatchId, PatchKind, Robot};

/// Lever arm that turns an angle into a length, m.
const ANGLE_ARM_M: f64 = 0.1;

/// The equations: where patches and the centre of mass are to be.
pub(crate) struct Target {
    /// Patch and wanted pose, and how its ball rolls from there.
    pub patches: Vec<(PatchId, Isometry3<f64>, Option<Rolling>)>,
    /// How readily the last patch turns from its pose: 0 not at all, 1 as a joint does.
    pub turn_freedom: f64,
    /// Wanted horizontal place of the centre of mass.
    pub com_W: Vector3<f64>,
}

/// Whether a patch is the point of a ball, which may roll.
pub(crate) fn is_point(robot: &Robot, patch: PatchId) -> bool {
    robot.patches[patch].kind != PatchKind::Area
}

/// The pose of a patch; of a ball that rolls the place that it rolls from.
pub(crate) fn place(
    robot: &Robot,
    kinematics: &Kinematics,
    patch: PatchId,
    rolling: Option<&Rolling>,
) -> Isometry3<f64> {
    let patch = &robot.patches[patch];
    let mut X_WC = kinematics.X_WC(patch);
    if let Some(rolling) = rolling {
        X_WC.translation.vector -= rolling.shift_W(&kinematics.X_WB[patch.body].rotation);
    }
    X_WC
}

/// How far two poses of a patch are apart, m: angles times an arm, but for a patch that may turn.
pub(crate) fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>, turns: bool) -> f64 {
    let apart = (a.translation.vector - b.translation.vector).norm();
    if turns {
        return apart;
    }
    apart.max(ANGLE_ARM_M * a.rotation.angle_to(&b.rotation))
}

/// The residuals and their derivatives.
#[derive(Default)]
pub(crate) struct Equations {
    /// Residual.
    pub r: Vec<f64>,
    /// Freedom of each row.
    pub freedom: Vec<f64>,
    /// Rows of J, one after the other.
    pub J: Vec<f64>,
}

impl Equations {
    /// Writes the residuals; the largest of the equations that are not free at the configuration of
    /// `kinematics`, m and rad.
    pub fn update(&mut self, robot: &Robot, target: &Target, kinematics: &Kinematics) -> f64 {
        self.r.clear();
        self.freedom.clear();
        let last = target.patches.len().wrapping_sub(1);
        for (i, (patch, wanted, rolling)) in target.patches.iter().enumerate() {
            let X_WC = place(robot, kinematics, *patch, rolling.as_ref());
            let p = X_WC.translation.vector - wanted.translation.vector;
            self.r.extend(p.iter());
            self.freedom.extend([0.0; 3]);
            if !is_point(robot, *patch) {
                let turn = (X_WC.rotation * wanted.rotation.inverse()).scaled_axis();
                self.r.extend(turn.iter());
                let freedom = if i == last { target.turn_freedom } else { 0.0 };
                self.freedom.extend([freedom; 3]);
            }
        }
        let c = kinematics.com_W - target.com_W;
        self.r.extend([c.x, c.y]);
        self.freedom.extend([0.0; 2]);
        let rows = self.r.iter().zip(&self.freedom);
        let held = rows.filter(|(_, freedom)| **freedom == 0.0);
        held.fold(0.0, |worst, (r, _)| r.abs().max(worst))
    }

    /// Writes the rows of the target: linear and, where the patch may not roll, angular velocity of
    /// every patch, and the horizontal velocity of the centre of mass.
    pub fn linearise(&mut self, robot: &Robot, target: &Target, kinematics: &Kinematics) {
        let (m, n) = (self.r.len(), robot.nv());
        self.J.clear();
        // The vertical row of the centre of mass is written too, and then left out.
        self.J.resize((m + 1) * n, 0.0);
        let mut blocks = self.J.chunks_exact_mut(3 * n);
        let mut next = || {
            let block = blocks.next().unwrap_or_default();
            DMatrixViewMut::from_slice_with_strides_mut(block, 3, n, n, 1)
        };
        let mut turns = DMatrix::zeros(3, 0);
        for (patch, _, rolling) in &target.patches {
            let model = &robot.patches[*patch];
            let p = kinematics.X_WC(model).translation.vector;
            let mut rows = next();
            kinematics.point_jacobian(robot, model.body, &p, &mut rows);
            if let Some(rolling) = rolling {
                turns.resize_mut(3, n, 0.0);
                kinematics.angular_jacobian(robot, model.body, &mut turns);
                let gradient = rolling.gradient(&kinematics.X_WB[model.body].rotation);
                rows.gemm(-1.0, &gradient, &turns, 1.0);
            }
            if !is_point(robot, *patch) {
                kinematics.angular_jacobian(robot, model.body, &mut next());
            }
        }
        kinematics.com_jacobian(robot, &mut next());
        self.J.truncate(m * n);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn the_rows_of_a_ball_that_rolls_are_those_of_differences() {
        let robot = scenes::robot("quadruped").unwrap();
        let foot = robot.patch_id("front_left").unwrap();
        let stood = Kinematics::new(&robot, &robot.posture("standing").unwrap());
        let model = &robot.patches[foot];
        let rolling = Rolling {
            from_WB: stood.X_WB[model.body].rotation,
            normal_W: Vector3::new(0.2, 0.1, 1.0).normalize(),
            radius_m: model.point_radius_m().unwrap(),
        };
        let target = Target {
            patches: vec![(foot, stood.X_WC(model), Some(rolling))],
            turn_freedom: 0.0,
            com_W: stood.com_W,
        };
        let step = |k: usize, h: f64| {
            let mut q = robot.posture("standing").unwrap();
            let mut by = DVector::from_fn(robot.nv(), |i, _| 0.1 * (i as f64).sin());
            q.integrate_in_place(by.as_slice());
            by.fill(0.0);
            by[k] = h;
            q.integrate_in_place(by.as_slice());
            let mut equations = Equations::default();
            let kinematics = Kinematics::new(&robot, &q);
            equations.update(&robot, &target, &kinematics);
            equations.linearise(&robot, &target, &kinematics);
            equations
        };
        let h = 1e-6;
        for k in 0..robot.nv() {
            let (J, [after, before]) = (step(k, 0.0).J, [h, -h].map(|h| step(k, h).r));
            for row in 0..3 {
                let difference = (after[row] - before[row]) / (2.0 * h);
                let off = (difference - J[row * robot.nv() + k]).abs();
                assert!(off < 1e-7, "row {row} by {k}: {off}");
            }
        }
    }
}
