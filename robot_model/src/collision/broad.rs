//! Boxes around shapes: the cheap tests that spare most pairs the exact one.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

/// The bounding box of a shape at a pose, with the box along W's axes around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    centre: Point3<f64>,
    /// Axes of the shape's own box in W.
    axes: Matrix3<f64>,
    /// Half extents along those axes.
    half: Vector3<f64>,
    /// Half extents along W's axes.
    reach: Vector3<f64>,
}

impl Bounds {
    /// The box (centre and half extents in G) whose frame G is at `X_WG`.
    pub(crate) fn around(
        (centre_G, half_G): &(Point3<f64>, Vector3<f64>),
        X_WG: &Isometry3<f64>,
    ) -> Self {
        let axes = X_WG.rotation.to_rotation_matrix().into_inner();
        Bounds {
            centre: X_WG * centre_G,
            axes,
            half: *half_G,
            reach: axes.abs() * half_G,
        }
    }

    /// The lowest and the highest corner of the box along W's axes.
    pub(crate) fn corners(&self) -> (Point3<f64>, Point3<f64>) {
        (self.centre - self.reach, self.centre + self.reach)
    }

    /// The distance of a point of W from the box, m; 0 inside.
    pub(crate) fn distance_m(&self, point: &Point3<f64>) -> f64 {
        let outside = self.axes.tr_mul(&(point - self.centre)).abs() - self.half;
        outside.map(|x| x.max(0.0)).norm()
    }

    /// Whether no point of the one is within `distance_m` of a point of the other, as far as
    /// boxes can tell: along W's axes first, then along the axes of either box.
    pub(crate) fn is_farther_than(&self, other: &Self, distance_m: f64) -> bool {
        // Overlapping boxes are never far; a negative bound on the distance asks for overlap.
        let distance_m = distance_m.max(0.0);
        let apart = self.centre - other.centre;
        let gap = (apart.abs() - self.reach - other.reach).map(|g| g.max(0.0));
        if gap.norm_squared() > distance_m.powi(2) {
            return true;
        }
        let between = self.axes.tr_mul(&other.axes).abs();
        let along_own = self.axes.tr_mul(&apart).abs() - self.half - between * other.half;
        let along_other = other.axes.tr_mul(&apart).abs() - other.half - between.tr_mul(&self.half);
        let gap = |g: Vector3<f64>| g.map(|g| g.max(0.0)).norm_squared();
        gap(along_own).max(gap(along_other)) > distance_m.powi(2)
    }
}
