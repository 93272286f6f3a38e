//! Signed distances between convex bodies in W, each vouched for by a separating direction.
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
use parry3d_f64::shape::SupportMap;

use crate::nearest;

/// Bodies nearer than this are taken to touch: EPA and the given directions then decide, m.
const APART_M: f64 = 1e-9;

/// A convex body in W: a core, inflated by a radius.
pub(crate) struct Solid {
    core: Core,
    radius: f64,
}

/// All points of discs of one radius and axis about the points of a hull.
struct Core {
    points: Vec<Vector>,
    axis: Vector,
    disc: f64,
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let mut best = Vector::ZERO;
        let mut most = f64::NEG_INFINITY;
        for &p in &self.points {
            let along = p.dot(direction);
            if along > most {
                (best, most) = (p, along);
            }
        }
        if self.disc == 0.0 {
            return best;
        }
        // Along the axis, what is left across it is rounding, and not even across it.
        let across = direction - self.axis * self.axis.dot(direction);
        if across.length() > 1e-9 * direction.length() {
            best += across.normalize() * self.disc;
        }
        best
    }
}

impl Solid {
    /// The hull of points inflated by a radius: a ball of one, a capsule of two; m.
    pub fn hull(points: impl IntoIterator<Item = Vector3<f64>>, radius: f64) -> Self {
        let no_disc = Self::widened(points, &Vector3::z(), 0.0);
        Self { radius, ..no_disc }
    }

    /// The hull of points, with all that is within a radius of it across a unit axis: a cylinder of
    /// two; m.
    pub fn widened(
        points: impl IntoIterator<Item = Vector3<f64>>,
        axis: &Vector3<f64>,
        radius: f64,
    ) -> Self {
        let core = Core {
            points: points.into_iter().map(|p| vector(&p)).collect(),
            axis: vector(axis),
            disc: radius,
        };
        Self { core, radius: 0.0 }
    }

    /// A centre to start the search from.
    fn middle(&self) -> Vector {
        let points = &self.core.points;
        points.iter().copied().sum::<Vector>() / points.len().max(1) as f64
    }
}

/// The signed distance, m: negative where the bodies overlap, by how far they would have to be
/// moved apart. Never more than the true one: a gap along a direction. Apart, the direction is the
/// best there is; overlapping, the best of EPA's, of `hints` and of the axes.
pub(crate) fn signed_distance(a: &Solid, b: &Solid, hints: &[Vector3<f64>]) -> f64 {
    let inflation = a.radius + b.radius;
    let start = b.middle() - a.middle();
    // Points of b less points of a.
    let support = |d: &Vector3<f64>| {
        let d = vector(d);
        let w = b.core.local_support_point(d) - a.core.local_support_point(-d);
        Vector3::new(w.x, w.y, w.z)
    };
    let nearest = nearest::to_origin(support, &Vector3::new(-start.x, -start.y, -start.z));
    if nearest.at_least > APART_M {
        return nearest.at_least - inflation;
    }
    let gap = |d: Vector| {
        let d = d.normalize_or_zero();
        if d == Vector::ZERO {
            return f64::NEG_INFINITY;
        }
        b.core.local_support_point(-d).dot(d) - a.core.local_support_point(d).dot(d)
    };
    let axes = [Vector::X, Vector::Y, Vector::Z, start].into_iter();
    let directions = axes.chain(hints.iter().map(vector)).flat_map(|d| [d, -d]);
    let directions = directions.chain(way_out(&a.core, &b.core, start));
    directions.map(gap).fold(f64::NEG_INFINITY, f64::max) - inflation
}

/// The direction in which EPA finds the least overlap.
fn way_out(a: &Core, b: &Core, start: Vector) -> Option<Vector> {
    let here = Pose::IDENTITY;
    let mut simplex = VoronoiSimplex::new();
    let start = start.try_normalize().unwrap_or(Vector::X);
    simplex.reset(CsoPoint::from_shapes(&here, a, b, start));
    match closest_points(&here, a, b, f64::MAX, true, &mut simplex) {
        GJKResult::Intersection => EPA::new()
            .closest_points(&here, a, b, &simplex)
            .map(|(_, _, normal)| normal),
        GJKResult::ClosestPoints(_, _, normal)
        | GJKResult::Proximity(normal)
        | GJKResult::NoIntersection(normal) => Some(normal),
    }
}

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let found = signed_distance(a, b, &[]);
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
                assert!(!signed_distance(a, b, &[]).is_nan());
            }
        }
    }
}
