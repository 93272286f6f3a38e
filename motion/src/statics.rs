//! Statics of one sample: balance, friction and holding torques.
//!
//!   Σ f + m g = 0,   Σ p × f = −c × m g,   τ_b = a_b·((c_b − o_b) × m_b g ẑ − Σ_{beyond b} (p − o_b) × f)

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use posture::force_points;
use robot_model::{GRAVITY_M_S2, JointKind, Kinematics};

use crate::failure::{Failure, Reason, keep_worst};
use crate::problem::{MotionContext, Task};

/// Largest unbalanced part of the weight (moments over 1 m): what the postures are solved to, with
/// a digit to spare.
const BALANCE: f64 = 1e-4;
/// The same where balls roll: their points go other ways than in proportion between the postures', and what the moments are
/// off by is shared among the contacts with what accelerates the robot.
const BALANCE_ROLLING: f64 = 5e-3;
/// Part of the weight by which a force may leave its cone: what the postures are solved to, and
/// rounding.
const SLIP: f64 = 1.5e-5;

/// The force points of the closed contacts, and sums over them.
pub(crate) struct Statics<'a> {
    context: &'a MotionContext<'a>,
    task: &'a Task,
    points_C: Vec<Vec<Point2<f64>>>,
    /// Part of the torques that holding may take: half of what a motion has beyond a posture is for moving.
    torque_use: f64,
    /// Force and moment about W's origin of each closed contact.
    wrench: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl<'a> Statics<'a> {
    pub fn new(context: &'a MotionContext<'a>, task: &'a Task) -> Self {
        let polygons = task.closed.iter();
        let polygons = polygons.map(|closed| &context.robot.patches[closed.patch].polygon);
        let points = polygons.map(|p| force_points(p, context.posture.com_margin_m));
        let at_rest = context.posture.torque_use;
        Self {
            context,
            task,
            points_C: points.collect(),
            torque_use: 0.5 * (at_rest + context.config.torque_use.max(at_rest)),
            wrench: Vec::new(),
        }
    }

    /// Checks the forces of a sample.
    pub fn check(
        &mut self,
        kinematics: &Kinematics,
        forces_W: &[Vec<Vector3<f64>>],
        at: f64,
        worst: &mut Option<Failure>,
    ) {
        let robot = self.context.robot;
        let weight = robot.mass_kg * GRAVITY_M_S2;
        self.sum(kinematics, forces_W);
        let mut report = |reason, amount| {
            keep_worst(worst, self.context.failure(self.task, reason, amount, at));
        };

        // Balance.
        let up = Vector3::z() * weight;
        let (force, moment): (Vec<_>, Vec<_>) = self.wrench.iter().copied().unzip();
        let force = force.iter().sum::<Vector3<f64>>() - up;
        let moment = moment.iter().sum::<Vector3<f64>>() - kinematics.com_W.cross(&up);
        let unbalanced = force.amax().max(moment.amax()) / weight;
        let rolls = self.task.closed.iter().any(|c| c.rolling(robot).is_some());
        let most = if rolls { BALANCE_ROLLING } else { BALANCE };
        if unbalanced.is_nan() || unbalanced > most {
            report(Reason::Equilibrium, unbalanced);
        }

        // Friction, in the cone of which the postures use the inscribed pyramid.
        for (closed, forces) in self.task.closed.iter().zip(forces_W) {
            let use_max = closed.friction * self.context.posture.friction_use;
            let n = closed.normal_W();
            for f in forces {
                let normal = f.dot(&n);
                let over = (f - n * normal).norm() - use_max * normal;
                if over > SLIP * weight {
                    let name = self.context.patch_name(closed.patch);
                    report(Reason::Friction { patch: name }, over / weight);
                }
            }
        }

        // Torques.
        for (b, body) in robot.bodies.iter().enumerate().skip(1) {
            let limit = body.effort * self.torque_use;
            if !(limit > 0.0 && limit.is_finite()) {
                continue;
            }
            let (axis, o) = (&kinematics.axis_W[b], &kinematics.origin_W[b]);
            let mut f = Vector3::z() * (kinematics.subtree_mass[b] * GRAVITY_M_S2);
            let mut m = (kinematics.subtree_com_W[b] - o).cross(&f);
            for (closed, (force, moment)) in self.task.closed.iter().zip(&self.wrench) {
                if robot.supports(b, robot.patches[closed.patch].body) {
                    f -= force;
                    m -= moment - o.cross(force);
                }
            }
            let torque = match body.kind {
                JointKind::Prismatic => axis.dot(&f),
                _ => axis.dot(&m),
            };
            let over = torque.abs() / limit - 1.0;
            if over > BALANCE {
                let joint = body.joint.clone();
                report(Reason::Torque { joint }, over);
            }
        }
    }

    fn sum(&mut self, kinematics: &Kinematics, forces_W: &[Vec<Vector3<f64>>]) {
        self.wrench.clear();
        let points = self.points_C.iter().zip(forces_W);
        for (closed, (points, forces)) in self.task.closed.iter().zip(points) {
            let patch = &self.context.robot.patches[closed.patch];
            let X_WC: Isometry3<f64> = kinematics.X_WC(patch);
            let mut sum = (Vector3::zeros(), Vector3::zeros());
            // A ball touches below its centre, however it is turned.
            let below = -patch.point_radius_m().unwrap_or(0.0) * closed.normal_W();
            for (p, f) in points.iter().zip(forces) {
                let p_W = (X_WC * Point3::new(p.x, p.y, 0.0)).coords + below;
                sum.0 += f;
                sum.1 += p_W.cross(f);
            }
            self.wrench.push(sum);
        }
    }
}
