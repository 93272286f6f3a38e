//! The geometry of a phase: configurations along the path, solved at knots and joined by a C²
//! spline.
//!
//!   q(u) = q_ref(u) ⊕ δ(u)      δ a cubic spline through the projections of q_ref at the knots
//!
//! Between the knots a Newton step closes the contacts once more.

use nalgebra::Isometry3;
use posture::{Rolling, Upright};
use robot_model::{Configuration, Kinematics, PatchId, Robot};

use crate::blend::{self, Blend};
use crate::equations::{Target, apart, place};
use crate::evening::even_out;
use crate::failure::{Failure, Reason};
use crate::near::{self, Near};
use crate::problem::{Keyframe, MotionContext, Task};
use crate::projection::{Ask, Bounds, Projection};
use crate::spline::{Ends, Order, Spline};
use crate::swing_path::SwingPath;
use crate::time_scaling::quintic;

/// Spline pieces of one phase.
const PIECES: usize = 40;
/// How often its knots are evened out.
const EVENINGS: usize = 3;
/// Inverse square root of the base rotation's weight, where translations and joints have 1.
const TURN_WEIGHT: f64 = 0.3;
/// What a motion lacks of a limit by a hair, rad and m, and by how much more than that is kept to then.
const HAIR_RAD: f64 = 5e-3;
const HAIR_M: f64 = 3e-3;
const MORE: f64 = 1.5;
/// Part of the path over which what is kept beyond the limits grows from 0 and falls back to it: the postures at the
/// ends may be on their bounds. It does so over no less of the way of a patch in the air, m, which moves faster then
/// than its clearance grows: a body beside one that is lifted would turn away for it and back.
const EASE: f64 = 0.05;
const EASE_M: f64 = 0.012;
/// Residual that the projection may leave at a knot, m and rad: samples are closed once more.
const LEFT: f64 = 1e-3;
/// Largest difference between a knot at an end and the posture there, m and rad, below what it is none, and
/// the part of the path over which it is taken out: left there, it is a jump from one phase to the next.
const ARRIVED: f64 = 0.01;
const THERE: f64 = 1e-6;
const ARRIVING: f64 = 0.25;

/// Configurations along a path.
pub(crate) struct Route<'a> {
    blend: Blend<'a>,
    delta: Spline,
    buffer: Vec<f64>,
    keyframes: &'a [Keyframe],
    closed: Vec<(PatchId, Option<Rolling>)>,
    ends: Vec<(Isometry3<f64>, Isometry3<f64>)>,
    target: Target,
    weight: Vec<f64>,
    projection: Projection,
}

/// What a route is computed from.
pub(crate) struct Router<'a> {
    pub context: &'a MotionContext<'a>,
    pub task: &'a Task,
    pub path: Option<&'a SwingPath>,
    /// Whether the body moves out of the way of what it would touch.
    pub evades: bool,
    pub extra: Extra,
}

/// What is kept beyond the limits in the middle of the path, so that the spline keeps to them between the knots
/// too.
#[derive(Clone, Copy)]
pub(crate) struct Extra {
    joints_rad: f64,
    clearance_m: f64,
    tilt_rad: f64,
}

impl Extra {
    /// What usually does.
    pub const USUAL: Self = Self {
        joints_rad: 4e-3,
        clearance_m: 2e-3,
        tilt_rad: 1e-3,
    };

    /// Keeps farther from a limit that was missed by a hair; false where it was missed by more.
    pub fn keep_more(&mut self, failure: &Failure) -> bool {
        let (kept, hair) = match failure.reason {
            Reason::JointLimit { .. } => (&mut self.joints_rad, HAIR_RAD),
            Reason::Tilt => (&mut self.tilt_rad, HAIR_RAD),
            Reason::Clearance { .. } | Reason::SelfClearance { .. } => {
                (&mut self.clearance_m, HAIR_M)
            }
            _ => return false,
        };
        let by_a_hair = failure.amount < hair;
        if by_a_hair {
            *kept += MORE * failure.amount;
        }
        by_a_hair
    }
}

