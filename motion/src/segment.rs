//! The motion from one stance to the next: which contacts stay closed, what leaves, what lands.

use nalgebra::Translation3;
use posture::{Contact, Posture, Upright};
use robot_model::{Configuration, Kinematics, PatchId};

use crate::Error;
use crate::equations::{Target, apart, is_point, place};
use crate::failure::Failure;
use crate::generate;
use crate::interpolation::Curve;
use crate::problem::{Keyframe, MotionContext, StanceRef, Swing, Task};
use crate::projection::{Ask, Bounds, Projection};
use crate::route::joint_bounds;
use crate::sampling::{Instance, curve};
use crate::swing_path::STRAIGHT_M;
use plan::PhaseKind;

/// Poses of one contact in two stances nearer than this are one place, m (angles times 0.1 m).
const SAME_PLACE_M: f64 = 1e-3;
/// How far a patch that leaves and does not land is lifted, in lengths of the straight part.
const LIFT: f64 = 1.6;
/// How readily the patch turns while it is lifted: 0 not at all, 1 as a joint does.
const LIFT_FREEDOM: f64 = 0.5;
/// Largest residual of the lifted posture, m and rad: as small as that of a stance.
const LIFT_LEFT: f64 = 1e-6;

/// One phase of a segment.
#[derive(Clone, Debug)]
pub(crate) struct PhaseTrajectory {
    pub kind: PhaseKind,
    pub task: Task,
    /// The patch that has landed at the end, with its surface and pose.
    pub landed: Option<Contact>,
    pub samples: Vec<Instance>,
}

impl PhaseTrajectory {
    /// The curve through the samples, from 0 to 1.
    pub fn curve(&self) -> Curve {
        curve(self.samples.iter())
    }
}

/// The motion from one stance to the next.
#[derive(Clone, Debug)]
pub struct Segment {
    pub(crate) phases: Vec<PhaseTrajectory>,
}

impl Segment {
    /// Configurations along it, as [`robot_model::Configuration::to_q`] has them.
    pub fn configurations(&self) -> impl Iterator<Item = &[f64]> {
        let samples = self.phases.iter().flat_map(|phase| &phase.samples);
        samples.map(|sample| &sample.q[..])
    }
}

/// The motion between two stances of which the second follows on the first by one contact, or why
/// there is none.
///
/// # Errors
/// [`Error::Pair`] where the stances do not follow on each other; [`Error::Posture`] where a
/// waypoint cannot be posed.
pub fn segment(
    context: &MotionContext,
    from: StanceRef,
    to: StanceRef,
) -> Result<Result<Segment, Failure>, Error> {
    let robot = context.robot;
    let parts = Parts::new(context, from, to)?;
    let mut kinematics = Kinematics::new(robot, &from.posture.q);
    let mut phases = Vec::new();
    let mut start = from.posture.q.clone();
    let end = keyframe(&parts, to, &to.posture.q, 1.0, &mut kinematics, context);

    // 1. A patch that leaves and does not land again is lifted.
    let lands = parts.lands.as_ref().map(|landing| landing.patch);
    if let Some(leaving) = parts.leaves.as_ref().filter(|l| lands != Some(l.patch)) {
        let first = keyframe(&parts, from, &start, 0.0, &mut kinematics, context);
        let lifted = match lift(context, &parts, leaving, &first, &mut kinematics) {
            Ok(lifted) => lifted,
            Err(failure) => return Ok(Err(failure)),
        };
        match generate::solve(context, &lifted)? {
            Ok(trajectory) => {
                start = lifted.keyframes[1].q.clone();
                phases.push(PhaseTrajectory {
                    kind: PhaseKind::Swing,
                    task: lifted,
                    landed: None,
                    samples: trajectory.samples,
                });
            }
            Err(failure) => return Ok(Err(failure)),
        }
    }

    // 2. The rest: all contacts closed, or one patch swings to a new place.
    let first = keyframe(&parts, from, &start, 0.0, &mut kinematics, context);
    let swing = parts.lands.as_ref().map(|landing| {
        let patch = &robot.patches[landing.patch];
        let mut pose = |q: &Configuration| {
            kinematics.update(robot, q);
            kinematics.X_WC(patch)
        };
        let leaves = parts.leaves.as_ref().filter(|l| l.patch == landing.patch);
        Swing {
            patch: landing.patch,
            from: pose(&start),
            to: pose(&to.posture.q),
            leaves: leaves.and_then(|l| l.face),
            lands: landing.face,
            rolling: [leaves, Some(landing)].map(|c| c.and_then(|c| c.rolling(robot))),
        }
    });
    let task = Task {
        closed: parts.closed.clone(),
        swing,
        upright: parts.upright,
        keyframes: vec![first, end],
    };
    match generate::solve(context, &task)? {
        Ok(trajectory) => phases.push(PhaseTrajectory {
            kind: lands.map_or(PhaseKind::Shift, |_| PhaseKind::Swing),
            task,
            landed: parts.lands,
            samples: trajectory.samples,
        }),
        Err(failure) => return Ok(Err(failure)),
    }
    Ok(Ok(Segment { phases }))
}

/// Which contacts stay, leave and land between two stances.
struct Parts {
    closed: Vec<Contact>,
    upright: Option<[Upright; 2]>,
    leaves: Option<Contact>,
    lands: Option<Contact>,
}

