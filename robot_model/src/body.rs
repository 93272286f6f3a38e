//! The rigid bodies of a robot, the frames on them, and the joints that move them.

use nalgebra::{Isometry3, Matrix3, Translation3, Vector3};

/// How a body moves in its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Six freedoms: body 0, the floating base B.
    Floating,
    /// Turns about its axis; rad.
    Revolute,
    /// Slides along its axis; m.
    Prismatic,
}

/// A moving link, with every link that is fixed to it lumped in.
///
///   X_WB(q) = X_WP · X_PJ · motion(axis, q)
///
/// Units: m, rad, kg, kg·m², N·m or N, rad/s or m/s.
#[derive(Clone, Debug)]
pub struct Body {
    /// The moving link's name.
    pub name: String,
    /// The name of the joint that moves it; empty for the floating base.
    pub joint: String,
    /// Index of the parent body; `None` for the floating base only.
    pub parent: Option<usize>,
    /// The joint's frame in the parent body, at joint value zero.
    pub X_PJ: Isometry3<f64>,
    /// How the body moves.
    pub kind: JointKind,
    /// Unit axis in the joint's frame (which the body's frame coincides with at joint value zero).
    pub axis: Vector3<f64>,
    /// Lower limit; finite for every joint (a continuous one gets ±2π and a note).
    pub lower: f64,
    /// Upper limit, above `lower`.
    pub upper: f64,
    /// Greatest torque or force; `f64::INFINITY` where the URDF states none (and a note says so).
    pub effort: f64,
    /// Greatest speed; `f64::INFINITY` where the URDF states none.
    pub velocity: f64,
    /// Mass, that of lumped links included.
    pub mass_kg: f64,
    /// Centre of mass in the body's frame.
    pub com_B: Vector3<f64>,
    /// Inertia about the centre of mass, axes of the body's frame.
    pub inertia_B: Matrix3<f64>,
}

impl Body {
    /// The pose in the parent body at a joint value, rad or m.
    pub fn placed_at(&self, q: f64) -> Isometry3<f64> {
        let moved = match self.kind {
            JointKind::Prismatic => Translation3::from(self.axis * q).into(),
            _ => Isometry3::rotation(self.axis * q),
        };
        self.X_PJ * moved
    }

    /// How far it slides at most, m: nothing where it turns.
    pub fn slide_m(&self) -> f64 {
        match self.kind {
            JointKind::Prismatic => self.lower.abs().max(self.upper.abs()),
            _ => 0.0,
        }
    }

    /// An upper bound of the distance of its frame from the parent body's, m.
    pub fn apart_m(&self) -> f64 {
        self.X_PJ.translation.vector.norm() + self.slide_m()
    }

    /// What is kept of the joint's limits where a margin is asked for, rad or m: of a joint without room
    /// for it a quarter of its range.
    pub fn kept_margin(&self, asked: f64) -> f64 {
        asked.min(0.25 * (self.upper - self.lower).max(0.0))
    }
}

/// A named frame: one for every link of the URDF, those on fixed joints included.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The link's name.
    pub name: String,
    /// The body it is fixed to.
    pub body: usize,
    /// The link's pose in that body.
    pub X_BL: Isometry3<f64>,
}
