//! Left and right of a robot: which body is the other side's, and how its joint turns.

use nalgebra::Vector3;

use crate::{Configuration, Kinematics, Robot};

/// Bodies that lie mirrored up to this part of the robot's size are each other's.
const PART: f64 = 0.05;

/// For every joint the one on the other side and the sign that its value takes there.
#[derive(Clone, Debug)]
pub struct Mirror {
    joint: Vec<Option<(usize, f64)>>,
}

impl Mirror {
    /// The mirror of a robot about the plane y = 0 of its base, as it is with all joints at neutral.
    ///
    /// A rotation about a is, mirrored by M = diag(1, −1, 1), one about M a by the opposite angle; a
    /// slide along a is one along M a.
    pub fn new(robot: &Robot) -> Self {
        let kinematics = Kinematics::new(robot, &robot.neutral());
        let M = |v: &Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
        let origins = &kinematics.origin_W;
        let size = origins.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let depth: Vec<usize> = (0..robot.bodies.len())
            .map(|b| std::iter::successors(Some(b), |&b| robot.bodies[b].parent).count())
            .collect();
        let joint = (1..robot.bodies.len()).map(|i| {
            let (p, a) = (M(&origins[i]), M(&kinematics.axis_W[i]));
            let off = |k: &usize| {
                let (q, b) = (&origins[*k], &kinematics.axis_W[*k]);
                (q - p).norm() / size.max(1e-9) + 1.0 - a.dot(b).abs()
            };
            let like =
                |k: &usize| depth[*k] == depth[i] && robot.bodies[*k].kind == robot.bodies[i].kind;
            let all = (1..robot.bodies.len()).filter(like);
            let best = all.min_by(|a, b| off(a).total_cmp(&off(b)))?;
            let along = a.dot(&kinematics.axis_W[best]).signum();
            let turns = robot.bodies[i].kind != crate::JointKind::Prismatic;
            let sign = if turns { -along } else { along };
            (off(&best) < PART).then_some((best - 1, sign))
        });
        Self {
            joint: joint.collect(),
        }
    }

    /// The body on the other side, itself for one in the middle.
    pub fn of_body(&self, body: usize) -> Option<usize> {
        Some(self.joint.get(body.checked_sub(1)?)?.as_ref()?.0 + 1)
    }

    /// Gives the other side of each of these joints the mirrored value, within its limits.
    pub fn copy(
        &self,
        robot: &Robot,
        configuration: &mut Configuration,
        joints: impl Iterator<Item = usize>,
    ) {
        for j in joints {
            if let Some((other, sign)) = self.joint[j] {
                let body = &robot.joint_bodies()[other];
                let value = sign * configuration.joints[j];
                configuration.joints[other] = value.clamp(body.lower, body.upper);
            }
        }
    }

    /// The mean of a configuration and its mirror image, joints alone.
    pub fn evened(&self, robot: &Robot, configuration: &Configuration) -> Configuration {
        let mut even = configuration.clone();
        for (j, (value, body)) in even.joints.iter_mut().zip(robot.joint_bodies()).enumerate() {
            if let Some((other, sign)) = self.joint[j] {
                let mean = 0.5 * (configuration.joints[j] + sign * configuration.joints[other]);
                *value = mean.clamp(body.lower, body.upper);
            }
        }
        even
    }
}
