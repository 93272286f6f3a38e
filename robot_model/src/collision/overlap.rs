//! The least way out of overlap, by expanding a polytope: slower than EPA's usual case, and
//! certain where that goes astray.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};

use super::ShapeGeometry;
use super::closest::{Closest, separation};
use super::quickhull::{Facet, Growing};

/// Depths closer than this are one; m.
const ENOUGH_M: f64 = 1e-9;
/// Polyhedra need as many steps as the Minkowski difference has vertices nearby; the round sides
/// of coaxial cylinders, all equally near, are followed no further than this.
const GREATEST_STEPS: usize = 100;

/// The least translation that parts the cores of a and b, as a (negative) distance.
///
/// Grows the hull of points of a ⊖ b, facet nearest to the origin first, until no point of a ⊖ b
/// lies beyond that facet: the facet is then the boundary's nearest, its normal the way out.
/// Were the cores apart after all, the answer is a lower bound of their distance.
pub(super) fn deepest(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
) -> Closest {
    // The separation along n is −h(−n), h the support function of a ⊖ b: its point is p_a − p_b.
    let along = |n: &Vector3<f64>| separation(a, X_WA, b, X_WB, n);
    let mut best = Closest {
        distance: f64::NEG_INFINITY,
        ..along(&Vector3::z())
    };
    let mut pairs = Vec::new();
    for i in 0..27 {
        let n = Vector3::new(i % 3, i / 3 % 3, i / 9).map(|c| f64::from(c) - 1.0);
        let Some(n) = n.try_normalize(0.5) else {
            continue;
        };
        let reached = along(&n);
        if reached.distance > best.distance {
            best = reached;
        }
        pairs.push((reached.p_a_W, reached.p_b_W));
    }
    let difference = |(p, q): &(Point3<f64>, Point3<f64>)| Point3::from(p - q);
    let Ok(mut growing) = Growing::new(pairs.iter().map(difference).collect()) else {
        return best;
    };
    while let Some((facet, apex, _)) = growing.farthest() {
        if growing.add(facet, apex).is_err() {
            return best;
        }
    }
    for _ in 0..GREATEST_STEPS {
        let Some((nearest, weights)) = nearest(&growing) else {
            return best;
        };
        let facet = &growing.facets[nearest];
        let reached = along(&-facet.normal);
        if reached.distance > best.distance - ENOUGH_M {
            let (mut p_a_W, mut p_b_W) = (Vector3::zeros(), Vector3::zeros());
            for (&corner, weight) in facet.corners.iter().zip(weights.iter()) {
                p_a_W += pairs[corner].0.coords * *weight;
                p_b_W += pairs[corner].1.coords * *weight;
            }
            best = Closest {
                p_a_W: p_a_W.into(),
                p_b_W: p_b_W.into(),
                ..reached
            };
        }
        // −distance is how far a ⊖ b reaches beyond the origin along the facet's normal.
        if -reached.distance < facet.offset + ENOUGH_M {
            return best;
        }
        pairs.push((reached.p_a_W, reached.p_b_W));
        growing.points.push((reached.p_a_W - reached.p_b_W).into());
        let apex = growing.points.len() - 1;
        match growing.add(nearest, apex) {
            Ok(true) => {}
            Ok(false) | Err(_) => return best,
        }
    }
    best
}

/// The facet nearest to the origin, and the weights of its corners at its nearest point.
///
/// Of those equally near, the one that has the foot of the origin on its plane within itself.
fn nearest(growing: &Growing) -> Option<(usize, Vector3<f64>)> {
    let offsets = growing.facets.iter().map(|facet| facet.offset);
    let least = offsets.fold(f64::INFINITY, f64::min);
    let mut best: Option<(usize, Vector3<f64>)> = None;
    for (i, facet) in growing.facets.iter().enumerate() {
        if facet.offset > least + ENOUGH_M {
            continue;
        }
        let weights = foot(growing, facet);
        if best.is_none_or(|(_, other)| weights.min() > other.min()) {
            best = Some((i, weights));
        }
    }
    best.map(|(i, weights)| {
        let inside = weights.map(|w| w.clamp(0.0, 1.0));
        (i, inside / inside.sum())
    })
}

/// Weights of a facet's corners at the point of its plane nearest to the origin; they sum to
/// one, and one is negative where the point is outside of the facet.
fn foot(growing: &Growing, facet: &Facet) -> Vector3<f64> {
    let corners = facet.corners.map(|i| growing.points[i].coords);
    // Corners in a plane through the origin are dependent: lift everything off it.
    let lift = facet.normal * (1.0 - facet.offset);
    let columns = Matrix3::from_columns(&corners.map(|corner| corner + lift));
    let weights = columns.lu().solve(&facet.normal);
    weights.unwrap_or_else(|| Vector3::new(2.0, 2.0, -3.0))
}
