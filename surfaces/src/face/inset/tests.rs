use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

use super::*;
use crate::polygon::tests::{points, polygons};

/// A face of 2 m × 1 m.
fn face() -> Face {
    Face::rectangle("f", Isometry3::identity(), [2.0, 1.0]).unwrap()
}

fn view(eye: [f64; 3], sigma_rad: f64) -> EdgeView {
    EdgeView {
        eye_W: Point3::from(eye),
        sigma_rad,
        plane_covariance: None,
    }
}

/// With a plane known to 10 mrad about x, 20 mrad about y and 2 mm along the normal.
fn uncertain() -> Face {
    let mut face = face();
    let (tilt, height) = (0.01_f64.powi(2), 0.002_f64.powi(2));
    face.plane_covariance = Some([[tilt, 0.0, 0.0], [0.0, 4.0 * tilt, 0.0], [0.0, 0.0, height]]);
    face
}

fn with_edges(mut face: Face, edge: Edge) -> Face {
    let view = (!face.views.is_empty()).then_some(0);
    let seen = Edge { view, ..edge };
    face.region.edges_mut().flatten().for_each(|e| *e = seen);
    face
}

#[test]
fn a_plane_error_moves_the_edges_that_slanted_rays_cross() {
    // From so far away that all rays are parallel, along the normal: only the edges' own error.
    let mut above = uncertain();
    above.views = vec![view([0.0, 0.0, 1e6], 0.0)];
    let further = Edge {
        further_m: 0.008,
        ..Edge::default()
    };
    for inset in &with_edges(above.clone(), further).edge_insets_m(2.0)[0] {
        approx::assert_relative_eq!(*inset, 0.008, epsilon = 1e-7);
    }
    // At 45° along +x: an error along the normal moves the edges across x by as much.
    above.views = vec![view([-1e6, 0.0, 1e6], 0.0)];
    let mut above = with_edges(above, Edge::default());
    let insets = above.edge_insets_m(2.0);
    let corner = (0.5_f64 * 0.01).hypot(1.0 * 0.02).hypot(0.002);
    approx::assert_relative_eq!(insets[0][1], 2.0 * corner, max_relative = 1e-5);
    assert!(insets[0][0] < 1e-6);
    // The plane in which a view found the edges counts, not what the face's is known to by now.
    above.views[0].plane_covariance = Some([[0.0; 3]; 3]);
    assert!(above.edge_insets_m(2.0)[0][1] < 1e-6);
}

#[test]
fn what_lies_inside_counts_but_not_at_the_border_of_the_view() {
    // One metre above the middle: a milliradian is a millimetre at an edge below, more aside.
    let inside = |kind: EdgeKind, inside_rad: f64| {
        let mut seen = face();
        seen.views = vec![view([0.0, 0.0, 1.0], 0.002)];
        let edge = Edge {
            inside_rad,
            ..Edge::new(kind)
        };
        with_edges(seen, edge).edge_insets_m(2.0)[0].clone()
    };
    // At a corner: |d| |d × e| = 1.5 · √1.25 and 1.5 · √2.
    let some = inside(EdgeKind::Real, 0.003);
    approx::assert_relative_eq!(some[0], 1.5e-3 * 1.25_f64.sqrt(), max_relative = 1e-9);
    approx::assert_relative_eq!(some[1], 1.5e-3 * 2.0_f64.sqrt(), max_relative = 1e-9);
    // Farther inside than the errors are.
    assert_eq!(inside(EdgeKind::Occluded, 0.01), [0.0; 4]);
    assert_eq!(inside(EdgeKind::FieldOfView, -0.003), [0.0; 4]);
    // Without a view only the further error is left.
    let edge = Edge {
        inside_rad: 0.1,
        further_m: 0.02,
        ..Edge::default()
    };
    assert_eq!(with_edges(face(), edge).edge_insets_m(2.0), [[0.02; 4]]);
}

/// Regions of two polygons that overlap, less a third one, each edge with an error of its own.
pub(crate) fn faces() -> impl Strategy<Value = Face> {
    let errors = prop::collection::vec(prop_oneof![Just(0.0), 0.0..0.3_f64], 1..20);
    (polygons(), polygons(), polygons(), errors).prop_filter_map(
        "no region",
        |(a, b, c, errors)| {
            let [a, b, c] = [a, b, c].map(|polygon| Outline::from_polygon(&polygon));
            let region = a.union(&b).minus(&c).regions().into_iter().next()?;
            let mut face = Face::new("f", Isometry3::new(Vector3::x(), Vector3::y()), region);
            let edges = face.region.edges_mut().flatten().zip(errors.iter().cycle());
            edges.for_each(|(edge, further_m)| edge.further_m = *further_m);
            Some(face)
        },
    )
}

