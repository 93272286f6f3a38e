//! Where every body of a robot is at a configuration, and how that changes with it.
//!
//! The velocity is v = [v_B, ω_B, joint rates…] with v_B (of B's origin) and ω_B in W, so that
//! the Jacobians here are the derivatives along
//! [`Configuration::integrate`](crate::Configuration::integrate).

mod gravity;
mod jacobian;
mod reach;

pub use reach::{PointTarget, reach};

use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};

use crate::{Configuration, ContactPatch, Error, Frame, JointKind, Robot};

/// Poses, joint axes and centres of mass of a robot at one configuration.
///
/// Shapes: every vector has an entry a body.  Units: m, kg.  Frames: all in W.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// Pose of each body.
    pub X_WB: Vec<Isometry3<f64>>,
    /// Unit joint axis of each body; zero for the base.
    pub axis_W: Vec<Vector3<f64>>,
    /// Origin of each body (a point on its joint's axis).
    pub origin_W: Vec<Vector3<f64>>,
    /// Centre of mass of the robot.
    pub com_W: Vector3<f64>,
    /// Mass that each body's joint carries.
    pub subtree_mass: Vec<f64>,
    /// Centre of mass of what each body's joint carries (its origin where that is massless).
    pub subtree_com_W: Vec<Vector3<f64>>,
}

impl Kinematics {
    /// The kinematics of `robot` at `configuration`.
    pub fn new(robot: &Robot, configuration: &Configuration) -> Self {
        let n = robot.bodies.len();
        let mut subtree_mass: Vec<f64> = robot.bodies.iter().map(|b| b.mass_kg).collect();
        for (i, body) in robot.bodies.iter().enumerate().rev() {
            if let Some(parent) = body.parent {
                subtree_mass[parent] += subtree_mass[i];
            }
        }
        let mut kinematics = Kinematics {
            X_WB: vec![Isometry3::identity(); n],
            axis_W: vec![Vector3::zeros(); n],
            origin_W: vec![Vector3::zeros(); n],
            com_W: Vector3::zeros(),
            subtree_mass,
            subtree_com_W: vec![Vector3::zeros(); n],
        };
        kinematics.update(robot, configuration);
        kinematics
    }

    /// Moves to another configuration of the same robot, without allocating.
    ///
    ///   X_WB = X_WP X_PJ motion(axis, q)
    pub fn update(&mut self, robot: &Robot, configuration: &Configuration) {
        assert_eq!(configuration.joints.len(), robot.nj(), "one value a joint");
        // Outward: poses and axes.
        for (i, body) in robot.bodies.iter().enumerate() {
            let X_WB = match body.parent {
                None => configuration.X_WB(),
                Some(parent) => {
                    let X_WJ = self.X_WB[parent] * body.X_PJ;
                    let axis_W = X_WJ.rotation * body.axis;
                    self.axis_W[i] = axis_W;
                    let q = configuration.joints[i - 1];
                    let mut X_WB = X_WJ;
                    if body.kind == JointKind::Prismatic {
                        X_WB.translation.vector += axis_W * q;
                    } else {
                        let axis = Unit::new_unchecked(body.axis);
                        X_WB.rotation *= UnitQuaternion::from_axis_angle(&axis, q);
                    }
                    X_WB
                }
            };
            self.X_WB[i] = X_WB;
            self.origin_W[i] = X_WB.translation.vector;
            let com_W = X_WB.rotation * body.com_B + X_WB.translation.vector;
            self.subtree_com_W[i] = com_W * body.mass_kg;
        }
        // Inward: first moments, then means.
        for (i, body) in robot.bodies.iter().enumerate().rev() {
            let moment = self.subtree_com_W[i];
            if let Some(parent) = body.parent {
                self.subtree_com_W[parent] += moment;
            }
            let mass = self.subtree_mass[i];
            self.subtree_com_W[i] = if mass > 0.0 {
                moment / mass
            } else {
                self.origin_W[i]
            };
        }
        self.com_W = self.subtree_com_W[0];
    }

    /// Pose of a link's frame.
    pub fn X_WF(&self, frame: &Frame) -> Isometry3<f64> {
        self.X_WB[frame.body] * frame.X_BL
    }

    /// Pose of a contact patch.
    pub fn X_WC(&self, patch: &ContactPatch) -> Isometry3<f64> {
        self.X_WB[patch.body] * patch.X_BC
    }

    /// Pose of the link of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] listing the nearest names.
    pub fn X_WL(&self, robot: &Robot, link: &str) -> Result<Isometry3<f64>, Error> {
        Ok(self.X_WF(robot.frame(link)?))
    }
}
