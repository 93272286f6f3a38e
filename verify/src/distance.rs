//! Signed distances between convex bodies, each vouched for by a separating direction.
//!
//! For any unit d, the gap between two bodies along d is not more than their signed distance:
//!
//!   min_{p ∈ b} d·p − max_{p ∈ a} d·p  ≤  dist(a, b),   equal at the best d
//!
//! The search for the best direction is this module's own where they are apart and EPA's where they
//! overlap; the value is the gap itself.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Matrix4, Vector3};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;

use crate::nearest;
use crate::posture::column;

/// Bodies nearer than this are taken to touch: EPA and the given directions then decide, m.
const APART_M: f64 = 1e-9;

/// A convex body in a frame of its own: points, with all that is within a radius of each across an
/// axis, inflated by another radius.
pub(crate) struct Solid {
    points: Vec<Vector3<f64>>,
    axis: Vector3<f64>,
    disc: f64,
    radius: f64,
    centre: Vector3<f64>,
    reach: f64,
}

impl Solid {
    /// The hull of points inflated by a radius: a ball of one, a capsule of two; m.
    pub fn hull(points: impl IntoIterator<Item = Vector3<f64>>, radius: f64) -> Self {
        Self::new(points, &Vector3::z(), 0.0, radius)
    }

    /// The hull of points, with all that is within a radius of it across a unit axis: a cylinder of
    /// two; m.
    pub fn widened(
        points: impl IntoIterator<Item = Vector3<f64>>,
        axis: &Vector3<f64>,
        radius: f64,
    ) -> Self {
        Self::new(points, axis, radius, 0.0)
    }

    fn new(
        points: impl IntoIterator<Item = Vector3<f64>>,
        axis: &Vector3<f64>,
        disc: f64,
        radius: f64,
    ) -> Self {
        let points: Vec<Vector3<f64>> = points.into_iter().collect();
        let (low, high) = extremes(points.iter().copied());
        let centre = match points.is_empty() {
            true => Vector3::zeros(),
            false => (low + high) / 2.0,
        };
        let far = |p: &Vector3<f64>| {
            let along = (p - centre).dot(axis);
            let across = ((p - centre) - axis * along).norm() + disc;
            along.hypot(across)
        };
        let reach = points.iter().map(far).fold(0.0, f64::max) + radius;
        let axis = *axis;
        Self {
            points,
            axis,
            disc,
            radius,
            centre,
            reach,
        }
    }

    /// The body where the pose of its frame puts it.
    pub fn at(&self, X: &Matrix4<f64>) -> Placed<'_> {
        Placed {
            solid: self,
            turn: X.fixed_view::<3, 3>(0, 0).into_owned(),
            origin: column(X, 3),
        }
    }

    /// The body where it is.
    pub fn here(&self) -> Placed<'_> {
        self.at(&Matrix4::identity())
    }

    /// Centre and radius of a ball that holds the body, in its frame, m.
    pub fn ball(&self) -> Ball {
        (self.centre, self.reach)
    }

    /// A point of the core that is farthest along a direction, in the body's frame.
    fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let mut best = Vector3::zeros();
        let mut most = f64::NEG_INFINITY;
        for p in &self.points {
            let along = p.dot(direction);
            if along > most {
                (best, most) = (*p, along);
            }
        }
        if self.disc == 0.0 {
            return best;
        }
        // Along the axis, what is left across it is rounding, and not even across it.
        let across = direction - self.axis * self.axis.dot(direction);
        if across.norm() > 1e-9 * direction.norm() {
            best += across.normalize() * self.disc;
        }
        best
    }
}

/// A convex body in W.
pub(crate) struct Placed<'a> {
    solid: &'a Solid,
    turn: Matrix3<f64>,
    origin: Vector3<f64>,
}

impl Placed<'_> {
    /// A point of the core that is farthest along a direction, in W.
    fn farthest(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.turn * self.solid.farthest(&self.turn.tr_mul(direction)) + self.origin
    }

    /// How far a point of the body is at most from where it was in another place, m.
    pub fn moved_from(&self, other: &Placed) -> f64 {
        let turned = (self.turn - other.turn).norm() * FRAC_1_SQRT_2;
        (self.ball().0 - other.ball().0).norm() + turned * self.solid.reach
    }

    /// Centre and radius of a ball that holds the body, m.
    pub fn ball(&self) -> Ball {
        (
            self.turn * self.solid.centre + self.origin,
            self.solid.reach,
        )
    }
}

impl SupportMap for Placed<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        vector(&self.farthest(&Vector3::new(direction.x, direction.y, direction.z)))
    }
}

/// Centre and radius of a ball around a body, m.
pub(crate) type Ball = (Vector3<f64>, f64);

/// The gap between two bodies along a unit direction from `a` to `b`, m: their distance is not less.
pub(crate) fn gap(a: &Placed, b: &Placed, along: &Vector3<f64>) -> f64 {
    let apart = b.farthest(&-along).dot(along) - a.farthest(along).dot(along);
    apart - a.solid.radius - b.solid.radius
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
    let inflation = a.solid.radius + b.solid.radius;
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
    nearest.point.norm() - a.solid.radius - b.solid.radius
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

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// The lowest and the highest corner of the box along the axes around points.
pub(crate) fn extremes(points: impl Iterator<Item = Vector3<f64>>) -> (Vector3<f64>, Vector3<f64>) {
    let far = Vector3::repeat(f64::INFINITY);
    points.fold((far, -far), |(low, high), p| (low.inf(&p), high.sup(&p)))
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
