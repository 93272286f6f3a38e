//! How two convex shapes lie to each other along a direction.

use nalgebra::{Isometry3, Point3, Vector3};

use super::ShapeGeometry;

/// The closest, or deepest, points of two shapes.
///
/// Frames: all in W.  Units: m.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Signed distance; negative on overlap.
    pub distance: f64,
    /// Unit normal from b toward a.
    pub normal_W: Vector3<f64>,
    /// Witness point on a.
    pub p_a_W: Point3<f64>,
    /// Witness point on b.
    pub p_b_W: Point3<f64>,
}

/// How far two shapes are apart along a unit vector n from b toward a, m: no more than their distance.
pub fn gap_m(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
    n: &Vector3<f64>,
) -> f64 {
    separation(a, X_WA, b, X_WB, n).distance - a.margin_m() - b.margin_m()
}

/// How far apart the cores are along n, negative on overlap.
pub(super) fn separation(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
    n: &Vector3<f64>,
) -> Closest {
    let p_a_W = X_WA * a.core_support(&(X_WA.rotation.inverse() * -n));
    let p_b_W = X_WB * b.core_support(&(X_WB.rotation.inverse() * n));
    Closest {
        distance: (p_a_W - p_b_W).dot(n),
        normal_W: *n,
        p_a_W,
        p_b_W,
    }
}
