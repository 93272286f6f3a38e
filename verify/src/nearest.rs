//! The point of a convex body that is nearest to the origin, from its support points alone.

use nalgebra::Vector3;

/// What is known of the distance of the origin from a body.
pub(crate) struct Nearest {
    /// The nearest point found.
    pub point: Vector3<f64>,
    /// No point of the body is nearer than this; zero where the origin may be inside.
    pub at_least: f64,
    /// The direction along which no point is nearer than that.
    pub along: Vector3<f64>,
}

/// Support points that are asked for at most; polytopes take about ten, round bodies some tens.
const STEPS: usize = 200;

/// Bounds that agree to this part are the distance.
const AGREED: f64 = 1e-12;

/// Nearest point by Wolfe's scheme: the nearest point v of the hull of at most four support
/// points, then the support point w against v, until
///
///   w·v/|v|  ≤  distance  ≤  |v|
///
/// agree, or the distance is known to be more than `enough`. `support(d)` is a point of the body
/// farthest along d.
pub(crate) fn to_origin(
    support: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    start: &Vector3<f64>,
    enough: f64,
) -> Nearest {
    let mut corral = Corral::default();
    corral.add(support(start));
    let mut found = Nearest {
        point: Vector3::zeros(),
        at_least: 0.0,
        along: Vector3::zeros(),
    };
    let mut length = f64::INFINITY;
    for _ in 0..STEPS {
        let v = corral.reduce();
        // Rounding brings nothing nearer.
        if v.norm() >= length {
            return found;
        }
        found.point = v;
        length = v.norm();
        if length < 1e-14 {
            found.at_least = 0.0;
            return found;
        }
        let w = support(&-v);
        let least = w.dot(&v) / length;
        if least > found.at_least {
            (found.at_least, found.along) = (least, v / length);
        }
        // Done where the bounds agree, or where rounding brings nothing new.
        let agreed = length - found.at_least <= AGREED * length;
        if agreed || found.at_least > enough || corral.points().contains(&w) {
            return found;
        }
        corral.add(w);
    }
    found
}

/// At most four points, the last one the newest.
#[derive(Default)]
struct Corral {
    points: [Vector3<f64>; 4],
    count: usize,
}

impl Corral {
    fn points(&self) -> &[Vector3<f64>] {
        &self.points[..self.count]
    }

    fn add(&mut self, point: Vector3<f64>) {
        // Four that surround the origin are at no distance and never added to.
        let at = self.count.min(3);
        self.points[at] = point;
        self.count = at + 1;
    }

    /// The nearest point of the points' hull; keeps those of them that span it.
    ///
    /// Of the subsets that hold the newest point, without which the hull was the one before: the
    /// nearest point of the flat through each counts where it lies in the subset's hull.
    fn reduce(&mut self) -> Vector3<f64> {
        let Some((newest, others)) = self.points().split_last() else {
            return Vector3::zeros();
        };
        let mut best = (newest.norm_squared(), *newest, 0_usize);
        for bits in 1..1_usize << others.len() {
            let mut edges = [Vector3::zeros(); 3];
            let mut count = 0;
            for (k, point) in others.iter().enumerate() {
                if bits & (1 << k) != 0 {
                    edges[count] = point - newest;
                    count += 1;
                }
            }
            if let Some(v) = foot_in_hull(newest, &edges[..count])
                && v.norm_squared() < best.0
            {
                best = (v.norm_squared(), v, bits);
            }
        }
        let (_, v, bits) = best;
        let (mut kept, newest) = (0, *newest);
        for k in 0..self.count - 1 {
            if bits & (1 << k) != 0 {
                self.points[kept] = self.points[k];
                kept += 1;
            }
        }
        self.points[kept] = newest;
        self.count = kept + 1;
        v
    }
}

/// The foot of the perpendicular from the origin on the flat through a point along edges, where it
/// lies in the hull of the point and the edges' ends.
fn foot_in_hull(p: &Vector3<f64>, edges: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    // (EᵀE) λ = −Eᵀp by Cramer's rule, kept over its determinant.
    let (weights, size) = match edges {
        [e] => ([-e.dot(p), 0.0, 0.0], e.norm_squared()),
        [e, f] => {
            let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
            let (a, b) = (-e.dot(p), -f.dot(p));
            ([a * ff - b * ef, b * ee - a * ef, 0.0], ee * ff - ef * ef)
        }
        [e, f, g] => {
            let fg = f.cross(g);
            let size = e.dot(&fg);
            let pe = p.cross(e);
            let solved = [-p.dot(&fg), g.dot(&pe), -f.dot(&pe)];
            (solved.map(|x| x * size.signum()), size.abs())
        }
        _ => return None,
    };
    let inside =
        size > 0.0 && weights.iter().all(|x| *x >= 0.0) && weights.iter().sum::<f64>() <= size;
    let along = edges.iter().zip(weights).map(|(e, x)| e * (x / size));
    inside.then(|| p + along.sum::<Vector3<f64>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearest(points: &[[f64; 3]]) -> Nearest {
        let points: Vec<Vector3<f64>> = points.iter().map(|p| Vector3::from(*p)).collect();
        let support = |d: &Vector3<f64>| {
            let farthest = points.iter().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d)));
            *farthest.unwrap()
        };
        to_origin(support, &Vector3::x(), f64::INFINITY)
    }

    #[test]
    fn corners_edges_and_faces() {
        #[rustfmt::skip]
        let bodies: [(&[[f64; 3]], [f64; 3]); 3] = [
            (&[[1.0, 2.0, 2.0], [3.0, 3.0, 3.0], [1.0, 4.0, 5.0], [2.0, 2.0, 4.0]], [1.0, 2.0, 2.0]),
            (&[[1.0, -1.0, 0.0], [1.0, 2.0, 0.0], [2.0, 0.0, 1.0]], [1.0, 0.0, 0.0]),
            (&[[-1.0, -1.0, 2.0], [2.0, -1.0, 2.0], [0.0, 2.0, 2.0], [0.0, 0.0, 5.0]], [0.0, 0.0, 2.0]),
        ];
        for (points, expected) in bodies {
            let (found, expected) = (nearest(points), Vector3::from(expected));
            assert!((found.point - expected).norm() < 1e-12);
            assert!(found.at_least > expected.norm() - 1e-9);
        }
    }

    #[test]
    fn inside_is_at_no_distance() {
        let below = [[-1.0, -1.0], [2.0, -1.0], [0.0, 2.0]].map(|[x, y]| [x, y, -1.0]);
        let inside = nearest(&[&below[..], &[[0.0, 0.0, 5.0]]].concat());
        assert!(inside.at_least <= 0.0 && inside.point.norm() < 1e-12);
    }
}
