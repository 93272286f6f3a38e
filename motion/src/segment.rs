//! The motion from one stance to the next: which contacts stay closed, what leaves, what lands.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Translation3};
use robot_model::{Configuration, Kinematics};

use crate::Error;
use crate::failure::Failure;
use crate::generate;
use crate::problem::{Closed, End, Key, Setting, Swing, Task};
use crate::projection::{ANGLE_ARM_M, Bounds, Projection, Target, is_point};
use crate::record::PhaseKind;
use crate::route::joint_bounds;
use crate::track::Instance;

/// Poses of one contact in two stances nearer than this are one place, m (angles times 0.1 m).
const SAME_PLACE_M: f64 = 1e-3;
/// How far a patch that leaves and does not land moves away from its surface, in straight parts.
const LIFT: f64 = 1.6;
/// How freely it turns meanwhile, beside the joints.
const LIFT_FREEDOM: f64 = 0.5;
/// Residual of the lifted posture, m and rad: that of a stance's.
const LIFT_LEFT: f64 = 1e-6;

/// One phase of a segment.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    pub kind: PhaseKind,
    pub closed: Vec<Closed>,
    pub swing: Option<usize>,
    /// The patch that has landed at the end, with its surface and pose.
    pub landed: Option<Closed>,
    pub samples: Vec<Instance>,
}

/// The motion from one stance to the next.
#[derive(Clone, Debug)]
pub struct Segment {
    pub(crate) stretches: Vec<Stretch>,
}

impl Segment {
    /// Number of samples, those at both ends included.
    pub fn samples(&self) -> usize {
        self.stretches.iter().map(|s| s.samples.len()).sum()
    }
}

/// The motion between two stances of which the second follows on the first by one contact, or why
/// there is none.
///
/// # Errors
/// [`Error::Pair`] where the stances do not follow on each other; [`Error::Posture`] where a
/// waypoint cannot be posed.
pub fn segment(setting: &Setting, from: End, to: End) -> Result<Result<Segment, Failure>, Error> {
    let robot = setting.robot;
    let parts = Parts::new(setting, from, to)?;
    let mut kinematics = Kinematics::new(robot, &from.posture.q);
    let mut stretches = Vec::new();
    let mut start = from.posture.q.clone();
    let end = key(&parts, to, &to.posture.q, 1.0, &mut kinematics, setting);

    // What leaves and lands nowhere is lifted first.
    if let Some(leaving) = &parts.leaves
        && parts
            .lands
            .as_ref()
            .is_none_or(|l| l.patch != leaving.patch)
    {
        let first = key(&parts, from, &start, 0.0, &mut kinematics, setting);
        let lifted = match lift(setting, &parts, leaving, &first, &mut kinematics) {
            Ok(lifted) => lifted,
            Err(failure) => return Ok(Err(failure)),
        };
        match generate::solve(setting, &lifted)? {
            Ok(track) => {
                start = lifted.keys[1].q.clone();
                stretches.push(Stretch {
                    kind: PhaseKind::Swing,
                    closed: lifted.closed,
                    swing: Some(leaving.patch),
                    landed: None,
                    samples: track.samples,
                });
            }
            Err(failure) => return Ok(Err(failure)),
        }
    }

    // The rest: all closed, or one patch on its way to a new place.
    let first = key(&parts, from, &start, 0.0, &mut kinematics, setting);
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
            leaves: leaves.map(|l| l.surface),
            lands: Some(landing.surface),
        }
    });
    let task = Task {
        closed: parts.closed.clone(),
        swing,
        keys: vec![first, end],
    };
    match generate::solve(setting, &task)? {
        Ok(track) => stretches.push(Stretch {
            kind: if task.swing.is_some() {
                PhaseKind::Swing
            } else {
                PhaseKind::Shift
            },
            closed: task.closed,
            swing: parts.lands.as_ref().map(|l| l.patch),
            landed: parts.lands,
            samples: track.samples,
        }),
        Err(failure) => return Ok(Err(failure)),
    }
    Ok(Ok(Segment { stretches }))
}

/// Which contacts stay, leave and land between two stances.
struct Parts {
    closed: Vec<Closed>,
    leaves: Option<Closed>,
    lands: Option<Closed>,
}