impl Parts {
    fn new(context: &MotionContext, from: StanceRef, to: StanceRef) -> Result<Self, Error> {
        let refuse = |cause: String| Err(Error::Pair { cause });
        for end in [from, to] {
            if end.contacts.len() != end.posture.contacts.len() {
                return refuse("a contact has no state".to_owned());
            }
        }
        let at = |end: StanceRef, i: usize| {
            let placed = end.contacts[i].placed(end.posture.contacts[i].X_WC);
            placed.loaded(true)
        };
        let mut parts = Self {
            closed: Vec::new(),
            upright: upright(from.posture, to.posture),
            leaves: None,
            lands: None,
        };
        let name = |patch: PatchId| context.robot.patches[patch].name.clone();
        for i in 0..to.contacts.len() {
            let contact = at(to, i);
            let turns = is_point(context.robot, contact.patch);
            let mut before = (0..from.contacts.len()).map(|k| at(from, k));
            let before = before.find(|b| b.patch == contact.patch && b.face == contact.face);
            let stays = |b: &Contact| apart(&b.X_WC, &contact.X_WC, turns) < SAME_PLACE_M;
            if let Some(before) = before.filter(stays) {
                // It stays where it stood in the first stance.
                parts.closed.push(before);
            } else if parts.lands.is_none() && !to.contacts[i].loaded {
                parts.lands = Some(contact);
            } else {
                let name = name(contact.patch);
                return refuse(format!("{name} is loaded where it was not"));
            }
        }
        for (k, held) in from.contacts.iter().enumerate() {
            if parts.closed.iter().any(|c| c.patch == held.patch) {
                continue;
            }
            if held.loaded || parts.leaves.is_some() {
                return refuse(format!("{} leaves under load", name(held.patch)));
            }
            parts.leaves = Some(at(from, k));
        }
        if parts.closed.is_empty() {
            return refuse("no contact stays closed".to_owned());
        }
        Ok(parts)
    }
}

/// How far the base may tilt at both ends: as far as the other where one has no bound, and no less than it
/// does.
fn upright(from: &Posture, to: &Posture) -> Option<[Upright; 2]> {
    let any = from.upright.or(to.upright)?;
    Some([from, to].map(|end| {
        let bound = end.upright.unwrap_or(any);
        Upright {
            tilt_max_rad: bound.tilt_max_rad.max(bound.tilt_rad(&end.q.R_WB)),
            ..bound
        }
    }))
}

/// A stance's posture, or another one with the same forces, as a keyframe on the closed contacts.
fn keyframe(
    parts: &Parts,
    end: StanceRef,
    q: &Configuration,
    u: f64,
    kinematics: &mut Kinematics,
    context: &MotionContext,
) -> Keyframe {
    kinematics.update(context.robot, q);
    let forces = |closed: &Contact| {
        let mut states = end.contacts.iter().zip(&end.posture.contacts);
        let found = states.find(|(contact, _)| contact.patch == closed.patch);
        found.map_or_else(Vec::new, |(_, state)| state.forces_W.clone())
    };
    Keyframe {
        u,
        q: q.clone(),
        com_W: kinematics.com_W,
        forces_W: parts.closed.iter().map(forces).collect(),
    }
}

/// The task of lifting a patch off its surface, the centre of mass at rest.
fn lift(
    context: &MotionContext,
    parts: &Parts,
    leaving: &Contact,
    first: &Keyframe,
    kinematics: &mut Kinematics,
) -> Result<Task, Failure> {
    let robot = context.robot;
    kinematics.update(robot, &first.q);
    let from = kinematics.X_WC(&robot.patches[leaving.patch]);
    let n = leaving.normal_W();
    let to = Translation3::from(n * (LIFT * STRAIGHT_M)) * from;
    let closed = parts.closed.iter().map(|c| {
        let rolling = c.rolling(robot);
        let X_WC = place(robot, kinematics, c.patch, rolling.as_ref());
        (c.patch, X_WC, rolling)
    });
    let target = Target {
        patches: closed.chain([(leaving.patch, to, None)]).collect(),
        turn_freedom: LIFT_FREEDOM,
        com_W: first.com_W,
    };
    let weight = vec![1.0; robot.nv()];
    let joints = joint_bounds(context, 0.0);
    let bounds = Bounds {
        joints: &joints,
        upright: parts.upright.map(|ends| ends[0]),
        near: None,
    };
    let mut q = first.q.clone();
    let ask = Ask {
        robot,
        target: &target,
        bounds: &bounds,
        weight: &weight,
    };
    let left = Projection::default().solve(&ask, &first.q, &mut q, kinematics);
    let mut task = Task {
        closed: parts.closed.clone(),
        swing: Some(Swing {
            patch: leaving.patch,
            from,
            // It may have turned on the way.
            to: kinematics.X_WC(&robot.patches[leaving.patch]),
            leaves: leaving.face,
            lands: None,
            rolling: [leaving.rolling(robot), None],
        }),
        upright: parts.upright.map(|ends| [ends[0]; 2]),
        keyframes: vec![first.clone(), first.clone()],
    };
    if left.is_nan() || left > LIFT_LEFT {
        let patch = Some(robot.patches[leaving.patch].name.clone());
        let reason = crate::failure::Reason::Closure { patch };
        return Err(context.failure(&task, reason, left, 1.0));
    }
    kinematics.update(robot, &q);
    task.keyframes[1] = Keyframe {
        u: 1.0,
        com_W: kinematics.com_W,
        q,
        forces_W: first.forces_W.clone(),
    };
    Ok(task)
}
