//! The convex hull of points in the plane.

use nalgebra::Point2;

use super::{ConvexPolygon, FLAT_M, clean_ring, validate};
use crate::Error;

impl ConvexPolygon {
    /// The smallest convex polygon around the points, up to [`super::VERTEX_SEPARATION_M`].
    ///
    /// # Errors
    /// [`Error::Shape`]: fewer than 3 points, points beyond the world or on one line (also when all are at
    /// one place).
    /// Source: Andrew's monotone chain.
    pub fn hull(points: &[Point2<f64>]) -> Result<Self, Error> {
        Error::check_count(points.len())?;
        Error::check_in_world(points)?;
        // Left to right, then back: a vertex stays while the chain turns left at it.
        let mut sorted = points.to_vec();
        sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let mut ring: Vec<Point2<f64>> = Vec::with_capacity(points.len() + 1);
        for _ in 0..2 {
            let start = ring.len();
            for p in &sorted {
                while let [.., a, b] = &ring[start..] {
                    if (b - a).perp(&(p - b)) > 0.0 {
                        break;
                    }
                    ring.pop();
                }
                ring.push(*p);
            }
            // The last point of a chain is the first of the other one.
            ring.pop();
            sorted.reverse();
        }
        let ring = clean_ring(ring, FLAT_M);
        if ring.len() < 3 {
            // Too narrow for a polygon: say which point is the farthest from the line.
            validate::check_width(points)?;
        }
        Self::new(ring)
    }
}