impl Parts {
    fn new(setting: &Setting, from: End, to: End) -> Result<Self, Error> {
        let refuse = |cause: String| Err(Error::Pair { cause });
        for end in [from, to] {
            if end.contacts.len() != end.posture.contacts.len() {
                return refuse("a contact has no state".to_owned());
            }
        }
        let at = |end: End, i: usize| Closed {
            patch: end.contacts[i].0,
            surface: end.contacts[i].1,
            X_WC: end.posture.contacts[i].X_WC,
        };
        let mut parts = Self {
            closed: Vec::new(),
            leaves: None,
            lands: None,
        };
        let name = |patch: usize| setting.robot.patches[patch].name.clone();
        for i in 0..to.contacts.len() {
            let contact = at(to, i);
            let before = (0..from.contacts.len())
                .map(|k| at(from, k))
                .find(|b| b.patch == contact.patch && b.surface == contact.surface)
                .filter(|b| {
                    let point = is_point(setting.robot, contact.patch);
                    apart(&b.X_WC, &contact.X_WC, point) < SAME_PLACE_M
                });
            match before {
                // Where it stands from the first stance on.
                Some(before) => parts.closed.push(before),
                None if parts.lands.is_none() && !to.contacts[i].2 => parts.lands = Some(contact),
                None => {
                    return refuse(format!(
                        "{} is loaded where it was not",
                        name(contact.patch)
                    ));
                }
            }
        }
        for (k, &(patch, _, loaded)) in from.contacts.iter().enumerate() {
            if parts.closed.iter().any(|c| c.patch == patch) {
                continue;
            }
            if loaded || parts.leaves.is_some() {
                return refuse(format!("{} leaves under load", name(patch)));
            }
            parts.leaves = Some(at(from, k));
        }
        if parts.closed.is_empty() {
            return refuse("no contact stays closed".to_owned());
        }
        Ok(parts)
    }
}

fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>, point: bool) -> f64 {
    let apart = (a.translation.vector - b.translation.vector).norm();
    if point {
        return apart;
    }
    apart.max(ANGLE_ARM_M * a.rotation.angle_to(&b.rotation))
}

/// A stance's posture, or another one with the same forces, as a key of the closed contacts.
fn key(
    parts: &Parts,
    end: End,
    q: &Configuration,
    u: f64,
    kinematics: &mut Kinematics,
    setting: &Setting,
) -> Key {
    kinematics.update(setting.robot, q);
    let forces_W = parts
        .closed
        .iter()
        .map(|closed| {
            end.contacts
                .iter()
                .position(|c| c.0 == closed.patch)
                .map_or_else(Vec::new, |i| end.posture.contacts[i].forces_W.clone())
        })
        .collect();
    Key {
        u,
        q: q.clone(),
        com_W: kinematics.com_W,
        forces_W,
    }
}

/// The task of lifting a patch off its surface, the centre of mass at rest.
fn lift(
    setting: &Setting,
    parts: &Parts,
    leaving: &Closed,
    first: &Key,
    kinematics: &mut Kinematics,
) -> Result<Task, Failure> {
    let robot = setting.robot;
    kinematics.update(robot, &first.q);
    let from = kinematics.X_WC(&robot.patches[leaving.patch]);
    let n = setting.environment.surfaces[leaving.surface].normal_W();
    let to = Translation3::from(n * (LIFT * setting.config.straight_m)) * from;
    let patches = parts.closed.iter().map(|c| c.patch);
    let mut target = Target {
        patches: patches
            .map(|p| (p, kinematics.X_WC(&robot.patches[p])))
            .collect(),
        turn_freedom: LIFT_FREEDOM,
        com_W: first.com_W,
    };
    target.patches.push((leaving.patch, to));
    let weight = vec![1.0; robot.nv()];
    let joints = joint_bounds(setting, 0.0);
    let bounds = Bounds {
        joints: &joints,
        near: None,
    };
    let mut q = first.q.clone();
    let left = Projection::default().solve(
        robot, &target, &bounds, &weight, &first.q, &mut q, kinematics,
    );
    let mut task = Task {
        closed: parts.closed.clone(),
        swing: Some(Swing {
            patch: leaving.patch,
            from,
            // It may have turned.
            to: kinematics.X_WC(&robot.patches[leaving.patch]),
            leaves: Some(leaving.surface),
            lands: None,
        }),
        keys: vec![first.clone(), first.clone()],
    };
    if left.is_nan() || left > LIFT_LEFT {
        let patch = Some(robot.patches[leaving.patch].name.clone());
        let reason = crate::failure::Reason::Closure { patch };
        return Err(setting.failure(&task, reason, left, 1.0));
    }
    kinematics.update(robot, &q);
    task.keys[1] = Key {
        u: 1.0,
        com_W: kinematics.com_W,
        q,
        forces_W: first.forces_W.clone(),
    };
    Ok(task)
}
