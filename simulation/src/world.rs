//! What the robot stands on and may bump into.

use nalgebra::{Isometry3, Point3, Vector3};

/// A convex body of the simulated world.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldBody {
    /// Name, for reports.
    pub name: String,
    /// The thing that it is a part of: its parts are displaced as one.
    pub part_of: String,
    /// Its shape and place.
    pub shape: WorldShape,
    /// Coefficient of friction that it has at most with the robot; without one the robot's count.
    pub friction: Option<f64>,
}

/// The shape of a body of the world.
#[derive(Clone, Debug, PartialEq)]
pub enum WorldShape {
    /// A solid box.
    Box {
        /// Pose of its centre and axes in W.
        X_WO: Isometry3<f64>,
        /// Half edge lengths, m.
        half_m: Vector3<f64>,
    },
    /// The hull of points in W, m.
    Hull(Vec<Point3<f64>>),
}

impl WorldBody {
    /// Moves the body as a motion in W does.
    pub fn transform(&mut self, motion_W: &Isometry3<f64>) {
        match &mut self.shape {
            WorldShape::Box { X_WO, .. } => *X_WO = motion_W * *X_WO,
            WorldShape::Hull(points) => points.iter_mut().for_each(|p| *p = motion_W * *p),
        }
    }

    /// How far a point is from the face that looks along `normal_W`, m: the distance to the
    /// body's support plane, plus how far the point lies beside the body's bounding box.
    pub fn face_distance_m(&self, p_W: &Vector3<f64>, normal_W: &Vector3<f64>) -> f64 {
        let corners = self.corners_W();
        let most = |along: &Vector3<f64>| {
            let heights = corners.iter().map(|c| c.coords.dot(along));
            heights.fold(f64::NEG_INFINITY, f64::max)
        };
        let beyond = |along: &Vector3<f64>| (p_W.dot(along) - most(along)).max(0.0);
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let beside: f64 = axes.iter().map(|axis| beyond(axis) + beyond(&-axis)).sum();
        (p_W.dot(normal_W) - most(normal_W)).abs() + beside
    }

    /// Corners, or the points of the hull.
    pub fn corners_W(&self) -> Vec<Point3<f64>> {
        match &self.shape {
            WorldShape::Box { X_WO, half_m: h } => {
                let corner = |k: usize| {
                    let sign = |bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
                    X_WO * Point3::new(sign(1) * h.x, sign(2) * h.y, sign(4) * h.z)
                };
                (0..8).map(corner).collect()
            }
            WorldShape::Hull(points) => points.clone(),
        }
    }
}
