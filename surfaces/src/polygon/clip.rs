//! Cutting convex polygons with half planes and with each other.

use nalgebra::{Point2, Vector2};

use super::{ConvexPolygon, HalfPlane, VERTEX_SEPARATION_M};

impl ConvexPolygon {
    /// The part of the polygon in a half plane; None when nothing with an area is left.
    pub fn clip(&self, half_plane: &HalfPlane) -> Option<Self> {
        if self.vertices.iter().all(|v| half_plane.value(v) <= 0.0) {
            return Some(self.clone());
        }
        Self::from_ring(clip_ring(&self.vertices, half_plane))
    }

    /// The common part of two polygons; None when they share no area.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        self.clip_all(&other.half_planes())
    }

    /// The part of the polygon in all of the half planes; None when nothing with an area is left.
    pub fn clip_all(&self, half_planes: &[HalfPlane]) -> Option<Self> {
        let mut ring = self.vertices.clone();
        let mut cut = false;
        for half_plane in half_planes {
            if ring.iter().all(|v| half_plane.value(v) <= 0.0) {
                continue;
            }
            ring = clip_ring(&ring, half_plane);
            cut = true;
        }
        if cut {
            Self::from_ring(ring)
        } else {
            Some(self.clone())
        }
    }
}

/// The part of a convex ring in a half plane, possibly with repeated vertices, possibly empty.
///
/// Source: one step of Sutherland and Hodgman's clipping.
pub(crate) fn clip_ring(ring: &[Point2<f64>], half_plane: &HalfPlane) -> Vec<Point2<f64>> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    let Some(mut a) = ring.last() else {
        return kept;
    };
    let mut value_a = half_plane.value(a);
    for b in ring {
        let value_b = half_plane.value(b);
        // The crossing point of an edge that changes sides, then the end of an edge inside.
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            kept.push(a + (b - a) * (value_a / (value_a - value_b)));
        }
        if value_b <= 0.0 {
            kept.push(*b);
        }
        (a, value_a) = (b, value_b);
    }
    kept
}

/// The signed area of a ring, positive when it runs counter-clockwise, m².
pub(crate) fn ring_area(ring: &[Point2<f64>]) -> f64 {
    let Some(origin) = ring.first() else {
        return 0.0;
    };
    let fan = ring.windows(2);
    0.5 * fan
        .map(|edge| (edge[0] - origin).perp(&(edge[1] - origin)))
        .sum::<f64>()
}

/// The centroid of the area inside edges, a ring's or those of a region, m; there is one at least.
pub(crate) fn centroid<'a>(edges: impl Iterator<Item = [&'a Point2<f64>; 2]>) -> Point2<f64> {
    let mut edges = edges.peekable();
    // Relative to a vertex, so that what is far from the origin loses no digits.
    let origin = edges.peek().map_or_else(Point2::origin, |[a, _]| **a);
    let (mut sum, mut doubled_area) = (Vector2::zeros(), 0.0);
    for [a, b] in edges {
        let (a, b) = (a - origin, b - origin);
        let cross = a.perp(&b);
        sum += (a + b) * cross;
        doubled_area += cross;
    }
    origin + sum / (3.0 * doubled_area)
}

/// A ring without repeated vertices and without vertices nearer than `flat_m` to the line through
/// their neighbours.
///
/// Vertices are only dropped, so a convex ring can only shrink.
pub(crate) fn clean_ring(mut ring: Vec<Point2<f64>>, flat_m: f64) -> Vec<Point2<f64>> {
    let mut i = 0;
    let mut steps_without_change = 0;
    while ring.len() >= 3 && steps_without_change < ring.len() {
        let count = ring.len();
        i %= count;
        let (before, here, after) = (
            ring[(i + count - 1) % count],
            ring[i],
            ring[(i + 1) % count],
        );
        let chord = after - before;
        let repeated = (here - before).norm() < VERTEX_SEPARATION_M;
        let flat = chord.perp(&(here - before)).abs() <= flat_m * chord.norm();
        if repeated || flat {
            ring.remove(i);
            steps_without_change = 0;
        } else {
            i += 1;
            steps_without_change += 1;
        }
    }
    ring
}
