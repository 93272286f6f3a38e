//! Joint values that bring points of bodies to places while the base stays.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};

use super::Kinematics;
use crate::{Configuration, Robot};

/// Most iterations; a leg in reach takes about ten.
const ITERATIONS: usize = 200;
/// Damping relative to the greatest diagonal entry, so that stretched legs do not jump.
const DAMPING: f64 = 1e-6;
/// Longest change of a joint in one iteration, rad or m.
const STEP_MAX: f64 = 0.2;

/// A point of a body and where it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointTarget {
    /// The body.
    pub body: usize,
    /// The point in the body's frame, m.
    pub p_B: Vector3<f64>,
    /// Where it should be in W, m.
    pub p_W: Vector3<f64>,
}

impl Kinematics {
    /// The step of the joints, least in norm, that moves the point of `body` at `p_W` by `by_W`.
    ///
    ///   δ = Jᵀ (J Jᵀ + λ² 1)⁻¹ by
    ///
    /// Shapes: δ nj.  Units: m, λ m/rad.  Frames: W.  `None` where the matrix is singular.
    pub fn point_step(
        &self,
        robot: &Robot,
        body: usize,
        p_W: &Vector3<f64>,
        by_W: &Vector3<f64>,
        damping: f64,
    ) -> Option<DVector<f64>> {
        let mut J = DMatrix::zeros(3, robot.nv());
        self.point_jacobian(robot, body, p_W, &mut J);
        let J_joints = J.columns(6, robot.nj());
        let mut gram = J_joints * J_joints.transpose();
        for k in 0..3 {
            gram[(k, k)] += damping * damping;
        }
        Some(J_joints.tr_mul(&(gram.try_inverse()? * by_W)))
    }
}

/// The configuration with the base of `start` in which every target is reached to `tolerance_m`
/// within the joints' limits; `None` where descent from `start` does not find one.
///
///   min Σ ‖p_W(q) − target‖²,   lower ≤ q ≤ upper
///
/// Damped Gauss–Newton; a joint at its limit that would go beyond it is left out of the step.
pub fn reach(
    robot: &Robot,
    start: &Configuration,
    targets: &[PointTarget],
    tolerance_m: f64,
) -> Option<Configuration> {
    let nj = robot.nj();
    let mut at = start.clone();
    let mut kinematics = Kinematics::new(robot, &at);
    let mut J = DMatrix::zeros(3, robot.nv());
    for _ in 0..ITERATIONS {
        // 1. Errors, and the normal equations of the step.
        let mut worst: f64 = 0.0;
        let mut H = DMatrix::zeros(nj, nj);
        let mut g = DVector::zeros(nj);
        for target in targets {
            let X_WB: &Isometry3<f64> = kinematics.X_WB.get(target.body)?;
            let p_W = (X_WB * Point3::from(target.p_B)).coords;
            let error = target.p_W - p_W;
            worst = worst.max(error.norm());
            kinematics.point_jacobian(robot, target.body, &p_W, &mut J);
            let J_joints = J.columns(6, nj);
            H += J_joints.transpose() * J_joints;
            g += J_joints.transpose() * error;
        }
        if worst <= tolerance_m {
            return Some(at);
        }
        // 2. Joints at a limit that the errors push against stay there.
        for (j, body) in robot.joint_bodies().iter().enumerate() {
            let q = at.joints[j];
            if (q >= body.upper && g[j] > 0.0) || (q <= body.lower && g[j] < 0.0) {
                g[j] = 0.0;
                H.row_mut(j).fill(0.0);
                H.column_mut(j).fill(0.0);
            }
        }
        // 3. The step, within the limits.
        let damping = DAMPING * H.diagonal().max().max(1e-9);
        for j in 0..nj {
            H[(j, j)] += damping;
        }
        let step = H.cholesky()?.solve(&g);
        let scale = (STEP_MAX / step.amax().max(1e-12)).min(1.0);
        let before = at.joints.clone();
        for (j, body) in robot.joint_bodies().iter().enumerate() {
            at.joints[j] = (at.joints[j] + scale * step[j]).clamp(body.lower, body.upper);
        }
        if (&at.joints - before).amax() < 1e-14 {
            return None;
        }
        kinematics.update(robot, &at);
    }
    None
}
