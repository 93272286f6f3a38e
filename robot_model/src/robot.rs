//! A robot: a tree of bodies under a floating base, its frames, patches, postures and shapes.

use std::collections::BTreeMap;

use nalgebra::{DVector, Isometry3};

use crate::collision::{CollidingPair, CollisionModel};
use crate::{Body, Configuration, ContactPatch, Error, Frame, JointKind, PatchId};

/// As many joints are between a sole or a palm and the links that carry it, at most: those of an ankle or a wrist.
const CLOSE_JOINTS: usize = 2;

/// A posture that has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPosture {
    /// Value of every joint; neutral where none is stated.
    pub joints: Vec<f64>,
    /// Which of them are stated.
    pub is_stated: Vec<bool>,
    /// Pose of the base, where it is stated.
    pub base: Option<Isometry3<f64>>,
}

/// A floating-base robot.
///
/// Bodies come in depth-first order: 0 is the floating base, parents come before children, and
/// the bodies that a joint carries are a contiguous range. Joint j moves body j + 1.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The robot's name.
    pub name: String,
    /// Moving bodies, links on fixed joints lumped in.
    pub bodies: Vec<Body>,
    /// Every link of the URDF as a frame on a body.
    pub frames: Vec<Frame>,
    /// Where it may touch the world; [`Self::set_patches`] replaces them.
    pub patches: Vec<ContactPatch>,
    /// Named postures.
    pub postures: BTreeMap<String, NamedPosture>,
    /// Collision shapes and the pairs of them to watch.
    pub collision: CollisionModel,
    /// The watched pairs of links that are nearer than 8 mm in [`Self::resting`].
    pub meeting_at_rest: Vec<CollidingPair>,
    /// Total mass.
    pub mass_kg: f64,
    /// How far it reaches from its base with its limbs stretched, to the middle of the farthest shape: the
    /// length that others are measured by, so that robots of all sizes move alike.
    pub size_m: f64,
    /// What was assumed while loading.
    pub notes: Vec<String>,
    /// One past the last body that body i carries.
    subtree_end: Vec<usize>,
}

impl Robot {
    /// Gives it what it touches with, in the place of what it had.
    pub fn set_patches(&mut self, patches: Vec<ContactPatch>) {
        self.collision.find_pads(&patches);
        self.patches = patches;
    }

    /// A robot of bodies in depth-first order.
    ///
    /// # Errors
    /// [`Error::Value`] when the bodies are not a tree in depth-first order under one floating
    /// base, or a frame, patch or posture does not fit them.
    pub fn new(
        name: String,
        bodies: Vec<Body>,
        frames: Vec<Frame>,
        collision: CollisionModel,
    ) -> Result<Self, Error> {
        let subtree_end = subtree_ends(&bodies)?;
        let framed = frames.iter().map(|f| (f.body, &f.name));
        let shaped = collision.shapes().iter().map(|s| (s.body, &s.link));
        if let Some((_, link)) = framed.chain(shaped).find(|(at, _)| *at >= bodies.len()) {
            let cause = format!("link \"{link}\" is on no body");
            return Err(Error::value("robot", cause));
        }
        let mass_kg = bodies.iter().map(|b| b.mass_kg).sum();
        let size_m = size_m(&bodies, &collision);
        Ok(Robot {
            name,
            bodies,
            frames,
            patches: Vec::new(),
            postures: BTreeMap::new(),
            collision,
            meeting_at_rest: Vec::new(),
            mass_kg,
            size_m,
            notes: Vec::new(),
            subtree_end,
        })
    }

    /// Number of actuated joints.
    pub fn nj(&self) -> usize {
        self.bodies.len() - 1
    }

    /// Number of velocities: 6 + nj.
    pub fn nv(&self) -> usize {
        6 + self.nj()
    }

    /// The actuated joints' names, in the order of q.
    pub fn joint_names(&self) -> impl ExactSizeIterator<Item = &str> + Clone {
        self.bodies[1..].iter().map(|b| b.joint.as_str())
    }

