//! The samples of a phase, and the dense check of every one of them.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use robot_model::Kinematics;

use crate::blend;
use crate::clearance::ClearanceMonitor;
use crate::equations::{apart, is_point, place};
use crate::failure::{Failure, Reason, keep_worst};
use crate::interpolation::Curve;
use crate::problem::{MotionContext, Task};
use crate::route::Route;
use crate::spline::Ends;
use crate::statics::Statics;
use crate::swing_path::SwingPath;

/// How far a joint, or the base's tilt, may be inside its margin, rad. The postures at the ends may be
/// on their bounds, and a C² curve cannot follow a bound and leave it: it strays by less than a tenth of
/// a degree, 5 % of the margin of a joint.
const JOINT_TOLERANCE: f64 = 1.5e-3;
/// How far a joint may be beyond that between two samples, rad: beside [`JOINT_TOLERANCE`] half of
/// what the verifier allows.
const BETWEEN_RAD: f64 = 2.5e-4;
/// How far a closed contact may be from its place, m (angles times 0.1 m): five times what the
/// postures close their contacts to, since patches stray from their places between the knots.
const CLOSURE_M: f64 = 5e-5;

/// How far the patch in the air may be off its path between the knots, m: its clearances are checked
/// where it is, not where it should be.
const SWING_TOLERANCE_M: f64 = 2e-3;

/// One sample of a phase.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub q: Vec<f64>,
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// The samples of a phase, both ends included.
pub(crate) struct SampledTrajectory {
    pub samples: Vec<Instance>,
    /// Centre of mass of every body at every sample, m.
    pub places_W: Vec<Vec<Point3<f64>>>,
    /// How much shorter steps have to be for parts of the robot that pass each other.
    pub coarse: f64,
}

impl SampledTrajectory {
    /// The longest way of a body from one sample to the next, m, and the number of the second.
    pub fn longest_step(&self) -> (f64, usize) {
        let step = |pair: &[Vec<Point3<f64>>]| {
            let moved = pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).norm());
            moved.fold(0.0, f64::max)
        };
        let steps = self.places_W.windows(2).map(step).zip(1..);
        steps.fold((0.0, 1), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// Samples the route and checks every sample.
pub(crate) fn sample(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
    route: &mut Route,
    steps: usize,
) -> Result<SampledTrajectory, Failure> {
    let robot = context.robot;
    let mut q = task.keyframes[0].q.clone();
    let mut kinematics = Kinematics::new(robot, &q);
    let mut clearances = ClearanceMonitor::new(context, task);
    let mut statics = Statics::new(context, task);
    let mut worst = None;
    let mut samples = Vec::with_capacity(steps + 1);
    let mut places_W = Vec::with_capacity(steps + 1);
    let mut last_quaternion = task.keyframes[0].q.R_WB.coords;
    for i in 0..=steps {
        let u = i as f64 / steps as f64;
        route.close(robot, u, &mut q, &mut kinematics);
        // q and −q are one orientation: stay on the side of the one before.
        if q.R_WB.coords.dot(&last_quaternion) < 0.0 {
            q.R_WB = nalgebra::UnitQuaternion::new_unchecked(-q.R_WB.into_inner());
        }
        last_quaternion = q.R_WB.coords;
        let forces_W = blend::forces_W(&task.keyframes, u);
        closure(context, task, path, &kinematics, u, &mut worst);
        joints(context, task, &q.joints, u, &mut worst);
        tilt(context, task, &q.R_WB, u, &mut worst);
        statics.check(&kinematics, &forces_W, u, &mut worst);
        clearances.look(&kinematics, u, &mut worst);
        let bodies = robot.bodies.iter().zip(&kinematics.X_WB);
        let places = bodies.map(|(body, X_WB)| X_WB * Point3::from(body.com_B));
        places_W.push(places.collect());
        samples.push(Instance {
            q: q.to_q(),
            forces_W,
        });
    }
    match worst {
        Some(failure) => Err(failure),
        None => Ok(SampledTrajectory {
            coarse: clearances.coarse.max(coarse(context, &samples)),
            samples,
            places_W,
        }),
    }
}

/// The curve through samples, from 0 to 1.
pub(crate) fn curve<'a>(samples: impl ExactSizeIterator<Item = &'a Instance>) -> Curve {
    let step = 1.0 / (samples.len() - 1) as f64;
    Curve::new(samples.map(|sample| &sample.q[..]), step, Ends::Free)
}

