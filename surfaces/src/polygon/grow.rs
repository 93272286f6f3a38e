//! The polygon widened.

use nalgebra::{Point2, Vector2};

use super::ConvexPolygon;

/// Corners whose widened tip would be farther than this many times the distance are cut off.
const TIP_MAX: f64 = 2.0;

impl ConvexPolygon {
    /// A polygon that holds every point within `d_m` of this one; the polygon itself where `d_m`
    /// is not positive or not finite.
    ///
    /// Edges move out by `d_m`; sharp corners are cut off outside that distance.
    pub fn grown(&self, d_m: f64) -> Self {
        if !(d_m > 0.0 && d_m.is_finite()) {
            return self.clone();
        }
        let edges: Vec<Vector2<f64>> = self.edges().map(|(a, b)| (b - a).normalize()).collect();
        let out = |along: &Vector2<f64>| Vector2::new(along.y, -along.x);
        let mut points: Vec<Point2<f64>> = Vec::with_capacity(2 * edges.len());
        for (i, vertex) in self.vertices.iter().enumerate() {
            let (before, after) = (edges[(i + edges.len() - 1) % edges.len()], edges[i]);
            let (n, m) = (out(&before), out(&after));
            let open = 1.0 + n.dot(&m);
            // The tip is √(2 / (1 + n·m)) times the distance away.
            if 2.0 <= TIP_MAX * TIP_MAX * open {
                points.push(vertex + (n + m) * (d_m / open));
            } else {
                points.push(vertex + (n + before) * d_m);
                points.push(vertex + (m - after) * d_m);
            }
        }
        Self::hull(&points).unwrap_or_else(|_| self.clone())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::polygons;
    use super::*;

    proptest! {
        #[test]
        fn it_holds_what_is_near_and_little_else(polygon in polygons(), d in 0.001..0.2) {
            let grown = polygon.grown(d);
            let size = polygon.radius_about(&polygon.vertices()[0]);
            for v in polygon.vertices() {
                for k in 0..32 {
                    let (sin, cos) = (f64::from(k) * 0.19635).sin_cos();
                    let p = v + Vector2::new(cos, sin) * d;
                    prop_assert!(grown.contains(&p, 1e-7 * (1.0 + size)));
                }
            }
            for v in grown.vertices() {
                let far = polygon.vertices().iter().map(|w| (v - w).norm());
                prop_assert!(far.fold(f64::INFINITY, f64::min) <= TIP_MAX * d * 1.001);
            }
        }
    }
}