    /// The actuated joints' bodies, in the order of q: joint j moves `joint_bodies()[j]`.
    pub fn joint_bodies(&self) -> &[Body] {
        &self.bodies[1..]
    }

    /// Whether `joint_body`'s joint moves `body`: it is the body itself or one of its ancestors.
    pub fn supports(&self, joint_body: usize, body: usize) -> bool {
        joint_body <= body && body < self.subtree_end[joint_body]
    }

    /// Whether the link of a patch carries that of another one, as the shank with a knee does the foot.
    pub fn carries(&self, patch: PatchId, other: PatchId) -> bool {
        let [above, below] = [patch, other].map(|patch| self.patches[patch].body);
        above != below && self.supports(above, below)
    }

    /// The bodies whose joints lie on the way from one body to another, from both ends.
    pub fn joints_between(&self, a: usize, b: usize) -> impl Iterator<Item = usize> {
        let up = move |from: usize, to: usize| {
            let above = std::iter::successors(Some(from), |&body| self.bodies[body].parent);
            above.take_while(move |&body| !self.supports(body, to))
        };
        up(a, b).chain(up(b, a))
    }

    /// Whether two bodies are one, or at most two joints are between them, as between a sole or a palm and what carries
    /// it.
    pub fn are_close(&self, a: usize, b: usize) -> bool {
        self.joints_between(a, b).nth(CLOSE_JOINTS).is_none()
    }

    /// The bodies that `body`'s joint moves, itself first.
    pub fn subtree(&self, body: usize) -> std::ops::Range<usize> {
        body..self.subtree_end[body]
    }

    /// Index of a joint in the joint vector.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn joint_index(&self, name: &str) -> Result<usize, Error> {
        position("joint", name, self.joint_names())
    }

    /// The contact patch of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn patch(&self, name: &str) -> Result<&ContactPatch, Error> {
        self.patch_id(name).map(|id| &self.patches[id])
    }

    /// The id of the contact patch of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn patch_id(&self, name: &str) -> Result<PatchId, Error> {
        position("patch", name, self.patches.iter().map(|p| p.name.as_str())).map(PatchId)
    }

    /// The ids of all patches, in the order of the contacts file.
    pub fn patch_ids(&self) -> impl ExactSizeIterator<Item = PatchId> + Clone + use<> {
        (0..self.patches.len()).map(PatchId)
    }

    /// Index of the contact patch of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn patch_index(&self, name: &str) -> Result<usize, Error> {
        self.patch_id(name).map(PatchId::index)
    }

    /// The frame of a link.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn frame(&self, link: &str) -> Result<&Frame, Error> {
        let names = self.frames.iter().map(|f| f.name.as_str());
        position("link", link, names).map(|at| &self.frames[at])
    }

    /// The base at the origin, joints at zero or at the nearer limit where zero is out of range.
    pub fn neutral(&self) -> Configuration {
        let mut neutral = Configuration::zero(self.nj());
        for (q, body) in neutral.joints.iter_mut().zip(self.joint_bodies()) {
            *q = 0.0_f64.clamp(body.lower, body.upper);
        }
        neutral
    }

    /// Joints as in the named posture, the base where the posture has it or else at the origin.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the postures there are.
    pub fn posture(&self, name: &str) -> Result<Configuration, Error> {
        let names = || self.postures.keys().map(String::as_str);
        let posture = self.postures.get(name);
        let posture = posture.ok_or_else(|| Error::unknown(None, "posture", name, names()))?;
        let mut configuration = Configuration::zero(self.nj());
        if let Some(base) = &posture.base {
            configuration = configuration.with_base(base);
        }
        configuration.joints = DVector::from_column_slice(&posture.joints);
        Ok(configuration)
    }

    /// Where collision at load is looked for: the posture named half_sitting or standing, or
    /// else the first one, or else [`Self::neutral`].
    pub fn resting(&self) -> Configuration {
        ["half_sitting", "standing"]
            .into_iter()
            .chain(self.postures.keys().map(String::as_str))
            .find_map(|name| self.posture(name).ok())
            .unwrap_or_else(|| self.neutral())
    }

    /// The configuration of q = [p_WB, quat_xyzw, joints…], as long as this robot's is.
    ///
    /// # Errors
    /// As [`Configuration::from_q`], and [`Error::Value`] for another number of joints.
    pub fn configuration(&self, q: &[f64]) -> Result<Configuration, Error> {
        let configuration = Configuration::from_q(q)?;
        let (wanted, found) = (7 + self.nj(), q.len());
        if found != wanted {
            let cause = format!("{found} values, {wanted} wanted for \"{}\"", self.name);
            return Err(Error::value("configuration q", cause));
        }
        Ok(configuration)
    }

    /// Whether the joint values have the right number and lie within the limits (± `tol`).
    ///
    /// # Errors
    /// [`Error::Value`] naming the first joint that does not.
    pub fn check_joints(&self, joints: &[f64], tol: f64) -> Result<(), Error> {
        let refuse = |cause: String| Err(Error::value("joint values", cause));
        if joints.len() != self.nj() {
            return refuse(format!("{} values for {} joints", joints.len(), self.nj()));
        }
        for (q, body) in joints.iter().zip(self.joint_bodies()) {
            if !(*q >= body.lower - tol && *q <= body.upper + tol) {
                let (joint, range) = (&body.joint, [body.lower, body.upper]);
                return refuse(format!("joint \"{joint}\" at {q} is outside {range:?}"));
            }
        }
        Ok(())
    }
}

