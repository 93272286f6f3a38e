//! The convex hull of a plane's points.

use nalgebra::Point2;
use surfaces::{ConvexPolygon, FACE_AREA_MIN_M2};

/// Most corners; corners are dropped, so that the hull only shrinks.
const VERTICES_MAX: usize = 16;
/// What the points do not tell of an edge, m.
pub(super) const INSET_M: f64 = 0.02;

/// The convex hull of the points, counter-clockwise; `None` if it is too small or has no area.
///
/// Source: [brossette2013] III-E. It covers what a concave face leaves open.
pub(super) fn hull(points: &[Point2<f64>]) -> Option<ConvexPolygon> {
    let polygon = ConvexPolygon::hull(points).ok()?;
    let polygon = polygon.simplified_inside(VERTICES_MAX);
    (polygon.area() >= FACE_AREA_MIN_M2).then_some(polygon)
}
