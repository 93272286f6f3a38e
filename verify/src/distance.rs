//! Signed distances between convex bodies, each vouched for by a separating direction.
//!
//! For any unit d, the gap between two bodies along d is not more than their signed distance:
//!
//!   min_{p ∈ b} d·p − max_{p ∈ a} d·p  ≤  dist(a, b),   equal at the best d
//!
//! The search for the best direction is this module's own where they are apart and EPA's where they
//! overlap; the value is the gap itself.

use nalgebra::Vector3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};

use crate::nearest;
use crate::solid::{Placed, vector};

/// Bodies nearer than this are taken to touch: EPA and the given directions then decide, m.
const APART_M: f64 = 1e-9;

/// The gap between two bodies along a unit direction from `a` to `b`, m: their distance is not less.
pub(crate) fn gap(a: &Placed, b: &Placed, along: &Vector3<f64>) -> f64 {
    let apart = b.farthest(&-along).dot(along) - a.farthest(along).dot(along);
    apart - a.radius() - b.radius()
}

/// The signed distance, m, and the direction from `a` to `b` that vouches for it: negative where the
/// bodies overlap, by how far they would have to be moved apart.
///
/// Never more than the true one: the gap along a direction. Apart, the direction is the best there
/// is, or the first that gives more than `enough`; overlapping, the best of EPA's, of `hints` and of
/// the axes.
pub(crate) fn signed_distance(
    a: &Placed,
    b: &Placed,
    hints: &[Vector3<f64>],
    enough: f64,
) -> (f64, Vector3<f64>) {
    let inflation = a.radius() + b.radius();
    // Points of b less points of a.
    let support = |d: &Vector3<f64>| b.farthest(d) - a.farthest(&-d);
    let between = b.ball().0 - a.ball().0;
    let start = hints.first().copied().unwrap_or(between);
    let nearest = nearest::to_origin(support, &-start, enough + inflation);
    if nearest.at_least > APART_M {
        return (nearest.at_least - inflation, nearest.along);
    }
    let axes = [Vector3::x(), Vector3::y(), Vector3::z(), between];
    let directions = hints.iter().copied().chain(axes).flat_map(|d| [d, -d]);
    let mut best = (f64::NEG_INFINITY, Vector3::zeros());
    let mut take = |d: Vector3<f64>| {
        if let Some(d) = d.try_normalize(0.0) {
            let found = gap(a, b, &d);
            if found > best.0 {
                best = (found, d);
            }
        }
        best.0
    };
    for d in directions {
        if take(d) > enough {
            return best;
        }
    }
    if let Some(d) = way_out(a, b, &between) {
        take(d);
    }
    best
}

/// A distance that two bodies are not farther apart than, m: that of two of their points.
pub(crate) fn apart_at_most_m(a: &Placed, b: &Placed) -> f64 {
    let support = |d: &Vector3<f64>| b.farthest(d) - a.farthest(&-d);
    let between = b.ball().0 - a.ball().0;
    let nearest = nearest::to_origin(support, &-between, f64::INFINITY);
    nearest.point.norm() - a.radius() - b.radius()
}