impl<'a> Router<'a> {
    /// The route, or where the body cannot follow.
    pub fn solve(&self) -> Result<Route<'a>, Failure> {
        let context = self.context;
        let robot = context.robot;
        let n = robot.nv();
        let mut blend = Blend::new(&self.task.keyframes);
        let mut projection = Projection::default();
        let mut q = self.task.keyframes[0].q.clone();
        let mut reference = q.clone();
        let mut kinematics = Kinematics::new(robot, &q);
        let weight = self.weights();
        let ends = self.ends(&mut kinematics);
        let mut target = Target {
            patches: Vec::new(),
            turn_freedom: 0.0,
            com_W: self.task.keyframes[0].com_W,
        };
        let mut deltas: Vec<f64> = Vec::with_capacity((PIECES + 1) * n);
        for i in 0..=PIECES {
            let u = i as f64 / PIECES as f64;
            blend.configuration(u, &mut reference);
            q.clone_from(&reference);
            // Start from the solution at the previous knot.
            if let Some(before) = deltas.len().checked_sub(n) {
                q.integrate_in_place(&deltas[before..]);
            }
            self.target(u, &ends, &mut target);
            let joints = joint_bounds(context, inner(self.path, u) * self.extra.joints_rad);
            let near = |kinematics: &Kinematics, out: &mut Vec<Near>| {
                let extra_m = inner(self.path, u) * self.extra.clearance_m;
                near::pairs(context, self.task, kinematics, extra_m, out);
            };
            let bounds = Bounds {
                joints: &joints,
                upright: self.task.upright(u).map(|upright| Upright {
                    tilt_max_rad: upright.tilt_max_rad - inner(self.path, u) * self.extra.tilt_rad,
                    ..upright
                }),
                near: if self.evades { Some(&near) } else { None },
            };
            let ask = Ask {
                robot,
                target: &target,
                bounds: &bounds,
                weight: &weight,
            };
            let left = projection.solve(&ask, &reference, &mut q, &mut kinematics);
            if left.is_nan() || left > LEFT {
                return Err(self.missed(&target, &kinematics, u));
            }
            deltas.extend(reference.difference(&q).iter());
        }
        for (first, last) in [(PIECES, 0), (0, PIECES)] {
            self.arrives(&mut deltas, first, last)?;
        }
        for _ in 0..EVENINGS {
            even_out(&mut deltas, n);
        }
        // The contacts stay closed and the patch on its path, which bends as it does.
        let evened = deltas.chunks_exact_mut(n).enumerate();
        for (i, delta) in evened.skip(2).take(PIECES - 3) {
            let u = i as f64 / PIECES as f64;
            blend.configuration(u, &mut reference);
            q.clone_from(&reference);
            q.integrate_in_place(delta);
            kinematics.update(robot, &q);
            self.target(u, &ends, &mut target);
            let ask = Ask {
                robot,
                target: &target,
                bounds: &Bounds::NONE,
                weight: &weight,
            };
            projection.close(&ask, &mut q, &mut kinematics);
            delta.copy_from_slice(reference.difference(&q).as_slice());
        }
        Ok(Route {
            blend,
            delta: Spline::new(n, 1.0 / PIECES as f64, deltas, Ends::Free),
            buffer: vec![0.0; n],
            keyframes: &self.task.keyframes,
            closed: self.closed().collect(),
            ends,
            target,
            weight,
            projection,
        })
    }

    /// Ends the path, which comes from the knot `first`, at its knot `last` with the posture there. A body
    /// that moved out of the way of something may reach the same contacts in another posture: that is refused.
    fn arrives(&self, deltas: &mut [f64], first: usize, last: usize) -> Result<(), Failure> {
        let context = self.context;
        let n = context.robot.nv();
        let left = deltas[last * n..][..n].to_vec();
        let farthest = left.iter().map(|off| off.abs()).enumerate();
        match farthest.reduce(|a, b| if b.1 > a.1 { b } else { a }) {
            Some((k, off)) if off > ARRIVED => {
                let bodies = context.robot.joint_bodies();
                let joint = match k.checked_sub(6) {
                    Some(j) => bodies[j].joint.clone(),
                    None => "the base".to_owned(),
                };
                let u = last as f64 / PIECES as f64;
                return Err(context.failure(self.task, Reason::Discontinuity { joint }, off, u));
            }
            Some((_, off)) if off > THERE => {}
            _ => return Ok(()),
        }
        for (k, delta) in deltas.chunks_exact_mut(n).enumerate() {
            let near = k.abs_diff(first) as f64 / PIECES as f64;
            let part = quintic(1.0 - (1.0 - near) / ARRIVING);
            for (delta, left) in delta.iter_mut().zip(&left) {
                *delta -= part * left;
            }
        }
        Ok(())
    }

    /// Pose of every closed patch at both ends: the postures close them to their tolerance.
    fn ends(&self, kinematics: &mut Kinematics) -> Vec<(Isometry3<f64>, Isometry3<f64>)> {
        let robot = self.context.robot;
        let mut poses = |q: &Configuration| -> Vec<Isometry3<f64>> {
            kinematics.update(robot, q);
            let pose = |(patch, rolling): (PatchId, Option<Rolling>)| {
                place(robot, kinematics, patch, rolling.as_ref())
            };
            self.closed().map(pose).collect()
        };
        let keyframes = &self.task.keyframes;
        let from = poses(&keyframes[0].q);
        let to = poses(&keyframes[keyframes.len() - 1].q);
        from.into_iter().zip(to).collect()
    }

    /// The closed patches, and how their balls roll.
    fn closed(&self) -> impl Iterator<Item = (PatchId, Option<Rolling>)> {
        let closed = self.task.closed.iter();
        closed.map(|c| (c.patch, c.rolling(self.context.robot)))
    }

    fn target(&self, u: f64, ends: &[(Isometry3<f64>, Isometry3<f64>)], target: &mut Target) {
        closed_target(&self.task.keyframes, self.closed(), ends, u, target);
        if let (Some(swing), Some(path)) = (&self.task.swing, self.path) {
            target.patches.push((swing.patch, path.pose(u), None));
            target.turn_freedom = path.turn_freedom(u);
        }
    }

    /// Inverse square roots of the coordinates' weights; 0 for joints that carry no patch of the phase:
    /// they keep to the reference unless they must evade.
    fn weights(&self) -> Vec<f64> {
        let robot = self.context.robot;
        let mut weight = vec![0.0; robot.nv()];
        weight[..3].fill(1.0);
        weight[3..6].fill(TURN_WEIGHT);
        let closed = self.task.closed.iter().map(|c| c.patch);
        let patches = closed.chain(self.task.swing.iter().map(|s| s.patch));
        let ends: Vec<usize> = patches.map(|p| robot.patches[p].body).collect();
        for b in 1..robot.bodies.len() {
            if self.evades || ends.iter().any(|end| robot.supports(b, *end)) {
                weight[5 + b] = 1.0;
            }
        }
        weight
    }

    fn missed(&self, target: &Target, kinematics: &Kinematics, u: f64) -> Failure {
        let robot = self.context.robot;
        let swing = self.task.swing.as_ref().map(|s| s.patch);
        let mut worst = (None, (kinematics.com_W - target.com_W).xy().norm());
        for (patch, wanted, rolling) in &target.patches {
            let X_WC = place(robot, kinematics, *patch, rolling.as_ref());
            // A patch in the air may turn.
            let free = target.turn_freedom > 0.0 && swing == Some(*patch);
            let apart = apart(&X_WC, wanted, free);
            if apart > worst.1 {
                worst = (Some(self.context.patch_name(*patch)), apart);
            }
        }
        let reason = Reason::Closure { patch: worst.0 };
        self.context.failure(self.task, reason, worst.1, u)
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
        kinematics.update(robot, out);
        let closed = self.closed.iter().copied();
        closed_target(self.keyframes, closed, &self.ends, u, &mut self.target);
        let ask = Ask {
            robot,
            target: &self.target,
            bounds: &Bounds::NONE,
            weight: &self.weight,
        };
        self.projection.close(&ask, out, kinematics);
    }
}

