//! What the robot stands on and may bump into.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Vector3};

/// A convex body of the simulated world.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldBody {
    /// Name, for reports.
    pub name: String,
    /// Its shape and place.
    pub shape: WorldShape,
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
    /// The same body moved by `shift_W`.
    pub fn shifted(mut self, shift_W: &Vector3<f64>) -> Self {
        match &mut self.shape {
            WorldShape::Box { X_WO, .. } => X_WO.translation.vector += shift_W,
            WorldShape::Hull(points) => points.iter_mut().for_each(|p| *p += shift_W),
        }
        self
    }

    /// How far a point is from the face that looks along `normal_W`, m: the distance to the
    /// body's support plane, plus how far the point lies beside the body's bounding box.
    pub fn face_distance_m(&self, p_W: &Vector3<f64>, normal_W: &Vector3<f64>) -> f64 {
        let corners = self.corners_W();
        let support = corners
            .iter()
            .map(|c| c.coords.dot(normal_W))
            .fold(f64::NEG_INFINITY, f64::max);
        let beside: f64 = (0..3)
            .map(|axis| {
                let (low, high) = corners
                    .iter()
                    .map(|c| c[axis])
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
                        (l.min(x), h.max(x))
                    });
                (low - p_W[axis]).max(p_W[axis] - high).max(0.0)
            })
            .sum();
        (p_W.dot(normal_W) - support).abs() + beside
    }

    /// Corners, or the points of the hull.
    pub fn corners_W(&self) -> Vec<Point3<f64>> {
        match &self.shape {
            WorldShape::Box { X_WO, half_m: h } => (0..8)
                .map(|corner| {
                    let sign = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
                    X_WO * Point3::new(sign(1) * h.x, sign(2) * h.y, sign(4) * h.z)
                })
                .collect(),
            WorldShape::Hull(points) => points.clone(),
        }
    }
}
