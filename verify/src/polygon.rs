//! Points and convex polygons in a plane.

/// Distance of `p` from the lines through the edges of a convex counter-clockwise polygon, the
/// largest one counted: negative inside, where it is the distance from the boundary.
///
///   max_l  n_l·(p − a_l),   n_l the outward unit normal of the edge a_l b_l
///
/// Edges without a length are passed over; −∞ where there is no edge.
pub(crate) fn outside(polygon: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    for (a, b) in edges(polygon) {
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let length = ex.hypot(ey);
        if length > 0.0 {
            // The interior is on the left of the edge, (ey, −ex) points to the right.
            worst = worst.max((ey * (p[0] - a[0]) - ex * (p[1] - a[1])) / length);
        }
    }
    worst
}

/// The corners of what is left of a convex counter-clockwise polygon that is taken back by a distance at every edge.
pub(crate) fn shrunk(polygon: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
    let mut left = polygon.to_vec();
    for (a, b) in edges(polygon) {
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let length = ex.hypot(ey);
        if length <= 0.0 {
            continue;
        }
        let inside = |p: &[f64; 2]| (ex * (p[1] - a[1]) - ey * (p[0] - a[0])) / length - by;
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (p, next) in edges(&left) {
            let (here, there) = (inside(&p), inside(&next));
            if here >= 0.0 {
                kept.push(p);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let part = here / (here - there);
                kept.push([0, 1].map(|k| p[k] + part * (next[k] - p[k])));
            }
        }
        left = kept;
    }
    left
}

/// The centroid of the area.
pub(crate) fn centroid(polygon: &[[f64; 2]]) -> [f64; 2] {
    let Some(&o) = polygon.first() else {
        return [f64::NAN; 2];
    };
    let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
    for (a, b) in edges(polygon) {
        let (ax, ay) = (a[0] - o[0], a[1] - o[1]);
        let (bx, by) = (b[0] - o[0], b[1] - o[1]);
        let cross = ax * by - ay * bx;
        area += cross;
        x += cross * (ax + bx);
        y += cross * (ay + by);
    }
    [o[0] + x / (3.0 * area), o[1] + y / (3.0 * area)]
}

/// The edges, the closing one included.
fn edges(polygon: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    let next = polygon.iter().copied().cycle().skip(1);
    polygon.iter().copied().zip(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn distances_have_the_right_sign_on_every_side() {
        assert_eq!(outside(&SQUARE, [1.0, 1.0]), -1.0);
        assert_eq!(outside(&SQUARE, [1.0, 0.25]), -0.25);
        for (p, expected) in [
            ([1.0, -0.5], 0.5),
            ([2.5, 1.0], 0.5),
            ([1.0, 3.0], 1.0),
            ([-2.0, 1.0], 2.0),
        ] {
            assert_eq!(outside(&SQUARE, p), expected);
        }
    }

    #[test]
    fn the_centroid_of_a_triangle_is_its_mean() {
        let c = centroid(&[[1.0, 1.0], [4.0, 1.0], [1.0, 7.0]]);
        assert!((c[0] - 2.0).abs() < 1e-12 && (c[1] - 3.0).abs() < 1e-12);
    }
}
