//! The point of a convex body that is nearest to the origin, from its support points alone.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// What is known of the distance of the origin from a body.
pub(crate) struct Nearest {
    /// The nearest point found.
    pub point: Vector3<f64>,
    /// No point of the body is nearer than this; zero where the origin may be inside.
    pub at_least: f64,
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
/// agree. `support(d)` is a point of the body farthest along d.
pub(crate) fn to_origin(
    support: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    start: &Vector3<f64>,
) -> Nearest {
    let mut corral = vec![support(start)];
    let mut found = Nearest {
        point: Vector3::zeros(),
        at_least: 0.0,
    };
    for _ in 0..STEPS {
        let (v, kept) = nearest_of_hull(&corral);
        corral = kept;
        found.point = v;
        let length = v.norm();
        if length < 1e-14 {
            found.at_least = 0.0;
            return found;
        }
        let w = support(&-v);
        found.at_least = found.at_least.max(w.dot(&v) / length);
        // Done where the bounds agree, or where rounding brings nothing new.
        if length - found.at_least <= AGREED * length || corral.contains(&w) {
            return found;
        }
        corral.push(w);
    }
    found
}

/// The nearest point of the hull of one to four points, and those of them that span it.
///
/// Of all their subsets: the nearest point of the flat through each counts where it lies in the
/// subset's hull.
fn nearest_of_hull(points: &[Vector3<f64>]) -> (Vector3<f64>, Vec<Vector3<f64>>) {
    let mut best: Option<(f64, Vector3<f64>, Vec<Vector3<f64>>)> = None;
    for bits in 1..1_u32 << points.len().min(4) {
        let subset = points.iter().enumerate();
        let subset = subset
            .filter(|(k, _)| bits & (1 << k) != 0)
            .map(|(_, p)| *p);
        let subset: Vec<Vector3<f64>> = subset.collect();
        if let Some(v) = foot_in_hull(&subset) {
            let shortest = best.as_ref().map_or(f64::INFINITY, |best| best.0);
            if v.norm_squared() < shortest {
                best = Some((v.norm_squared(), v, subset));
            }
        }
    }
    match best {
        Some((_, v, subset)) => (v, subset),
        None => (Vector3::zeros(), points.to_vec()),
    }
}

/// The foot of the perpendicular from the origin on the flat through the points, where it lies in
/// their hull.
fn foot_in_hull(points: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let (&p, rest) = points.split_first()?;
    let edges: Vec<Vector3<f64>> = rest.iter().map(|q| q - p).collect();
    // (EᵀE) λ = −Eᵀp
    let weights: Vec<f64> = match *edges.as_slice() {
        [] => Vec::new(),
        [e] => vec![-e.dot(&p) / e.norm_squared()],
        [e, f] => {
            let gram = Matrix2::new(e.dot(&e), e.dot(&f), e.dot(&f), f.dot(&f));
            let solved = gram.lu().solve(&Vector2::new(-e.dot(&p), -f.dot(&p)))?;
            solved.iter().copied().collect()
        }
        [e, f, g] => {
            let solved = Matrix3::from_columns(&[e, f, g]).lu().solve(&-p)?;
            solved.iter().copied().collect()
        }
        _ => return None,
    };
    let inside = weights.iter().all(|x| *x >= 0.0) && weights.iter().sum::<f64>() <= 1.0;
    let along = edges.iter().zip(&weights).map(|(e, x)| e * *x);
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
        to_origin(support, &Vector3::x())
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
