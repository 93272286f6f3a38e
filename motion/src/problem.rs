//! The problem: two stances that follow on each other, in an environment, and its phases.

use nalgebra::{Isometry3, Vector3};
use posture::{Contact, Environment, FaceIndex, PlacedShape, Posture, Rolling, Upright};
use robot_model::collision::Shape;
use robot_model::{Configuration, ContactPatch, PatchId, Robot};

use crate::Config;
use crate::failure::{Failure, Reason};

/// What all segments of a plan share.
#[derive(Clone, Copy)]
pub struct MotionContext<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What it may touch and must not hit.
    pub environment: &'a Environment,
    /// The margins of the postures, which the motion keeps too.
    pub posture: &'a posture::Config,
    /// Times and speeds.
    pub config: &'a Config,
}

impl<'a> MotionContext<'a> {
    /// What all segments of a plan share.
    pub fn new(
        robot: &'a Robot,
        environment: &'a Environment,
        posture: &'a posture::Config,
        config: &'a Config,
    ) -> Self {
        Self {
            robot,
            environment,
            posture,
            config,
        }
    }
}

/// A stance at one end of a segment.
#[derive(Clone, Copy)]
pub struct StanceRef<'a> {
    /// What touches.
    pub contacts: &'a [Contact],
    /// The posture, with a state for each of `contacts`.
    pub posture: &'a Posture,
}

impl<'a> StanceRef<'a> {
    /// A stance: contacts, and a posture with a state for each of them.
    pub fn new(contacts: &'a [Contact], posture: &'a Posture) -> Self {
        Self { contacts, posture }
    }
}

/// One point of a phase's path: a posture with its forces, in equilibrium on the closed contacts.
#[derive(Clone, Debug)]
pub(crate) struct Keyframe {
    /// Where on the path, 0…1.
    pub u: f64,
    pub q: Configuration,
    pub com_W: Vector3<f64>,
    /// Force at each force point of each closed contact, N.
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// The patch that a phase moves through the air.
#[derive(Clone, Debug)]
pub(crate) struct Swing {
    pub patch: PatchId,
    pub from: Isometry3<f64>,
    pub to: Isometry3<f64>,
    /// The face it leaves; none where it begins in the air.
    pub leaves: Option<FaceIndex>,
    /// The face it lands on; none where it stays in the air.
    pub lands: Option<FaceIndex>,
    /// How its ball rolls where it leaves and where it lands, while it touches.
    pub rolling: [Option<Rolling>; 2],
}

/// A phase whose motion is wanted: from one posture to another on the same closed contacts.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// The contacts that stay closed, each at its place.
    pub closed: Vec<Contact>,
    pub swing: Option<Swing>,
    /// How far the base may tilt at both ends, where there is a bound.
    pub upright: Option<[Upright; 2]>,
    /// The postures at both ends; waypoints come between.
    pub keyframes: Vec<Keyframe>,
}

impl MotionContext<'_> {
    /// Name of a patch.
    pub(crate) fn patch_name(&self, patch: PatchId) -> String {
        self.robot.patches[patch].name.clone()
    }

    /// A failure of a phase.
    pub(crate) fn failure(&self, task: &Task, reason: Reason, amount: f64, at: f64) -> Failure {
        let swing = task.swing.as_ref();
        Failure {
            reason,
            amount,
            at,
            swing: swing.map(|s| self.patch_name(s.patch)),
        }
    }
}

impl Task {
    /// How far the base may tilt at `u`, where there is a bound: between what holds at the ends.
    pub fn upright(&self, u: f64) -> Option<Upright> {
        self.upright.map(|[a, b]| Upright {
            z_W: a.z_W.lerp(&b.z_W, u).normalize(),
            tilt_max_rad: a.tilt_max_rad + u * (b.tilt_max_rad - a.tilt_max_rad),
        })
    }

    /// The least distance, m, of a shape from an obstacle that lies behind the plane of a face that a
    /// patch of its body, or of one that it carries, rests on; nothing where there is no such face.
    pub fn contact_distance_m(
        &self,
        context: &MotionContext,
        shape: &Shape,
        obstacle: usize,
    ) -> Option<f64> {
        let apart_m = context.posture.carrying_clearance_m();
        let least_m = self.touches(context).filter_map(|touch| {
            let environment = context.environment;
            environment.contact_distance_m(context.robot, touch, shape, obstacle, apart_m)
        });
        least_m.min_by(f64::total_cmp)
    }

    /// The same of a shape of a body to what rises gently beside such a contact.
    pub fn beside_contact_m(
        &self,
        context: &MotionContext,
        (body, shape): (usize, &PlacedShape),
        obstacle: usize,
    ) -> Option<f64> {
        let own = self
            .touches(context)
            .filter(|(patch, _)| patch.body == body);
        let least_m =
            own.filter_map(|on| (context.environment).beside_contact_m(on, shape, obstacle));
        least_m.min_by(f64::total_cmp)
    }

    /// The patches that rest on a face, with the face.
    fn touches<'a>(
        &'a self,
        context: &'a MotionContext,
    ) -> impl Iterator<Item = (&'a ContactPatch, FaceIndex)> {
        let closed = self.closed.iter();
        closed.filter_map(move |c| Some((&context.robot.patches[c.patch], c.face?)))
    }
}
