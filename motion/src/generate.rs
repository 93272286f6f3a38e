//! The motion of one phase: try paths that are free for the swinging link, compute the whole body
//! along them, and add waypoints where it cannot follow.

use posture::{Constraint, Contact, Outcome, Problem};

use crate::Error;
use crate::airborne::Airborne;
use crate::clearance::TOLERANCE_M;
use crate::failure::{Failure, Reason};
use crate::problem::{Keyframe, MotionContext, Swing, Task};
use crate::route::{Extra, Router, extra_m};
use crate::sampling::{SampledTrajectory, sample};
use crate::sweep::{self, Hit, Shortfall};
use crate::swing_path::{self, SwingPath};

/// Paths through the air on which the whole body is tried for one swing.
const PATHS_MAX: usize = 4;
/// How often a path is bent away from what it comes too near to, by how much at most each time, and by how
/// much more than it is short, m.
const BENDS_MAX: usize = 6;
const BEND_MAX_M: f64 = 0.03;
const BEND_FURTHER_M: f64 = 2e-4;
/// Postures solved on one path where its checks fail.
const WAYPOINTS_MAX: usize = 2;
/// How often one path is tried farther from a limit that it missed by a hair.
const HAIRS_MAX: usize = 2;
/// Smallest distance of a waypoint from another keyframe, part of the path: nearer ones would be
/// passed with a jerk.
const APART_MIN: f64 = 0.12;

/// Give up after this many paths that failed for what all paths share: no posture in the first or last
/// part, closed contacts out of reach, or something that the limb in the air has no part in.
const STUCK_MAX: usize = 2;
/// Length of that part, as a part of the path.
const STRAIGHT: f64 = 0.15;

/// Steps in which a motion is looked at before it is sampled finely.
const LOOKS: usize = 24;
/// Steps in which it is sampled, or a multiple: the pieces of its spline are one or two of them.
const STEPS: usize = 80;
/// How many times as many there are at once where the first look asks for them, at most.
const FINER_MAX: usize = 3;
/// Part of the clearance that a body may move between two samples: past an edge it is then nearer between
/// them by 2 % at most.
pub(crate) const STEP_PART: f64 = 0.4;
/// A motion whose steps stay longer than this part of what they were when it is given more jumps.
const SHORTER: f64 = 0.8;

/// The samples of a task, or the worst violation on the path that came nearest.
///
/// # Errors
/// [`Error::Posture`] where a waypoint cannot be posed.
pub(crate) fn solve(
    context: &MotionContext,
    task: &Task,
) -> Result<Result<SampledTrajectory, Failure>, Error> {
    let Some(swing) = &task.swing else {
        return Ok(follow(context, task, None)?.map_err(|(failure, _)| failure));
    };
    if swing.lands.is_none() {
        let path = SwingPath::straight(swing);
        return Ok(follow(context, task, Some(&path))?.map_err(|(failure, _)| failure));
    }
    let mut nearest: Option<Failure> = None;
    let (mut tried, mut stuck) = (0, 0);
    for shape in swing_path::shapes(context.config) {
        if tried == PATHS_MAX || stuck == STUCK_MAX {
            break;
        }
        let mut path = SwingPath::new(context.environment, swing, shape);
        if let Some(short) = bend(context, task, &mut path) {
            let link = context.robot.patches[swing.patch].link.clone();
            let reason = match short.hit {
                Hit::Environment(obstacle) => Reason::Clearance {
                    link,
                    body: context.environment.body_name(obstacle).to_owned(),
                },
                Hit::Robot(other) => Reason::SelfClearance { link, other },
            };
            let failure = context.failure(task, reason, short.short_m, short.at);
            keep_least(&mut nearest, failure);
            continue;
        }
        tried += 1;
        match follow(context, task, Some(&path))? {
            Ok(trajectory) => return Ok(Ok(trajectory)),
            Err((failure, held)) => {
                tracing::debug!("{shape:?}: {}", failure.describe());
                stuck += usize::from(!held || is_shared(context, swing, &failure));
                keep_least(&mut nearest, failure);
            }
        }
    }
    let none = context.failure(task, Reason::Equilibrium, 0.0, 0.0);
    Ok(Err(nearest.unwrap_or(none)))
}

