//! What all checks of stances and motions share.

use nalgebra::{Matrix4, Vector3};
use plan::{Contact, Plan, Stance};
use robot_model::{ContactPatch, Robot};
use surfaces::Face;

use crate::posture::Posture;
use crate::shapes::Shank;
use crate::solid::Solid;
use crate::surroundings::Surroundings;

/// A contact of a stance, with what it refers to and where the posture puts it.
pub(crate) struct Touch<'a> {
    pub stated: &'a Contact,
    pub patch: &'a ContactPatch,
    pub face: &'a Face,
    /// Pose of the patch frame in W, by the posture; of a ball its centre, with the face's axes.
    pub X_WC: Matrix4<f64>,
    /// The patch's vertices in W, by the posture; of a ball the point that is nearest to the
    /// face's plane on the outer side.
    pub vertices_W: Vec<Vector3<f64>>,
}

impl<'a> Scene<'a> {
    /// The patch and the face that a contact names.
    pub fn named(&self, contact: &Contact) -> Option<(&'a ContactPatch, &'a Face)> {
        let patch = self
            .robot
            .patches
            .iter()
            .find(|p| p.name == contact.patch)?;
        let face = self.plan.faces.iter().find(|f| f.id == contact.face)?;
        Some((patch, face))
    }
}

/// What all stances share.
pub(crate) struct Scene<'a> {
    pub plan: &'a Plan,
    pub robot: &'a Robot,
    pub surroundings: Surroundings,
    /// The robot's shapes, each with its body, in the body's frame, and after them what `shanks` have of them.
    pub shapes: Vec<(usize, Solid)>,
    /// The shapes that hold a ball and reach beyond it.
    pub shanks: Vec<Shank>,
}

/// A stance where its posture puts it.
pub(crate) struct Placed<'a> {
    pub scene: &'a Scene<'a>,
    /// Its index, as rows have it.
    pub at: Option<usize>,
    pub stance: &'a Stance,
    pub posture: Posture<'a>,
    pub touches: Vec<Touch<'a>>,
}
