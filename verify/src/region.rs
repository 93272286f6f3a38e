//! Regions of faces: what is left of them at their edges, and their parts that are convex.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector2, Vector3};
use surfaces::{Edge, EdgeKind, EdgeView, Face};

use crate::posture::inverse_point;

type Point = Vector2<f64>;

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
fn edges(face: &Face) -> impl Iterator<Item = (&Edge, Point, Point)> {
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
fn winding(face: &Face, p: &Point) -> f64 {
    let turn = |a: Point, b: Point| a.perp(&b).atan2(a.dot(&b));
    let turns = edges(face).map(|(_, a, b)| turn(a - p, b - p));
    turns.sum::<f64>() / std::f64::consts::TAU
}

/// The point of a segment that is nearest to `p`.
fn nearest(a: &Point, b: &Point, p: &Point) -> Point {
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
    // The border of the view is known: only the plane moves an edge there.
    let per_rad = if edge.kind == EdgeKind::FieldOfView {
        0.0
    } else {
        per_rad
    };
    let by_image_m = sigmas * view.sigma_rad * per_rad;
    let inside_m = edge.inside_rad * per_rad;
    let squares = [by_plane_m, by_image_m, edge.further_m].map(|x| x * x);
    squares.iter().sum::<f64>().sqrt() - inside_m
}

/// Lengths below this are rounding, m.
const ROUNDING_M: f64 = 1e-9;

/// A convex polygon between its lower and its upper corners, each from left to right.
struct Part {
    lower: Vec<Point>,
    upper: Vec<Point>,
}

impl Part {
    /// The part with a trapezoid added to its right side, where that is the trapezoid's left side and
    /// the two together are convex.
    fn joined(&self, next: &Part) -> Option<Part> {
        let chain = |first: &[Point], second: &[Point], bend: f64| {
            let [.., a, b] = first else { return None };
            let [c, d, ..] = second else { return None };
            let meets = (b - c).norm() < ROUNDING_M;
            let turn = (b - a).perp(&(d - b)) * bend;
            let off_m = turn / (b - a).norm().max(f64::MIN_POSITIVE);
            (meets && off_m > -ROUNDING_M).then(|| [first, &second[1..]].concat())
        };
        Some(Part {
            lower: chain(&self.lower, &next.lower, 1.0)?,
            upper: chain(&self.upper, &next.upper, -1.0)?,
        })
    }
}

/// The region as convex polygons that do not overlap: trapezoids between the vertical lines through
/// its corners, each between an odd edge from below and the next one, joined from left to right.
pub(crate) fn convex_parts(face: &Face) -> Vec<Vec<Point>> {
    let mut lines: Vec<f64> = edges(face).map(|(_, a, _)| a.x).collect();
    lines.sort_by(f64::total_cmp);
    lines.dedup_by(|a, b| (*a - *b).abs() < ROUNDING_M);
    let mut found: Vec<Part> = Vec::new();
    // Parts before this one end to the left of the line.
    let mut open = 0;
    for slab in lines.windows(2) {
        let (low, high) = (slab[0], slab[1]);
        let middle = 0.5 * (low + high);
        let height =
            |(_, a, b): &(&Edge, Point, Point), x: f64| a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
        let crosses = |(_, a, b): &(&Edge, Point, Point)| (a.x < middle) != (b.x < middle);
        let mut across: Vec<_> = edges(face).filter(crosses).collect();
        across.sort_by(|a, b| height(a, middle).total_cmp(&height(b, middle)));
        let mut left = found.split_off(open);
        open = found.len();
        let mut right = Vec::new();
        for pair in across.chunks_exact(2) {
            let side = |edge| [low, high].map(|x| Point::new(x, height(edge, x))).to_vec();
            let (lower, upper) = (side(&pair[0]), side(&pair[1]));
            let next = Part { lower, upper };
            let mut joined = left.iter().enumerate();
            let joined = joined.find_map(|(k, part)| Some((k, part.joined(&next)?)));
            right.push(joined.map_or(next, |(k, whole)| {
                left.remove(k);
                whole
            }));
        }
        open += left.len();
        found.append(&mut left);
        found.append(&mut right);
    }
    let ring = |part: Part| [part.lower, part.upper.into_iter().rev().collect()].concat();
    found.into_iter().map(ring).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point2};
    use proptest::prelude::*;
    use surfaces::Region;

    use super::*;

    /// A square of side 4 with a hole of side 2 in its middle.
    fn frame() -> Face {
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

    fn area(ring: &[Point]) -> f64 {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        0.5 * edges.map(|(a, b)| a.perp(b)).sum::<f64>()
    }

    #[test]
    fn a_frame_is_four_parts() {
        let parts = convex_parts(&frame());
        let total: f64 = parts.iter().map(|part| area(part)).sum();
        assert!((total - 12.0).abs() < 1e-9 && parts.len() == 4, "{total}");
    }

    proptest! {
        /// Stars with a star for a hole: their parts are convex, as large as they are, and hold the
        /// points that are inside, each once.
        #[test]
        fn parts_are_convex_and_the_region(
            radii in prop::collection::vec(1.0..3.0_f64, 3..24),
            hole in prop::collection::vec(0.1..0.4_f64, 3..12),
            places in prop::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 40),
        ) {
            let star = |radii: &[f64]| -> Vec<Point2<f64>> {
                let turn = std::f64::consts::TAU / radii.len() as f64;
                let at = |(k, r): (usize, &f64)| {
                    let (sin, cos) = (0.1 + turn * k as f64).sin_cos();
                    Point2::new(r * cos, r * sin)
                };
                radii.iter().enumerate().map(at).collect()
            };
            let Ok(region) = Region::new([star(&radii), star(&hole)]) else {
                return Ok(());
            };
            let corners = radii.len() + hole.len();
            let whole = region.area();
            let face = Face::new("star", Isometry3::identity(), region);
            let parts = convex_parts(&face);
            prop_assert!(parts.len() <= corners + 1);
            let total: f64 = parts.iter().map(|part| area(part)).sum();
            prop_assert!((total - whole).abs() < 1e-7, "{total} of {whole}");
            let outside_m = |part: &[Point], p: &Point| {
                let edges = part.iter().zip(part.iter().cycle().skip(1));
                let long = edges.filter(|(a, b)| (*b - *a).norm() > 1e-6);
                let off = long.map(|(a, b)| -(b - a).perp(&(p - a)) / (b - a).norm());
                off.fold(f64::NEG_INFINITY, f64::max)
            };
            for part in &parts {
                prop_assert!(part.iter().all(|p| outside_m(part, p) < 1e-6));
            }
            for (x, y) in places {
                let p = Point::new(x, y);
                let holding = parts.iter().filter(|part| outside_m(part, &p) < 0.0).count();
                let inside = usize::from(winding(&face, &p) > 0.5);
                let gap = edges(&face).map(|(_, a, b)| (p - nearest(&a, &b, &p)).norm());
                let on_side = parts.iter().any(|part| outside_m(part, &p).abs() < 1e-6);
                if gap.fold(f64::INFINITY, f64::min) > 1e-6 && !on_side {
                    prop_assert_eq!(holding, inside);
                }
            }
        }
    }
}