fn distance(p: &Point2<f64>, [a, b]: [&Point2<f64>; 2]) -> f64 {
    crate::cover::distance_to_segment(p, a, b)
}

proptest! {
    /// What is left keeps its distance from every edge, and what is farther away from all is left.
    #[test]
    fn the_inset_region_is_what_is_far_enough_from_every_edge(
        face in faces(), further in prop_oneof![Just(0.0), 0.0..0.2_f64], places in points(60..61),
    ) {
        let left = face.inset_region(2.0, further);
        let insets = face.edge_insets_m(2.0);
        let whole = Outline::from(&face.region);
        let lacks = |p: &Point2<f64>| {
            let edges = face.region.segments().zip(insets.iter().flatten());
            let lack = edges.map(|((_, ends), inset)| inset + further - distance(p, ends));
            lack.fold(f64::NEG_INFINITY, f64::max)
        };
        for region in left.regions() {
            for vertex in region.rings().iter().flat_map(|ring| &ring.vertices) {
                prop_assert!(lacks(vertex) < 1e-6, "{vertex} lacks {}", lacks(vertex));
            }
        }
        for p in places.iter().filter(|p| left.contains(p)) {
            prop_assert!(lacks(p) < 1e-6 && whole.contains(p));
        }
        // An octagon reaches farther than its circle by a tenth, a corner of a convex region by the
        // whole distance and more: only regions that are not convex are compared.
        if face.region.as_convex().is_none() {
            let far = |p: &&Point2<f64>| whole.contains(p) && lacks(p) < -0.1 * (0.5 + further);
            for p in places.iter().filter(far) {
                prop_assert!(left.contains(p), "{p} is far from every edge");
            }
        }
    }

    /// Inside, around the point (or the nearest there is), the same each time, and large.
    #[test]
    fn the_convex_part_around_a_point_is_large_and_inside(
        face in faces(), places in points(6..7), turn in -3.0..3.0_f64,
    ) {
        let outline = Outline::from(&face.region);
        let direction = Vector2::new(turn.cos(), turn.sin());
        let cover = crate::cover::cover(&face.region, &crate::cover::BODIES);
        for p in &places {
            let part = outline.convex_around(p, &direction);
            prop_assert_eq!(&part, &outline.convex_around(p, &direction));
            let part = part.unwrap();
            let off = Outline::from_polygon(&part).minus(&outline).area();
            prop_assert!(off < 2e-6 * outline.length(), "{off} m² outside");
            if outline.contains(p) {
                prop_assert!(part.contains(p, 1.02e-4), "off by {}", part.signed_distance(p));
            } else {
                let edges = face.region.segments();
                let gap = edges.map(|(_, ends)| distance(p, ends)).fold(f64::INFINITY, f64::min);
                prop_assert!((part.signed_distance(p) - gap).abs() < 1.02e-4);
            }
            let holding = cover.pieces.iter().filter(|piece| piece.polygon.contains(p, 0.0));
            let best = holding.map(|piece| piece.polygon.area()).fold(0.0, f64::max);
            prop_assert!(part.area() >= 0.1 * best, "{} of {best} m²", part.area());
        }
    }
}

#[test]
fn a_part_of_a_cross_is_long_along_the_direction_asked_for() {
    let strips = [([0.0, 0.4], [1.0, 0.6]), ([0.4, 0.0], [0.6, 1.0])];
    let cross = Outline::from_rectangles(&strips);
    let middle = Point2::new(0.5, 0.5);
    for (direction, (width, height)) in [(Vector2::x(), (1.0, 0.2)), (Vector2::y(), (0.2, 1.0))] {
        let part = cross.convex_around(&middle, &direction).unwrap();
        let (low, high) = Outline::from_polygon(&part).bounds().unwrap();
        approx::assert_relative_eq!(high.x - low.x, width, epsilon = 1e-6);
        approx::assert_relative_eq!(high.y - low.y, height, epsilon = 1e-6);
    }
    // Beyond the tip of an arm: the arm.
    let right = cross
        .convex_around(&Point2::new(2.0, 0.5), &Vector2::y())
        .unwrap();
    approx::assert_relative_eq!(right.area(), 0.2, epsilon = 1e-6);
    assert_eq!(
        Outline::default().convex_around(&middle, &Vector2::x()),
        None
    );
}
