//! Regions of faces: what is left of them at their edges.

use nalgebra::{Matrix3, Vector2, Vector3};
use surfaces::{Edge, EdgeKind, EdgeView, Face};

use crate::posture::inverse_point;

pub(crate) type Point = Vector2<f64>;

/// How far a patch, as its vertices in the face's frame, is inside a face beyond what is not known
/// of each edge, m; negative where it is not.
///
///   min over edges e of (distance of the patch from e) − inset_e
///
/// A vertex outside the region counts by its distance from it.
pub(crate) fn inside_m(face: &Face, sigmas: f64, patch: &[Point]) -> f64 {
    let mut least = f64::INFINITY;
    for (edge, a, b) in edges(face) {
        let away = apart_m(patch, &a, &b);
        least = least.min(away - inset_m(face, edge, [a, b], sigmas));
    }
    for p in patch {
        if winding(face, p) < 0.5 {
            let away = edges(face).map(|(_, a, b)| (p - nearest(&a, &b, p)).norm());
            least = least.min(-away.fold(f64::INFINITY, f64::min));
        }
    }
    least
}

/// The edges of all rings with their ends, in the face's frame.
pub(crate) fn edges(face: &Face) -> impl Iterator<Item = (&Edge, Point, Point)> {
    face.region.rings().iter().flat_map(|ring| {
        let count = ring.vertices.len();
        let edge = move |k: usize| {
            let (a, b) = (&ring.vertices[k], &ring.vertices[(k + 1) % count]);
            (&ring.edges[k], a.coords, b.coords)
        };
        (0..count).map(edge)
    })
}

/// How often the rings run around a point: 1 inside, 0 outside and in holes.
pub(crate) fn winding(face: &Face, p: &Point) -> f64 {
    let turn = |a: Point, b: Point| a.perp(&b).atan2(a.dot(&b));
    let turns = edges(face).map(|(_, a, b)| turn(a - p, b - p));
    turns.sum::<f64>() / std::f64::consts::TAU
}

/// The point of a segment that is nearest to `p`.
pub(crate) fn nearest(a: &Point, b: &Point, p: &Point) -> Point {
    let along = b - a;
    let part = along.dot(&(p - a)) / along.norm_squared().max(f64::MIN_POSITIVE);
    a + along * part.clamp(0.0, 1.0)
}

