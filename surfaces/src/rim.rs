//! What a scanned face may occupy beyond the polygons that a robot may touch.
//!
//! Polygons for contacts lie surely on their face: its edges are taken back, and convex pieces leave
//! corners out. For collisions the opposite must hold: bodies that surely cover the face. So the
//! bodies behind polygons are widened by what was taken back ([`Surface::edge_m`]), and where the
//! outline goes on, further bodies cover the rest.

use nalgebra::{Point2, Point3};

use crate::cover::{self, Region, cover};
use crate::{ConvexPolygon, Obstacle, Source, Surface, WALL_RAD, thin_body};

/// Distance by which a scanned face is wider than its polygons, m: what was taken off its edges, and
/// how far they may be off.
const EDGE_M: f64 = 0.015;
/// Parts of an outline that no widened polygon covers are left alone up to this area, m².
const REST_MAX_M2: f64 = 0.002;

/// Widens the bodies of scanned faces, deepens those of walls by `body`, and returns bodies that
/// cover what is left of the outlines.
///
/// `free_W` are points that were seen, before which nothing stands. Each body names the first surface of its face. Units: m.  Frames: W.
#[allow(non_snake_case)]
pub fn widen(
    surfaces: &mut [Surface],
    free_W: &[Point3<f64>],
    body: &thin_body::Config,
) -> Vec<Obstacle> {
    let mut bodies = Vec::new();
    let scanned = |s: &Surface| s.source == Source::Scan;
    for surface in surfaces.iter_mut().filter(|s| scanned(s)) {
        surface.edge_m = EDGE_M;
    }
    for index in 0..surfaces.len() {
        let surface = &surfaces[index];
        let wall = surface.normal_W().z.abs() <= WALL_RAD.cos();
        if scanned(surface) && wall {
            let depth = thin_body::depth_m(surface, surfaces, free_W, body);
            surfaces[index].depth_m = depth.max(body.thickness_m);
        }
    }
    for (index, surface) in surfaces.iter().enumerate() {
        let known = surfaces[..index].iter().any(|s| s.shares_outline(surface));
        if !scanned(surface) || known || surface.outline.is_empty() {
            continue;
        }
        // The widened pieces of this part of the face, in the frame of the first.
        let of_part = surfaces[index..]
            .iter()
            .filter(|s| s.id == surface.id || s.shares_outline(surface));
        let mut covered: Vec<ConvexPolygon> = of_part
            .filter_map(|s| seen_from(surface, s))
            .map(|polygon| polygon.grown(EDGE_M))
            .collect();
        let mut number = 0;
        for piece in pieces(surface) {
            if cover::area_outside(&piece, &covered) <= REST_MAX_M2 {
                continue;
            }
            let wide = piece.grown(EDGE_M);
            bodies.push(Obstacle {
                id: format!("{}/rim{number}", surface.id),
                points_W: extruded(surface, &wide, body.thickness_m.max(surface.depth_m)),
                surface: Some(surface.id.clone()),
                assumed: true,
            });
            number += 1;
            covered.push(wide);
        }
    }
    bodies
}

/// The polygon of another piece of the plane, in the frame of this surface.
fn seen_from(surface: &Surface, other: &Surface) -> Option<ConvexPolygon> {
    let corners: Vec<Point2<f64>> = other
        .vertices_W()
        .iter()
        .map(|p| surface.X_WS.inverse_transform_point(p).xy())
        .collect();
    ConvexPolygon::hull(&corners).ok()
}

/// Convex pieces of the outline; none where it crosses itself.
fn pieces(surface: &Surface) -> Vec<ConvexPolygon> {
    let rings: Vec<Vec<Point2<f64>>> = surface
        .outline
        .iter()
        .map(|ring| ring.iter().map(|p| Point2::from(*p)).collect())
        .collect();
    match Region::new(rings) {
        Ok(region) => cover(&region, &cover::BODIES)
            .pieces
            .into_iter()
            .map(|piece| piece.polygon)
            .collect(),
        Err(_) => Vec::new(),
    }
}

/// The prism behind a part of the surface's plane.
fn extruded(surface: &Surface, polygon: &ConvexPolygon, depth_m: f64) -> Vec<Point3<f64>> {
    let at = |z: f64| {
        polygon
            .vertices()
            .iter()
            .map(move |p| surface.X_WS * Point3::new(p.x, p.y, z))
    };
    at(0.0).chain(at(-depth_m)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    fn square(half: f64) -> Surface {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corners = corners.map(|(x, y)| Point2::new(x * half, y * half));
        let polygon = ConvexPolygon::new(corners.to_vec()).unwrap();
        Surface::new("s0", Isometry3::translation(1.0, 2.0, 3.0), polygon)
    }

    #[test]
    fn a_face_that_is_its_polygon_is_widened_and_gets_no_further_body() {
        let mut surfaces = [square(0.2)];
        surfaces[0].source = Source::Scan;
        let corners = surfaces[0].polygon.vertices().iter();
        surfaces[0].outline = vec![corners.map(|p| [p.x, p.y]).collect()];
        let rest = widen(&mut surfaces, &[], &thin_body::Config::default());
        assert!(rest.is_empty());
        let body = surfaces[0].thin_body(0.03);
        let reach = body.points_W.iter().map(|p| (p.x - 1.0).abs());
        approx::assert_relative_eq!(reach.fold(0.0, f64::max), 0.215, epsilon = 1e-12);
    }

    #[test]
    fn an_outline_in_the_shape_of_an_l_is_covered_and_its_notch_is_not() {
        let mut surface = square(0.1);
        surface.source = Source::Scan;
        surface.outline = vec![vec![
            [-0.1, -0.1],
            [0.5, -0.1],
            [0.5, 0.1],
            [0.1, 0.1],
            [0.1, 0.5],
            [-0.1, 0.5],
        ]];
        // A second piece of the same part adds nothing.
        let mut second = surface.clone();
        second.id = "s1".to_owned();
        (surface.face, second.face) = (Some("f0".to_owned()), Some("f0".to_owned()));
        let mut surfaces = [surface.clone(), second];
        let found = widen(&mut surfaces, &[], &thin_body::Config::default());
        assert_eq!(found.len(), 2);
        assert!(
            found
                .iter()
                .all(|o| o.assumed && o.surface.as_deref() == Some("s0"))
        );
        let hulls: Vec<ConvexPolygon> = found
            .iter()
            .map(|body| {
                let local = |p| surface.X_WS.inverse_transform_point(p).xy();
                let ring: Vec<Point2<f64>> = body.points_W.iter().map(local).collect();
                ConvexPolygon::hull(&ring).unwrap()
            })
            .collect();
        let covers = |x: f64, y: f64| hulls.iter().any(|h| h.contains(&Point2::new(x, y), 0.0));
        assert!(covers(0.51, 0.0) && covers(0.0, 0.51) && covers(-0.11, -0.11));
        assert!(!covers(0.3, 0.3));
    }

    #[test]
    fn what_is_given_exactly_stays_as_it_is() {
        let mut surfaces = [square(0.2)];
        assert_ne!(surfaces[0].source, Source::Scan);
        assert!(widen(&mut surfaces, &[], &thin_body::Config::default()).is_empty());
        assert_eq!(surfaces[0].edge_m, 0.0);
    }
}
