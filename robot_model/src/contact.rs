//! Where a robot may touch the world.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point2};

/// A flat convex patch of a robot's link that may bear contact.
///
/// Frame C: its origin in the patch's plane, z_C **outward from the environment** (for a sole on
/// the ground: up, into the robot). The contact holds when C lies in a surface's plane with
/// z_C = +z_S and the polygon lies inside the surface's polygon.
#[derive(Clone, Debug)]
pub struct ContactPatch {
    /// The patch's name, unique in the robot.
    pub name: String,
    /// The link it is given on.
    pub link: String,
    /// The body that link is lumped into.
    pub body: usize,
    /// Pose of C in that body.
    pub X_BC: Isometry3<f64>,
    /// Strictly convex vertices in C, counter-clockwise about z_C; m.
    pub polygon: Vec<Point2<f64>>,
    /// What the patch may do: "foot", "hand", ….
    pub roles: Vec<String>,
    /// Coulomb friction coefficient of the patch.
    pub friction: f64,
}

impl ContactPatch {
    /// Whether the patch may take this role.
    pub fn has_role(&self, role: &str) -> bool {
        self.roles.iter().any(|r| r == role)
    }
}
