//! Convex polygons in a plane.

use nalgebra::{Point2, Vector2};

/// Distance of `p` from the lines through the edges of a convex counter-clockwise polygon, the
/// largest one counted: negative inside, where it is the distance from the boundary.
///
///   max_l  n_l·(p − a_l),   n_l the outward unit normal of the edge a_l b_l
///
/// Edges without a length are passed over; −∞ where there is no edge.
pub(crate) fn outside(polygon: &[Point2<f64>], p: &Point2<f64>) -> f64 {
    let heights = edges(polygon).filter_map(|(a, b)| height(&a, &b, p));
    heights.fold(f64::NEG_INFINITY, |worst, height| worst.max(-height))
}

/// Distance of the centroid from the nearest edge.
pub(crate) fn half_width(polygon: &[Point2<f64>]) -> f64 {
    -outside(polygon, &centroid(polygon))
}

/// How far to the left of an edge a point is, where the interior lies; none of an edge without a length.
fn height(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> Option<f64> {
    let along = (b - a).try_normalize(0.0)?;
    Some(along.perp(&(p - a)))
}

/// The corners of what is left of a convex counter-clockwise polygon that is taken back by a distance at every edge.
pub(crate) fn shrunk(polygon: &[Point2<f64>], by: f64) -> Vec<Point2<f64>> {
    let mut left = polygon.to_vec();
    for (a, b) in edges(polygon) {
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (p, next) in edges(&left) {
            let ends = height(&a, &b, &p).zip(height(&a, &b, &next));
            let (here, there) = ends.map_or((0.0, 0.0), |(here, there)| (here - by, there - by));
            if here >= 0.0 {
                kept.push(p);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(p + (next - p) * (here / (here - there)));
            }
        }
        left = kept;
    }
    left
}

/// The centroid of the area.
fn centroid(polygon: &[Point2<f64>]) -> Point2<f64> {
    let o = polygon.first().copied().unwrap_or_default();
    let (mut area, mut sum) = (0.0, Vector2::zeros());
    for (a, b) in edges(polygon) {
        let cross = (a - o).perp(&(b - o));
        area += cross;
        sum += ((a - o) + (b - o)) * cross;
    }
    o + sum / (3.0 * area)
}

/// The edges, the closing one included.
fn edges(polygon: &[Point2<f64>]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
    let next = polygon.iter().copied().cycle().skip(1);
    polygon.iter().copied().zip(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_have_the_right_sign_on_every_side() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(Point2::from);
        for (p, expected) in [
            ([1.0, 1.0], -1.0),
            ([1.0, 0.25], -0.25),
            ([1.0, -0.5], 0.5),
            ([2.5, 1.0], 0.5),
            ([1.0, 3.0], 1.0),
            ([-2.0, 1.0], 2.0),
        ] {
            assert_eq!(outside(&square, &p.into()), expected);
        }
    }

    #[test]
    fn the_centroid_of_a_triangle_is_its_mean() {
        let triangle = [[1.0, 1.0], [4.0, 1.0], [1.0, 7.0]].map(Point2::from);
        assert!((centroid(&triangle) - Point2::new(2.0, 3.0)).norm() < 1e-12);
    }
}
