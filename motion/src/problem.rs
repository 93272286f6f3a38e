//! What is asked: two stances that follow on each other, in an environment.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Vector3};
use posture::{Environment, Posture};
use robot_model::{Configuration, Robot};

use crate::Config;
use crate::failure::{Failure, Reason};

/// What all segments of a plan share.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// The margins of the postures, which the motion keeps too.
    pub posture: &'a posture::Config,
    /// Times and budgets.
    pub config: &'a Config,
}

/// A stance at one end of a segment.
#[derive(Clone, Copy)]
pub struct End<'a> {
    /// What touches: patch, surface, whether it may carry load.
    pub contacts: &'a [(usize, usize, bool)],
    /// The posture, with a state for each of `contacts`.
    pub posture: &'a Posture,
}

/// A contact that stays closed while a phase lasts.
#[derive(Clone, Debug)]
pub(crate) struct Closed {
    pub patch: usize,
    pub surface: usize,
    /// Pose of the patch frame in W.
    pub X_WC: Isometry3<f64>,
}

/// One point of a phase's way: a posture with its forces, in equilibrium on the closed contacts.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    /// Where on the way, 0…1.
    pub u: f64,
    pub q: Configuration,
    pub com_W: Vector3<f64>,
    /// Force at each force point of each closed contact, N.
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// The patch that a phase moves through the air.
#[derive(Clone, Debug)]
pub(crate) struct Swing {
    pub patch: usize,
    pub from: Isometry3<f64>,
    pub to: Isometry3<f64>,
    /// The surface it leaves; none where it begins in the air.
    pub leaves: Option<usize>,
    /// The surface it lands on; none where it stays in the air.
    pub lands: Option<usize>,
}

/// A phase whose motion is wanted: from one posture to another on the same closed contacts.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    pub closed: Vec<Closed>,
    pub swing: Option<Swing>,
    /// The postures at both ends; waypoints come between.
    pub keys: Vec<Key>,
}

impl Setting<'_> {
    /// A failure of a phase.
    pub(crate) fn failure(&self, task: &Task, reason: Reason, amount: f64, at: f64) -> Failure {
        let swing = task.swing.as_ref();
        Failure {
            reason,
            amount,
            at,
            swing: swing.map(|s| self.robot.patches[s.patch].name.clone()),
        }
    }
}

impl Task {
    /// Whether a shape of `body` may touch what is behind the plane of a surface that the body's
    /// patch is in contact with.
    pub fn touches(&self, setting: &Setting, body: usize, obstacle: usize) -> bool {
        self.closed.iter().any(|contact| {
            setting.robot.patches[contact.patch].body == body
                && setting.environment.behind[contact.surface][obstacle]
        })
    }
}