/// Bends a path away from what the link comes too near to; what is left of that beyond what the samples of
/// the whole body may lack.
fn bend(context: &MotionContext, task: &Task, path: &mut SwingPath) -> Option<Shortfall> {
    let mut bends = 0;
    loop {
        let short = sweep::shortfall(context, task, path)?;
        let offset = short.away_W * (short.short_m + BEND_FURTHER_M);
        if bends == BENDS_MAX || short.short_m > BEND_MAX_M || !path.bend(short.at, &offset) {
            return Some(short).filter(|s| s.short_m > TOLERANCE_M + extra_m(path, s.at));
        }
        bends += 1;
    }
}

/// Whether another path of the patch would fail in the same way.
fn is_shared(context: &MotionContext, swing: &Swing, failure: &Failure) -> bool {
    let robot = context.robot;
    // Of the swinging limb is what carries no other patch.
    let of_limb = |link: &String| {
        let body = robot.bodies.iter().position(|body| body.name == *link);
        body.is_some_and(|body| {
            let own = robot.patches[swing.patch].body;
            let mut patches = robot.patches.iter();
            robot.supports(body, own)
                && patches.all(|p| p.body == own || !robot.supports(body, p.body))
        })
    };
    match &failure.reason {
        Reason::Closure { .. } => failure.at < STRAIGHT || failure.at > 1.0 - STRAIGHT,
        Reason::Clearance { link, .. } => !of_limb(link),
        Reason::SelfClearance { link, other } => !of_limb(link) && !of_limb(other),
        Reason::JointLimit { joint } => {
            let mut bodies = robot.joint_bodies().iter();
            bodies.all(|body| body.joint != *joint || !of_limb(&body.name))
        }
        _ => false,
    }
}

fn keep_least(nearest: &mut Option<Failure>, failure: Failure) {
    let before = nearest.as_ref().map(Failure::severity);
    if before.is_none_or(|before| failure.severity() < before) {
        *nearest = Some(failure);
    }
}

/// The whole body along one path; what is in the way, and whether the closed contacts can be held there.
fn follow(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
) -> Result<Result<SampledTrajectory, (Failure, bool)>, Error> {
    let mut task = task.clone();
    let mut path = path.cloned();
    let (mut evades, mut extra) = (false, Extra::USUAL);
    let (mut hairs, mut waypoints) = (0, 0);
    loop {
        let failure = match attempt(context, &task, path.as_ref(), evades, extra) {
            Ok(trajectory) => return Ok(Ok(trajectory)),
            Err(failure) => failure,
        };
        tracing::trace!(
            "evades {evades}, {waypoints} waypoints: {}",
            failure.describe()
        );
        // First let the body move out of the way of what it would touch.
        let touches = matches!(
            failure.reason,
            Reason::Clearance { .. } | Reason::SelfClearance { .. }
        );
        if touches && !evades {
            evades = true;
            continue;
        }
        // What fails by a hair keeps farther from its limit.
        if hairs < HAIRS_MAX && extra.keep_more(&failure) {
            hairs += 1;
            continue;
        }
        // Then let the patch turn.
        if path.as_mut().is_some_and(SwingPath::turn_freely) {
            continue;
        }
        // Then ask the posture generator for a posture where it fails.
        if waypoints == WAYPOINTS_MAX {
            return Ok(Err((failure, true)));
        }
        waypoints += 1;
        match waypoint(context, &task, path.as_ref(), failure.at)? {
            Ok(keyframe) => {
                let at = task.keyframes.partition_point(|k| k.u < keyframe.u);
                task.keyframes.insert(at, keyframe);
            }
            Err(held) => return Ok(Err((failure, held))),
        }
    }
}

