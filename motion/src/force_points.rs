//! Where contact forces act: the vertices of the patch, shrunk by the margin of the centre of mass.

use nalgebra::{Point2, Vector2};
use surfaces::ConvexPolygon;

/// Largest part of the patch's half width that the margin may take.
const PART_MAX: f64 = 0.6;

/// The points of a patch at which its forces act, in C, m: the polygon shrunk by `inset_m`, at
/// most to 40 % of its half width. A patch that is no polygon keeps its points.
///
/// These are the points of a plan's `force_points_W` and of a motion's `forces_W`, in that order.
pub fn force_points(polygon: &[Point2<f64>], inset_m: f64) -> Vec<Point2<f64>> {
    let Ok(patch) = ConvexPolygon::new(polygon.to_vec()) else {
        return polygon.to_vec();
    };
    let c: Vector2<f64> = patch.centroid().coords;
    let half_width = patch
        .half_planes()
        .iter()
        .map(|edge| edge.b - edge.n.dot(&c))
        .fold(f64::MAX, f64::min);
    patch
        .inset(inset_m.min(PART_MAX * half_width))
        .map_or_else(|| polygon.to_vec(), |p| p.vertices().to_vec())
}