/// The direction in which EPA finds the least overlap.
fn way_out(a: &Placed, b: &Placed, start: &Vector3<f64>) -> Option<Vector3<f64>> {
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    let start = vector(start).try_normalize().unwrap_or(Vector::X);
    simplex.reset(CsoPoint::from_shapes(&here, a, b, start));
    let normal = match closest_points(&here, a, b, f64::MAX, true, &mut simplex) {
        GJKResult::Intersection => EPA::new()
            .closest_points(&here, a, b, &simplex)
            .map(|(_, _, normal)| normal),
        GJKResult::ClosestPoints(_, _, normal)
        | GJKResult::Proximity(normal)
        | GJKResult::NoIntersection(normal) => Some(normal),
    };
    normal.map(|n| Vector3::new(n.x, n.y, n.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Solid;

    fn cube(centre: [f64; 3], half: f64) -> Solid {
        let c = Vector3::from(centre);
        let corners = (0..8).map(|k| {
            let sign = |bit: usize| if k & bit == 0 { -half } else { half };
            c + Vector3::new(sign(1), sign(2), sign(4))
        });
        Solid::hull(corners, 0.0)
    }

    #[track_caller]
    fn apart(a: &Solid, b: &Solid, expected: f64) {
        for (a, b) in [(a, b), (b, a)] {
            let (found, along) = signed_distance(&a.here(), &b.here(), &[], f64::INFINITY);
            assert!((gap(&a.here(), &b.here(), &along) - found).abs() < 1e-9);
            let off = (found - expected).abs();
            assert!(off < 1e-9, "{found}, expected {expected}");
        }
    }

    #[test]
    fn boxes_apart_touching_and_overlapping() {
        let a = cube([0.0; 3], 0.5);
        apart(&a, &cube([2.0, 0.1, 0.2], 0.5), 1.0);
        apart(&a, &cube([2.0, 2.0, 0.0], 0.5), 2.0_f64.sqrt());
        apart(&a, &cube([1.0, 0.1, 0.0], 0.5), 0.0);
        apart(&a, &cube([0.9, 0.1, 0.2], 0.5), -0.1);
        apart(&a, &cube([0.0, 0.0, 0.7], 0.1), -0.1 + 0.2);
    }

    #[test]
    fn round_shapes_keep_their_radius() {
        let ball = |x: f64, r: f64| Solid::hull([Vector3::new(x, 0.0, 0.0)], r);
        apart(&ball(0.0, 0.3), &ball(1.0, 0.2), 0.5);
        apart(&ball(0.0, 0.6), &ball(1.0, 0.6), -0.2);
        let ends = [-1.0, 1.0].map(|y| Vector3::new(0.0, y, 2.0));
        let capsule = Solid::hull(ends, 0.25);
        apart(&ball(0.0, 0.5), &capsule, 1.25);
        apart(&cube([0.0; 3], 0.5), &capsule, 1.25);
    }

    #[test]
    fn a_cylinder_is_flat_at_its_ends() {
        let c = Solid::widened([-1.0, 1.0].map(|z| Vector3::z() * z), &Vector3::z(), 0.5);
        apart(&c, &cube([0.0, 0.0, 2.0], 0.5), 0.5);
        apart(&c, &cube([1.5, 0.0, 0.0], 0.5), 0.5);
    }

    #[test]
    fn a_widened_plate_is_round_at_its_corners_and_flat_above() {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|[x, y]| Vector3::new(x, y, 0.0));
        let points = corners.into_iter().flat_map(|p| [p, p - Vector3::z()]);
        let plate = Solid::widened(points, &Vector3::z(), 0.2);
        let point = |x: f64, y: f64, z: f64| Solid::hull([Vector3::new(x, y, z)], 0.0);
        apart(&plate, &point(1.5, 0.3, -0.5), 0.3);
        apart(&plate, &point(1.3, 1.4, -0.5), 0.3);
        apart(&plate, &point(1.1, 0.0, 0.4), 0.4);
        apart(&plate, &point(1.3, 1.4, 0.4), 0.5);
    }

    #[test]
    fn a_sole_on_a_deep_body_touches_it() {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].into_iter();
        let points = corners.flat_map(|[x, y]| [0.0, -0.2].map(|z| Vector3::new(x, y, z)));
        let floor = Solid::hull(points, 0.0);
        apart(&cube([0.3, 0.2, 0.05], 0.05), &floor, 0.0);
        apart(&cube([0.3, 0.2, 0.047], 0.05), &floor, -0.003);
    }

    #[test]
    fn bodies_without_a_volume_do_not_panic() {
        let point = Solid::hull([Vector3::zeros()], 0.0);
        let flat = Solid::hull([Vector3::zeros(), Vector3::x(), Vector3::y()], 0.0);
        let nothing = Solid::hull([], 0.0);
        for a in [&point, &flat, &nothing] {
            for b in [&point, &flat, &nothing, &cube([0.0; 3], 1.0)] {
                let (found, _) = signed_distance(&a.here(), &b.here(), &[], f64::INFINITY);
                assert!(!found.is_nan());
            }
        }
    }
}