fn attempt(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
    evades: bool,
    extra: Extra,
) -> Result<SampledTrajectory, Failure> {
    let router = Router {
        context,
        task,
        path,
        evades,
        extra,
    };
    let mut route = router.solve()?;
    // What fails by much is seen on a few samples.
    let trajectory = sample(context, task, path, &mut route, LOOKS)?;
    // Bodies are clear between two samples too where they move less than their clearance.
    let over = |(step_m, _): (f64, usize)| step_m / (STEP_PART * context.posture.clearance_m);
    let finer =
        |steps: usize, over: f64| STEPS * (steps as f64 * over / STEPS as f64).ceil() as usize;
    // A way through several samples is no shorter than that from the first to the last of them; one that is much
    // longer may be a jump.
    let least = finer(LOOKS, over(trajectory.longest_step()));
    let plain = (STEPS..=FINER_MAX * STEPS).contains(&least);
    let mut steps = if plain { least } else { STEPS };
    let mut before = f64::INFINITY;
    loop {
        let trajectory = sample(context, task, path, &mut route, steps)?;
        let longest = trajectory.longest_step();
        let over = over(longest).max(trajectory.coarse);
        if over <= 1.0 {
            return Ok(trajectory);
        }
        // More samples are nearer to each other; a jump stays as far.
        if over > SHORTER * before {
            return Err(discontinuity(context, task, &trajectory, longest.1));
        }
        before = over;
        steps = finer(steps, over);
    }
}

/// The postures that close the contacts jump from one side of something to the other.
fn discontinuity(
    context: &MotionContext,
    task: &Task,
    trajectory: &SampledTrajectory,
    at: usize,
) -> Failure {
    let joints = |k: usize| trajectory.samples[k].q[7..].iter();
    let jumps = joints(at - 1).zip(joints(at)).map(|(a, b)| (b - a).abs());
    let farthest = jumps.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    let (joint, jump) = farthest.unwrap_or((0, 0.0));
    let joint = context.robot.joint_bodies()[joint].joint.clone();
    let u = at as f64 / (trajectory.samples.len() - 1) as f64;
    context.failure(task, Reason::Discontinuity { joint }, jump, u)
}

/// A posture on the closed contacts with the patch in the air where it is at `u`; where there is none, whether
/// at least the closed contacts can be held.
fn waypoint(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
    u: f64,
) -> Result<Result<Keyframe, bool>, Error> {
    let u = u.clamp(APART_MIN, 1.0 - APART_MIN);
    let near = |keyframe: &Keyframe| (keyframe.u - u).abs() < 0.9 * APART_MIN;
    if task.keyframes.iter().any(near) {
        return Ok(Err(true));
    }
    let robot = context.robot;
    let mut contacts = task.closed.clone();
    if let (Some(swing), Some(path)) = (&task.swing, path) {
        let pose = path.pose(u);
        contacts.push(Contact {
            face: Airborne::new(context, swing, &pose).face(),
            ..Contact::at(robot, swing.patch, pose).loaded(false)
        });
    }
    let mut reference = task.keyframes[0].q.clone();
    crate::blend::Blend::new(&task.keyframes).configuration(u, &mut reference);
    let problem = Problem {
        robot,
        environment: context.environment,
        contacts,
        base_goal: None,
        joint_goal: None,
        reference: &reference,
        guess: &reference,
    };
    // It must be near to the postures around it: what other seeds would find is not.
    let mut config = context.posture.clone();
    config.restarts = 0;
    config.solver.upright = task.upright(u);
    let outcome = posture::solve(&problem, &config)?;
    let posture = match outcome {
        Outcome::Feasible(posture) => posture,
        Outcome::Infeasible(violation) | Outcome::Undecided { violation, .. } => {
            tracing::debug!("no waypoint at {u:.2}: {}", violation.describe(&problem));
            let lost = |i| violation.constraint == Constraint::Closure(i);
            return Ok(Err(!(0..task.closed.len()).any(lost)));
        }
    };
    let closed = posture.contacts.iter().take(task.closed.len());
    Ok(Ok(Keyframe {
        u,
        forces_W: closed.map(|contact| contact.forces_W.clone()).collect(),
        q: posture.q,
        com_W: posture.com_W,
    }))
}