/// The place of a name among those of its kind.
fn position<'a>(
    kind: &'static str,
    name: &str,
    mut names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Error> {
    let all = names.clone();
    let found = names.position(|n| n == name);
    found.ok_or_else(|| Error::unknown(None, kind, name, all))
}

/// The length from the base to the middle of the farthest shape, limbs stretched, m.
fn size_m(bodies: &[Body], collision: &CollisionModel) -> f64 {
    let mut length_m: Vec<f64> = Vec::with_capacity(bodies.len());
    for body in bodies {
        let before = body.parent.map_or(0.0, |parent| {
            length_m[parent] + body.X_PJ.translation.vector.norm()
        });
        length_m.push(before);
    }
    let shapes = collision.shapes().iter().map(|shape| {
        let middle = shape.X_BG * shape.geometry.bounds().0;
        length_m[shape.body] + middle.coords.norm()
    });
    shapes
        .chain(length_m.iter().copied())
        .fold(SIZE_MIN_M, f64::max)
}

/// No robot counts as smaller, m.
const SIZE_MIN_M: f64 = 0.01;

/// One past the last body of each subtree, having checked the depth-first order.
fn subtree_ends(bodies: &[Body]) -> Result<Vec<usize>, Error> {
    let refuse = |cause: &str| Err(Error::value("robot", cause));
    match bodies.first() {
        Some(base) if base.parent.is_none() && base.kind == JointKind::Floating => {}
        _ => return refuse("the first body is no floating base"),
    }
    let mut end = vec![bodies.len(); bodies.len()];
    let mut open = vec![0_usize];
    for (i, body) in bodies.iter().enumerate().skip(1) {
        let Some(parent) = body.parent.filter(|_| body.kind != JointKind::Floating) else {
            return refuse(&format!("body \"{}\" floats", body.name));
        };
        // Close the subtrees that this body is not in.
        while let Some(&top) = open.last()
            && top != parent
        {
            end[top] = i;
            open.pop();
        }
        if open.is_empty() {
            let name = &body.name;
            return refuse(&format!("body \"{name}\" is out of depth-first order"));
        }
        open.push(i);
    }
    Ok(end)
}
