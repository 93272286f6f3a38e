//! The geometry of a phase: configurations along the way, solved at knots and joined by a C²
//! spline.
//!
//!   q(u) = q_ref(u) ⊕ δ(u)      δ a cubic spline through the projections of q_ref at the knots
//!
//! Between the knots a Newton step closes the contacts once more.
#![allow(non_snake_case)]

use nalgebra::Isometry3;
use robot_model::{Configuration, Kinematics, Robot};

use crate::blend::{self, Blend};
use crate::failure::{Failure, Reason, patch_name};
use crate::near;
use crate::problem::{Key, Setting, Task};
use crate::projection::{ANGLE_ARM_M, Bounds, Near, Projection, Target};
use crate::spline::{Ends, Order, Spline};
use crate::time_scaling::quintic;
use crate::way::Way;

/// How readily the base turns beside its moves and the joints', rad to m and rad.
const TURN_WEIGHT: f64 = 0.3;
/// What is kept beyond the joints' margins and the clearances in the middle of the way, so that the
/// spline between the knots keeps them too: rad, m.
const EXTRA_RAD: f64 = 4e-3;
const EXTRA_M: f64 = 2e-3;
/// Part of the way over which that extra grows and ceases: the postures at the ends may be on their
/// bounds.
const EASE: f64 = 0.1;
/// Residual that the projection may leave at a knot, m and rad: samples are closed once more.
const LEFT: f64 = 1e-3;
/// A body that is nearer to the last posture than this is there, m and rad: within a sample's step.
const ARRIVED: f64 = 0.01;

/// Configurations along a way.
pub(crate) struct Route<'a> {
    blend: Blend<'a>,
    delta: Spline,
    buffer: Vec<f64>,
    keys: &'a [Key],
    closed: Vec<usize>,
    ends: Vec<(Isometry3<f64>, Isometry3<f64>)>,
    target: Target,
    weight: Vec<f64>,
    projection: Projection,
}

/// Everything that a route is solved with.
pub(crate) struct Router<'a> {
    pub setting: &'a Setting<'a>,
    pub task: &'a Task,
    pub way: Option<&'a Way>,
    /// Whether the body moves out of the way of what it would touch.
    pub evades: bool,
}