/// Distance of a segment from a convex counter-clockwise polygon or a point, m; 0 where they meet.
fn apart_m(polygon: &[Point], a: &Point, b: &Point) -> f64 {
    let left = |from: &Point, to: &Point, p: &Point| (to - from).perp(&(p - from));
    let sides = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let holds = |p: &Point| polygon.len() > 2 && sides().all(|(c, d)| left(c, d, p) >= 0.0);
    let crosses = |c: &Point, d: &Point| {
        left(c, d, a) * left(c, d, b) <= 0.0 && left(a, b, c) * left(a, b, d) < 0.0
    };
    if holds(a) || sides().any(|(c, d)| crosses(c, d)) {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for (c, d) in sides() {
        for (p, [from, to]) in [(c, [a, b]), (a, [c, d]), (b, [c, d])] {
            least = least.min((p - nearest(from, to, p)).norm());
        }
    }
    least
}

/// By how much an edge may be nearer than it is drawn, m.
///
/// Its eye at height h over the plane sees a point of the edge along the ray r. A plane that is off
/// by δ there moves the edge by δ |n·r| / h, an angle ε in the image by ε |r| |r × e| / h, with n the
/// edge's normal and e its direction in the plane.
fn inset_m(face: &Face, edge: &Edge, ends: [Point; 2], sigmas: f64) -> f64 {
    let Some(view) = edge.view.and_then(|view| face.views.get(view)) else {
        return edge.further_m;
    };
    let middle = (ends[0] + ends[1]) / 2.0;
    let at = |p: &Point| seen_inset_m(face, edge, view, ends, p, sigmas);
    let places = [ends[0], middle, ends[1]];
    places.iter().map(at).fold(0.0, f64::max)
}

/// As [`inset_m`], at a point of the edge between `a` and `b`.
fn seen_inset_m(
    face: &Face,
    edge: &Edge,
    view: &EdgeView,
    [a, b]: [Point; 2],
    p: &Point,
    sigmas: f64,
) -> f64 {
    let eye = inverse_point(&face.X_WF.to_homogeneous(), &view.eye_W.coords);
    let height = eye.z.max(1e-3);
    let ray = Vector3::new(p.x - eye.x, p.y - eye.y, -height);
    let e = ((b - a) / (b - a).norm()).push(0.0);
    let n = Vector3::new(e.y, -e.x, 0.0);
    let plane = view.plane_covariance.or(face.plane_covariance);
    let plane_sigma_m = plane.map_or(0.0, |rows| {
        let covariance = Matrix3::from_fn(|i, j| rows[i][j]);
        let by_plane = Vector3::new(p.y, -p.x, 1.0);
        by_plane.dot(&(covariance * by_plane)).max(0.0).sqrt()
    });
    let by_plane_m = sigmas * plane_sigma_m * n.dot(&ray).abs() / height;
    let per_rad = ray.norm() * ray.cross(&e).norm() / height;
    // The border of the view is known: only the plane moves an edge there. Where another face rises nothing falls.
    let (per_rad, by_plane_m) = match edge.kind {
        EdgeKind::FieldOfView => (0.0, by_plane_m),
        EdgeKind::Fold => (0.0, 0.0),
        _ => (per_rad, by_plane_m),
    };
    let by_image_m = sigmas * view.sigma_rad * per_rad;
    let inside_m = edge.inside_rad * per_rad;
    let squares = [by_plane_m, by_image_m, edge.further_m].map(|x| x * x);
    squares.iter().sum::<f64>().sqrt() - inside_m
}

#[cfg(test)]
pub(crate) mod tests {
    use nalgebra::{Isometry3, Point2};
    use surfaces::Region;

    use super::*;

    /// A square of side 4 with a hole of side 2 in its middle.
    pub(crate) fn frame() -> Face {
        let square = |half: f64| {
            let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
            corners.map(|(x, y)| Point2::new(x, y)).to_vec()
        };
        let region = Region::new([square(2.0), square(1.0)]).unwrap();
        Face::new("frame", Isometry3::identity(), region)
    }

    fn patch(x: f64, y: f64, half: f64) -> Vec<Point> {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        corners.map(|(dx, dy)| Point::new(x + dx, y + dy)).to_vec()
    }

    #[test]
    fn a_patch_is_inside_by_its_distance_from_the_nearest_edge() {
        for ((x, y, half), inside) in [
            ((1.5, 0.0, 0.2), 0.3),
            ((1.7, 0.0, 0.2), 0.1),
            // In the hole, beside the region, over an edge, and around the hole.
            ((0.0, 0.0, 0.2), -0.8),
            ((3.0, 0.0, 0.2), -1.2),
            ((1.0, 0.0, 0.2), -0.2),
            ((0.0, 0.0, 1.5), 0.0),
        ] {
            let found = inside_m(&frame(), 2.0, &patch(x, y, half));
            assert!((found - inside).abs() < 1e-9, "({x}, {y}): {found}");
        }
        let found = inside_m(&frame(), 2.0, &[Point::new(1.75, 1.9)]);
        assert!((found - 0.1).abs() < 1e-9, "{found}");
    }

    #[test]
    fn an_error_of_an_edge_takes_it_back() {
        let mut face = frame();
        let edges_mut = face.region.edges_mut().flatten();
        edges_mut.for_each(|edge| edge.further_m = 0.05);
        let found = inside_m(&face, 2.0, &patch(1.5, 0.0, 0.2));
        assert!((found - 0.25).abs() < 1e-9, "{found}");
        // The insets of the library are other code.
        face.views.push(EdgeView {
            eye_W: nalgebra::Point3::new(-1.0, 0.5, 1.5),
            sigma_rad: 0.002,
            plane_covariance: None,
        });
        face.plane_covariance = Some([[1e-5, 0.0, 0.0], [0.0, 2e-5, 0.0], [0.0, 0.0, 4e-6]]);
        for (k, edge) in face.region.edges_mut().flatten().enumerate() {
            edge.view = Some(0);
            edge.inside_rad = 1e-4 * k as f64;
        }
        let theirs: Vec<f64> = face.edge_insets_m(2.0).concat();
        let mine = edges(&face).map(|(edge, a, b)| inset_m(&face, edge, [a, b], 2.0));
        for (mine, theirs) in mine.zip(theirs) {
            let agree = (mine - theirs).abs() < 1e-12;
            assert!(agree && mine > 0.04, "{mine} {theirs}");
        }
    }
}