/// How much shorter steps have to be for joints that turn round at their limits: between the samples, which all
/// keep them, the curve through these swings beyond, by about the square of the steps.
pub(crate) fn coarse(context: &MotionContext, samples: &[Instance]) -> f64 {
    /// Where between two samples is looked, in parts of a step.
    const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];
    let joints = (7..).zip(context.robot.joint_bodies());
    let near = joints.filter_map(|(k, body)| {
        let margin = body.kept_margin(context.posture.joint_margin_rad) - JOINT_TOLERANCE;
        let (lower, upper) = (body.lower + margin, body.upper - margin);
        let steps = samples
            .windows(2)
            .map(|pair| (pair[1].q[k] - pair[0].q[k]).abs());
        let longest = steps.fold(0.0, f64::max);
        let is_near = |s: &Instance| (s.q[k] - lower).min(upper - s.q[k]) < longest;
        samples.iter().any(is_near).then_some((k - 7, lower, upper))
    });
    let near: Vec<(usize, f64, f64)> = near.collect();
    if near.is_empty() {
        return 1.0;
    }
    let curve = curve(samples.iter());
    let step = 1.0 / (samples.len() - 1) as f64;
    let places = (0..samples.len() - 1).flat_map(|i| BETWEEN.map(|part| (i as f64 + part) * step));
    let beyond = places.flat_map(|u| {
        let q = curve.at(u).q.joints;
        near.iter()
            .map(move |&(k, lower, upper)| (lower - q[k]).max(q[k] - upper))
    });
    let beyond = beyond.fold(0.0, f64::max);
    (beyond / BETWEEN_RAD).sqrt().max(1.0)
}

/// Closed contacts are closed; the patch in the air is on its path.
fn closure(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
    kinematics: &Kinematics,
    u: f64,
    worst: &mut Option<Failure>,
) {
    let swing = task.swing.as_ref().zip(path);
    let swing = swing.map(|(s, path)| {
        let free = path.turn_freedom(u) > 0.0;
        (s.patch, path.pose(u), None, SWING_TOLERANCE_M, free)
    });
    let closed = task.closed.iter();
    let robot = context.robot;
    let closed = closed.map(|c| (c.patch, c.X_WC, c.rolling(robot), CLOSURE_M, false));
    for (patch, wanted, rolling, tolerance, free) in closed.chain(swing) {
        let X_WC = place(robot, kinematics, patch, rolling.as_ref());
        let apart = apart(&X_WC, &wanted, free || is_point(context.robot, patch));
        if apart.is_nan() || apart > tolerance {
            let patch = Some(context.patch_name(patch));
            let failure = context.failure(task, Reason::Closure { patch }, apart, u);
            keep_worst(worst, failure);
        }
    }
}

pub(crate) fn tilt(
    context: &MotionContext,
    task: &Task,
    R_WB: &UnitQuaternion<f64>,
    u: f64,
    worst: &mut Option<Failure>,
) {
    let over = task.upright(u);
    let over = over.map_or(0.0, |bound| bound.tilt_rad(R_WB) - bound.tilt_max_rad);
    if over > JOINT_TOLERANCE {
        keep_worst(worst, context.failure(task, Reason::Tilt, over, u));
    }
}

pub(crate) fn joints(
    context: &MotionContext,
    task: &Task,
    joints: &nalgebra::DVector<f64>,
    u: f64,
    worst: &mut Option<Failure>,
) {
    for (q, body) in joints.iter().zip(context.robot.joint_bodies()) {
        let margin = body.kept_margin(context.posture.joint_margin_rad) - JOINT_TOLERANCE;
        let over = (body.lower + margin - q).max(q - body.upper + margin);
        if over > 0.0 {
            let joint = body.joint.clone();
            let failure = context.failure(task, Reason::JointLimit { joint }, over, u);
            keep_worst(worst, failure);
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_model::Configuration;

    use super::*;
    use crate::Config;

    /// The last step of a fast leg to its limit: every sample keeps it, and the curve through them went 3.5 mrad beyond.
    #[test]
    #[allow(clippy::unwrap_used)]
    fn curves_that_swing_beyond_a_limit_between_samples_ask_for_more_of_them() {
        let robot = scenes::robot("quadruped").unwrap();
        let environment =
            posture::Environment::new(surfaces::Terrain::default(), 0.03, 2.0).unwrap();
        let (posture, config) = (posture::Config::default(), Config::default());
        let context = MotionContext::new(&robot, &environment, &posture, &config);
        let body = &robot.joint_bodies()[0];
        let bound = body.upper - body.kept_margin(posture.joint_margin_rad);
        let along = |away_rad: &[f64]| -> Vec<Instance> {
            let sample = |away_rad: &f64| {
                let mut q = Configuration::zero(robot.nj());
                for (joint, body) in q.joints.iter_mut().zip(robot.joint_bodies()) {
                    *joint = 0.5 * (body.lower + body.upper);
                }
                q.joints[0] = bound - away_rad;
                Instance {
                    q: q.to_q(),
                    forces_W: Vec::new(),
                }
            };
            away_rad.iter().map(sample).collect()
        };
        let fast = along(&[0.085, 0.063, 0.030, -0.0006, 0.0]);
        assert!(coarse(&context, &fast) > 2.0);
        let slow = along(&[0.085, 0.063, 0.040, 0.017, 0.004, 0.001, 0.0]);
        assert_eq!(coarse(&context, &slow), 1.0);
    }
}
