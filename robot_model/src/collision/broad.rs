//! Boxes along W's axes: the cheap test that spares most pairs the exact one.

use nalgebra::{Isometry3, Point3, Vector3};

/// A box along W's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    centre: Point3<f64>,
    half: Vector3<f64>,
}

impl Aabb {
    /// The box around a box (centre and half extents in G) whose frame G is at `X_WG`.
    #[allow(non_snake_case)]
    pub(crate) fn around(
        (centre_G, half_G): &(Point3<f64>, Vector3<f64>),
        X_WG: &Isometry3<f64>,
    ) -> Self {
        let R_WG = X_WG.rotation.to_rotation_matrix();
        let reach = R_WG.matrix().abs() * half_G;
        Aabb {
            centre: X_WG * centre_G,
            half: reach,
        }
    }

    /// Whether no point of the one is within `distance_m` of a point of the other.
    pub(crate) fn is_farther_than(&self, other: &Self, distance_m: f64) -> bool {
        let gap = (self.centre - other.centre).abs() - self.half - other.half;
        let gap = gap.map(|g| g.max(0.0));
        // Overlapping boxes are never far; a negative bound on the distance asks for overlap.
        gap.norm_squared() > distance_m.max(0.0).powi(2)
    }
}
