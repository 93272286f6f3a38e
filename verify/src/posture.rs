//! Where the robot's bodies are: forward kinematics of its own, by 4×4 matrices.

use nalgebra::{Matrix3, Matrix4, Vector3};
use robot_model::{GRAVITY_M_S2, JointKind, Robot};

/// A robot at a configuration.
pub(crate) struct Posture<'a> {
    pub robot: &'a Robot,
    /// Pose of every body in W.
    pub X_WB: Vec<Matrix4<f64>>,
    /// Centre of mass of every body in W.
    pub coms_W: Vec<Vector3<f64>>,
    /// Centre of mass of the robot in W.
    pub com_W: Vector3<f64>,
}

/// A force on a body: the body, where it acts and what it is, in W, m and N.
pub(crate) type Load = (usize, Vector3<f64>, Vector3<f64>);

impl<'a> Posture<'a> {
    /// The bodies' poses at `q = [p_WB, quat_xyzw, joints…]`, the quaternion normalised:
    ///
    ///   X_WB(i) = X_WB(parent) · X_PJ · [exp(a q) or I, 0 or a q]
    ///
    /// `None` where q has not one value a joint after the base's seven.
    pub fn new(robot: &'a Robot, q: &[f64]) -> Option<Self> {
        let (base, joints) = q.split_at_checked(7)?;
        if joints.len() + 1 != robot.bodies.len() {
            return None;
        }
        let mut X_WB: Vec<Matrix4<f64>> = Vec::with_capacity(robot.bodies.len());
        let [x, y, z, qx, qy, qz, qw] = *base else {
            return None;
        };
        X_WB.push(pose(&[x, y, z], &[qx, qy, qz, qw]));
        for (body, &value) in robot.bodies.iter().skip(1).zip(joints) {
            let parent = X_WB.get(body.parent?)?;
            let motion = match body.kind {
                JointKind::Prismatic => Matrix4::new_translation(&(body.axis * value)),
                _ => rotation(&body.axis, value),
            };
            X_WB.push(parent * body.X_PJ.to_homogeneous() * motion);
        }
        let placed = X_WB.iter().zip(&robot.bodies);
        let coms_W: Vec<_> = placed.map(|(X, body)| point(X, &body.com_B)).collect();
        let mass: f64 = robot.bodies.iter().map(|body| body.mass_kg).sum();
        let moments = coms_W.iter().zip(&robot.bodies);
        let sum: Vector3<f64> = moments.map(|(c, body)| c * body.mass_kg).sum();
        Some(Self {
            robot,
            X_WB,
            coms_W,
            com_W: sum / mass,
        })
    }

    /// The robot's weight, N.
    pub fn weight(&self) -> f64 {
        let masses = self.robot.bodies.iter().map(|body| body.mass_kg);
        masses.sum::<f64>() * GRAVITY_M_S2
    }

    /// What the joint of `body` must exert to hold everything beyond it, N·m or N:
    ///
    ///   τ = −a·Σ (p − o) × f   (revolute),   τ = −a·Σ f   (prismatic)
    ///
    /// over the weights of the bodies beyond the joint and the loads on them.
    pub fn holding_torque(&self, body: usize, loads: &[Load]) -> f64 {
        let (Some(X), Some(joint)) = (self.X_WB.get(body), self.robot.bodies.get(body)) else {
            return f64::NAN;
        };
        // The joint's axis is fixed in the body that it moves.
        let axis = X.fixed_view::<3, 3>(0, 0) * joint.axis;
        let origin = X.fixed_view::<3, 1>(0, 3).into_owned();
        let mut force = Vector3::zeros();
        let mut moment = Vector3::zeros();
        let mut add = |p: &Vector3<f64>, f: &Vector3<f64>| {
            force += f;
            moment += (p - origin).cross(f);
        };
        for (i, (c, b)) in self.coms_W.iter().zip(&self.robot.bodies).enumerate() {
            if self.carries(body, i) {
                add(c, &Vector3::new(0.0, 0.0, -GRAVITY_M_S2 * b.mass_kg));
            }
        }
        for (on, p, f) in loads {
            if self.carries(body, *on) {
                add(p, f);
            }
        }
        match joint.kind {
            JointKind::Prismatic => -axis.dot(&force),
            _ => -axis.dot(&moment),
        }
    }

    /// Whether `body` is `ancestor` or hangs on it.
    fn carries(&self, ancestor: usize, body: usize) -> bool {
        let mut at = Some(body);
        // A chain is no longer than there are bodies.
        for _ in 0..self.robot.bodies.len() {
            match at {
                Some(i) if i == ancestor => return true,
                Some(i) => at = self.robot.bodies.get(i).and_then(|b| b.parent),
                None => return false,
            }
        }
        false
    }
}

/// A pose from a position and a quaternion of any length but zero.
pub(crate) fn pose(p: &[f64; 3], quat_xyzw: &[f64; 4]) -> Matrix4<f64> {
    let [x, y, z, w] = *quat_xyzw;
    let s = 2.0 / (x * x + y * y + z * z + w * w);
    let R = Matrix3::new(
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    );
    let mut X = R.to_homogeneous();
    X.fixed_view_mut::<3, 1>(0, 3).copy_from(&Vector3::from(*p));
    X
}