impl<'a> Router<'a> {
    /// The route, or where the body cannot follow.
    pub fn solve(&self) -> Result<Route<'a>, Failure> {
        let setting = self.setting;
        let robot = setting.robot;
        let n = robot.nv();
        let mut blend = Blend::new(&self.task.keys);
        let mut projection = Projection::default();
        let mut q = self.task.keys[0].q.clone();
        let mut reference = q.clone();
        let mut kinematics = Kinematics::new(robot, &q);
        let weight = self.weights();
        let ends = self.ends(&mut kinematics);
        let mut target = Target {
            patches: Vec::new(),
            turn_freedom: 0.0,
            com_W: self.task.keys[0].com_W,
        };
        let pieces = setting.config.pieces;
        let mut deltas: Vec<f64> = Vec::with_capacity((pieces + 1) * n);
        for i in 0..=pieces {
            let u = i as f64 / pieces as f64;
            blend.configuration(u, &mut reference);
            q.clone_from(&reference);
            // From the solution at the knot before.
            if let Some(before) = deltas.len().checked_sub(n) {
                q.integrate_in_place(&deltas[before..]);
            }
            self.target(u, &ends, &mut target);
            let extra = quintic(u / EASE) * quintic((1.0 - u) / EASE);
            let joints = joint_bounds(setting, extra * EXTRA_RAD);
            let near = |kinematics: &Kinematics, out: &mut Vec<Near>| {
                near::pairs(setting, self.task, kinematics, extra * EXTRA_M, out);
            };
            let bounds = Bounds {
                joints: &joints,
                near: if self.evades { Some(&near) } else { None },
            };
            let left = projection.solve(
                robot,
                &target,
                &bounds,
                &weight,
                &reference,
                &mut q,
                &mut kinematics,
            );
            if left.is_nan() || left > LEFT {
                return Err(self.missed(&target, &kinematics, u));
            }
            deltas.extend(reference.difference(&q).iter());
        }
        self.arrives(&deltas[pieces * n..])?;
        Ok(Route {
            blend,
            delta: Spline::new(n, 1.0 / pieces as f64, deltas, Ends::Free),
            buffer: vec![0.0; n],
            keys: &self.task.keys,
            closed: self.task.closed.iter().map(|c| c.patch).collect(),
            ends,
            target,
            weight,
            projection,
        })
    }

    /// Whether the last knot, so far off its reference, is the posture that the phase ends with: what
    /// evades something may come to the same contacts in another one.
    fn arrives(&self, delta: &[f64]) -> Result<(), Failure> {
        let setting = self.setting;
        let farthest = delta.iter().map(|off| off.abs()).enumerate();
        match farthest.reduce(|a, b| if b.1 > a.1 { b } else { a }) {
            Some((k, off)) if off > ARRIVED => {
                let bodies = setting.robot.joint_bodies();
                let joint = match k.checked_sub(6) {
                    Some(j) => bodies[j].joint.clone(),
                    None => "the base".to_owned(),
                };
                Err(setting.failure(self.task, Reason::Leap { joint }, off, 1.0))
            }
            _ => Ok(()),
        }
    }

    /// Pose of every closed patch at both ends: the postures close them to their tolerance.
    fn ends(&self, kinematics: &mut Kinematics) -> Vec<(Isometry3<f64>, Isometry3<f64>)> {
        let robot = self.setting.robot;
        let mut poses = |q: &Configuration| -> Vec<Isometry3<f64>> {
            kinematics.update(robot, q);
            self.task
                .closed
                .iter()
                .map(|c| kinematics.X_WC(&robot.patches[c.patch]))
                .collect()
        };
        let keys = &self.task.keys;
        let from = poses(&keys[0].q);
        let to = poses(&keys[keys.len() - 1].q);
        from.into_iter().zip(to).collect()
    }

    fn target(&self, u: f64, ends: &[(Isometry3<f64>, Isometry3<f64>)], target: &mut Target) {
        let closed = self.task.closed.iter().map(|c| c.patch);
        closed_target(&self.task.keys, closed, ends, u, target);
        if let (Some(swing), Some(way)) = (&self.task.swing, self.way) {
            target.patches.push((swing.patch, way.pose(u)));
            target.turn_freedom = way.turn_freedom(u);
        }
    }

    /// How readily each coordinate moves; joints that carry no patch of the phase keep to the
    /// reference.
    fn weights(&self) -> Vec<f64> {
        let robot = self.setting.robot;
        let mut weight = vec![0.0; robot.nv()];
        weight[..3].fill(1.0);
        weight[3..6].fill(TURN_WEIGHT);
        let patches = self.task.closed.iter().map(|c| c.patch);
        let patches: Vec<usize> = patches
            .chain(self.task.swing.iter().map(|s| s.patch))
            .collect();
        for b in 1..robot.bodies.len() {
            let carries = patches
                .iter()
                .any(|p| robot.supports(b, robot.patches[*p].body));
            if carries {
                weight[5 + b] = 1.0;
            }
        }
        weight
    }

    fn missed(&self, target: &Target, kinematics: &Kinematics, u: f64) -> Failure {
        let robot = self.setting.robot;
        let mut worst = (None, (kinematics.com_W - target.com_W).xy().norm());
        for (patch, wanted) in &target.patches {
            let X_WC = kinematics.X_WC(&robot.patches[*patch]);
            let apart = (X_WC.translation.vector - wanted.translation.vector).norm();
            // A patch in the air may turn.
            let free = target.turn_freedom > 0.0
                && self.task.swing.as_ref().is_some_and(|s| s.patch == *patch);
            if free {
                if apart > worst.1 {
                    worst = (Some(patch_name(self.setting, *patch)), apart);
                }
                continue;
            }
            let turned = ANGLE_ARM_M * X_WC.rotation.angle_to(&wanted.rotation);
            if apart.max(turned) > worst.1 {
                worst = (Some(patch_name(self.setting, *patch)), apart.max(turned));
            }
        }
        Failure {
            reason: Reason::Closure { patch: worst.0 },
            amount: worst.1,
            at: u,
            swing: self
                .task
                .swing
                .as_ref()
                .map(|s| patch_name(self.setting, s.patch)),
        }
    }
}

impl Route<'_> {
    /// Writes the configuration of the spline at `u`.
    pub fn configuration(&mut self, u: f64, out: &mut Configuration) {
        self.blend.configuration(u, out);
        self.delta.evaluate(u, Order::Value, &mut self.buffer);
        out.integrate_in_place(&self.buffer);
    }

    /// Writes the configuration at `u` with its contacts closed and its centre of mass in place to
    /// rounding, and its kinematics.
    pub fn close(
        &mut self,
        robot: &Robot,
        u: f64,
        out: &mut Configuration,
        kinematics: &mut Kinematics,
    ) {
        self.configuration(u, out);
        let closed = self.closed.iter().copied();
        closed_target(self.keys, closed, &self.ends, u, &mut self.target);
        self.projection
            .close(robot, &self.target, &self.weight, out, kinematics);
    }
}

/// Where the closed contacts and the centre of mass are at `u`.
fn closed_target(
    keys: &[Key],
    closed: impl Iterator<Item = usize>,
    ends: &[(Isometry3<f64>, Isometry3<f64>)],
    u: f64,
    target: &mut Target,
) {
    target.patches.clear();
    target.turn_freedom = 0.0;
    // From the one posture's tolerance to the other's.
    let poses = ends.iter().map(|(from, to)| from.lerp_slerp(to, u));
    target.patches.extend(closed.zip(poses));
    target.com_W = blend::com_W(keys, u);
}

/// The joints' limits, inside by the postures' margin and `extra` where there is room for it.
pub(crate) fn joint_bounds(setting: &Setting, extra: f64) -> Vec<(f64, f64)> {
    let bodies = setting.robot.joint_bodies().iter();
    bodies
        .map(|body| {
            let room = 0.25 * (body.upper - body.lower).max(0.0);
            let margin = (setting.posture.joint_margin_rad + extra).min(room);
            (body.lower + margin, body.upper - margin)
        })
        .collect()
}