/// How far `u` is from the ends of the path: 0 at them, 1 in the middle.
fn inner(path: Option<&SwingPath>, u: f64) -> f64 {
    let ease = path.map_or(EASE, |path| (EASE_M / path.length_m).clamp(EASE, 0.5));
    quintic(u / ease) * quintic((1.0 - u) / ease)
}

/// What is usually added to the clearances at `u`, m.
pub(crate) fn extra_m(path: &SwingPath, u: f64) -> f64 {
    inner(Some(path), u) * Extra::USUAL.clearance_m
}

/// Where the closed contacts and the centre of mass are at `u`.
fn closed_target(
    keyframes: &[Keyframe],
    closed: impl Iterator<Item = (PatchId, Option<Rolling>)>,
    ends: &[(Isometry3<f64>, Isometry3<f64>)],
    u: f64,
    target: &mut Target,
) {
    target.patches.clear();
    target.turn_freedom = 0.0;
    // Each posture closes its contacts to a tolerance: go from the one's poses to the other's.
    let poses = ends.iter().map(|(from, to)| from.lerp_slerp(to, u));
    let patches = closed.zip(poses);
    let patches = patches.map(|((patch, rolling), pose)| (patch, pose, rolling));
    target.patches.extend(patches);
    target.com_W = blend::com_W(keyframes, u);
}

/// The joints' limits, inside by the postures' margin and `extra` where there is room for it.
pub(crate) fn joint_bounds(context: &MotionContext, extra: f64) -> Vec<(f64, f64)> {
    let bodies = context.robot.joint_bodies().iter();
    bodies
        .map(|body| {
            let margin = body.kept_margin(context.posture.joint_margin_rad + extra);
            (body.lower + margin, body.upper - margin)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Swing;

    #[test]
    #[allow(clippy::unwrap_used)]
    fn a_patch_that_is_lifted_moves_faster_than_its_clearance_grows() {
        let robot = scenes::robot("hrp2").unwrap();
        let path = |length_m: f64| {
            SwingPath::straight(&Swing {
                patch: robot.patch_id("left_hand").unwrap(),
                from: Isometry3::identity(),
                to: Isometry3::translation(0.0, 0.0, length_m),
                leaves: None,
                lands: None,
                rolling: [None; 2],
            })
        };
        for path in [0.048, 0.1, 0.4].map(path) {
            let along = |k: i32| f64::from(k) / 200.0;
            let grows = (0..100).map(|k| extra_m(&path, along(k + 1)) - extra_m(&path, along(k)));
            let fastest = grows.fold(0.0, f64::max);
            let moves = path.length_m / 200.0;
            assert!(fastest < 0.5 * moves, "{fastest} of {moves}");
            assert!(extra_m(&path, 0.5) > 0.9 * Extra::USUAL.clearance_m);
        }
    }
}