/// The point `p` of a frame, in the frame that `X` is given in.
pub(crate) fn point(X: &Matrix4<f64>, p: &Vector3<f64>) -> Vector3<f64> {
    X.fixed_view::<3, 3>(0, 0) * p + X.fixed_view::<3, 1>(0, 3)
}

/// The point of the frame `X` at `p`, given in the frame that `X` is given in.
pub(crate) fn inverse_point(X: &Matrix4<f64>, p: &Vector3<f64>) -> Vector3<f64> {
    X.fixed_view::<3, 3>(0, 0).transpose() * (p - X.fixed_view::<3, 1>(0, 3))
}

/// Column `axis` of the rotation.
pub(crate) fn column(X: &Matrix4<f64>, axis: usize) -> Vector3<f64> {
    X.fixed_view::<3, 1>(0, axis).into_owned()
}

/// The angle of the rotation between two frames, rad.
pub(crate) fn angle_between(a: &Matrix4<f64>, b: &Matrix4<f64>) -> f64 {
    let R = a.fixed_view::<3, 3>(0, 0).transpose() * b.fixed_view::<3, 3>(0, 0);
    let sine = [(2, 1), (0, 2), (1, 0)].map(|(i, j)| R[(i, j)] - R[(j, i)]);
    let sine = Vector3::from(sine);
    (0.5 * sine.norm()).atan2(0.5 * (R.trace() - 1.0))
}

/// Rodrigues' rotation about a unit axis.
fn rotation(axis: &Vector3<f64>, angle: f64) -> Matrix4<f64> {
    let K = axis.cross_matrix();
    let R = Matrix3::identity() + K * angle.sin() + K * K * (1.0 - angle.cos());
    R.to_homogeneous()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;
    use robot_model::{Configuration, Kinematics};

    use super::*;

    /// A robot with legs that branch and feet at their ends.
    fn robot() -> Robot {
        scenes::robot("quadruped").unwrap()
    }

    /// Base anywhere and turned anyhow, joints within their limits.
    fn configurations() -> impl Strategy<Value = Vec<f64>> {
        let robot = robot();
        let bodies = robot.bodies.iter().skip(1);
        let joints: Vec<_> = bodies.map(|body| body.lower..=body.upper).collect();
        let base = prop::array::uniform3(-2.0..2.0);
        let norm = |q: &[f64; 4]| q.iter().map(|x| x * x).sum::<f64>().sqrt();
        let turn = prop::array::uniform4(-1.0..1.0_f64);
        let turn = turn.prop_filter("too short to normalise", move |q| norm(q) > 0.3);
        (base, turn, joints).prop_map(move |(p, turn, joints)| {
            let unit = turn.map(|x| x / norm(&turn));
            [&p[..], &unit, &joints].concat()
        })
    }

    proptest! {
        /// The robot's own kinematics are other code: they must agree to rounding.
        #[test]
        fn poses_and_centre_of_mass_agree_with_the_robots_own(q in configurations()) {
            let robot = robot();
            let mine = Posture::new(&robot, &q).unwrap();
            let theirs = Kinematics::new(&robot, &Configuration::from_q(&q).unwrap());
            for (a, b) in mine.X_WB.iter().zip(&theirs.X_WB) {
                prop_assert!((a - b.to_homogeneous()).norm() < 1e-12);
            }
            prop_assert!((mine.com_W - theirs.com_W).norm() < 1e-12);
        }

        /// Moments summed link by link are g(q) − Jᵀf.
        #[test]
        fn torques_are_gravity_less_the_jacobian_of_the_loads(
            q in configurations(),
            forces in prop::collection::vec((0..2_usize, prop::array::uniform3(-200.0..200.0)), 0..4),
        ) {
            let robot = robot();
            let mine = Posture::new(&robot, &q).unwrap();
            let theirs = Kinematics::new(&robot, &Configuration::from_q(&q).unwrap());
            let mut expected = DVector::zeros(robot.nv());
            theirs.gravity_torques(&robot, &mut expected);
            let mut loads = Vec::new();
            for (patch, force) in forces {
                let patch = &robot.patches[patch];
                let p = theirs.X_WC(patch).translation.vector;
                let f = Vector3::from(force);
                let mut jacobian = DMatrix::zeros(3, robot.nv());
                theirs.point_jacobian(&robot, patch.body, &p, &mut jacobian);
                expected -= jacobian.transpose() * f;
                loads.push((patch.body, p, f));
            }
            for body in 1..robot.bodies.len() {
                let torque = mine.holding_torque(body, &loads);
                prop_assert!((torque - expected[6 + body - 1]).abs() < 1e-9, "body {body}");
            }
        }
    }

    #[test]
    fn a_posture_of_another_robot_is_none() {
        let robot = robot();
        let right = 7 + robot.bodies.len() - 1;
        for length in [0, 6, 7, right - 1, right + 1] {
            let posture = Posture::new(&robot, &vec![0.5; length]);
            assert!(posture.is_none(), "{length}");
        }
    }

    #[test]
    fn the_angle_between_frames_is_that_of_their_rotation() {
        let turn = |angle: f64| rotation(&Vector3::new(0.6, 0.0, 0.8), angle);
        for angle in [0.0, 1e-6, 0.3, 3.0] {
            assert!((angle_between(&turn(0.2), &turn(0.2 + angle)) - angle).abs() < 1e-12);
        }
    }
}
