use nalgebra::{Point2, Rotation2};
use proptest::prelude::*;

use super::*;

const NAN: f64 = f64::NAN;

/// Points within a few metres, as coordinates come from scans.
pub(crate) fn points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Point2<f64>>> {
    prop::collection::vec((-3.0..3.0, -3.0..3.0), count)
        .prop_map(|list| list.into_iter().map(|(x, y)| Point2::new(x, y)).collect())
}

/// Convex polygons that are not slivers: at least a millimetre wide.
pub(crate) fn polygons() -> impl Strategy<Value = ConvexPolygon> {
    points(3..20).prop_filter_map("degenerate", |list| {
        let polygon = ConvexPolygon::hull(&list).ok()?;
        (polygon.inscribed_circle().1 > 5e-4).then_some(polygon)
    })
}

fn polygon(vertices: &[[f64; 2]]) -> Result<ConvexPolygon, Error> {
    vertices.to_vec().try_into()
}

fn rectangle(width: f64, height: f64) -> ConvexPolygon {
    polygon(&[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]).unwrap()
}

#[test]
fn every_bad_polygon_is_refused_for_its_own_fault_and_vertex() {
    let cases: Vec<(&[[f64; 2]], &str)> = vec![
        (
            &[[0.0, 0.0], [1.0, 0.0]],
            "at least 3 vertices, this one has 2",
        ),
        (
            &[[0.0, 0.0], [1.0, 0.0], [NAN, 1.0]],
            "vertex 2 is not within",
        ),
        (
            &[[0.0, 0.0], [f64::INFINITY, 0.0], [0.0, 1.0]],
            "vertex 1 is not within",
        ),
        (
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]],
            "vertex 3 repeats vertex 0",
        ),
        (
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
            "vertex 2 repeats vertex 1",
        ),
        (
            &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]],
            "all 3 vertices lie on one line",
        ),
        (
            &[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
            "run clockwise",
        ),
        (
            &[[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [2.0, 2.0], [0.0, 2.0]],
            "right by 1.695e0 rad at vertex 2",
        ),
        // A spike out along an edge, and a polygon wound twice.
        (
            &[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
            "at vertex 1",
        ),
        (
            &[
                [0.0, 1.0],
                [-0.6, -0.8],
                [0.95, 0.3],
                [-0.95, 0.3],
                [0.6, -0.8],
            ],
            "crosses itself",
        ),
    ];
    for (vertices, message) in cases {
        let error = polygon(vertices).unwrap_err().to_string();
        assert!(error.contains(message), "{vertices:?}: {error}");
    }
}

#[test]
fn a_hull_needs_an_area() {
    let line: Vec<_> = (0..5).map(|i| Point2::new(f64::from(i), 0.0)).collect();
    let one_place = vec![Point2::new(1.0, 2.0); 5];
    let mut nearly = line.clone();
    nearly[2].y = 5e-7;
    for (points, message) in [
        (line, "all 5 vertices lie on one line"),
        (one_place, "all 5 vertices lie on one line"),
        (
            nearly,
            "vertex 2, the farthest from it, is off by 5.000e-7 m",
        ),
        (vec![Point2::origin(); 2], "at least 3 vertices"),
        (vec![Point2::new(0.0, NAN); 3], "vertex 0 is not within"),
    ] {
        let error = ConvexPolygon::hull(&points).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_vertex_on_a_straight_edge_is_kept() {
    let p = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]).unwrap();
    assert_eq!(p.vertices().len(), 5);
    assert_eq!(p.half_planes().len(), 5);
}

#[test]
fn area_and_centroid_of_a_triangle_far_from_the_origin() {
    let p = polygon(&[[9e3, 9e3], [9e3 + 3.0, 9e3], [9e3, 9e3 + 3.0]]).unwrap();
    approx::assert_relative_eq!(p.area(), 4.5, max_relative = 1e-12);
    let expected = Point2::new(9e3 + 1.0, 9e3 + 1.0);
    approx::assert_relative_eq!(p.centroid(), expected, max_relative = 1e-14);
}

#[test]
fn the_closing_edge_is_a_constraint() {
    let p = rectangle(2.0, 1.0);
    let closing = p.half_planes()[3];
    assert_eq!((closing.n.x, closing.n.y), (-1.0, 0.0));
    assert!(!p.contains(&Point2::new(-0.1, 0.5), 0.0));
}

#[test]
fn signed_distance_outside_a_corner_is_euclidean() {
    let p = rectangle(2.0, 1.0);
    approx::assert_relative_eq!(p.signed_distance(&Point2::new(-3.0, -4.0)), 5.0);
    approx::assert_relative_eq!(p.signed_distance(&Point2::new(0.7, 0.4)), -0.4);
}

#[test]
fn an_inset_beyond_half_the_width_is_empty() {
    let p = rectangle(2.0, 1.0);
    let inner = p.inset(0.2).unwrap();
    approx::assert_relative_eq!(inner.area(), 1.6 * 0.6, max_relative = 1e-12);
    assert_eq!(p.inset(0.51), None);
    assert_eq!(p.inset(-0.1), None);
    assert_eq!(p.inset(f64::NAN), None);
    let (centre, radius) = p.inscribed_circle();
    approx::assert_relative_eq!(radius, 0.5, max_relative = 1e-6);
    approx::assert_relative_eq!(centre.y, 0.5, max_relative = 1e-6);
}

#[test]
fn simplifying_an_octagon_to_a_square_keeps_the_largest_one() {
    let turn = |i: usize| Rotation2::new(std::f64::consts::FRAC_PI_4 * i as f64);
    let octagon: Vec<_> = (0..8).map(|i| turn(i) * Point2::new(1.0, 0.0)).collect();
    let square = ConvexPolygon::new(octagon).unwrap().simplified_inside(4);
    // A square inscribed in the unit circle has the area 2; any other choice of four has less.
    approx::assert_relative_eq!(square.area(), 2.0, max_relative = 1e-12);
}

#[test]
fn serde_goes_through_the_checks() {
    let p = rectangle(2.0, 1.0);
    let text = serde_json::to_string(&p).unwrap();
    assert_eq!(text, "[[0.0,0.0],[2.0,0.0],[2.0,1.0],[0.0,1.0]]");
    assert_eq!(serde_json::from_str::<ConvexPolygon>(&text).unwrap(), p);
    let error = serde_json::from_str::<ConvexPolygon>("[[0,0],[0,1],[1,0]]").unwrap_err();
    assert!(error.to_string().contains("clockwise"), "{error}");
}

proptest! {
    #[test]
    fn a_hull_is_valid_and_contains_its_points(list in points(3..60)) {
        if let Ok(hull) = ConvexPolygon::hull(&list) {
            for p in &list {
                prop_assert!(hull.contains(p, VERTEX_SEPARATION_M));
            }
            for v in hull.vertices() {
                prop_assert!(list.contains(v));
            }
        }
    }

    #[test]
    fn validation_never_panics_and_accepts_no_concave_ring(list in points(0..8)) {
        if let Ok(p) = ConvexPolygon::new(list.clone()) {
            let hull = ConvexPolygon::hull(&list).unwrap();
            prop_assert!((p.area() - hull.area()).abs() < 1e-5);
        }
    }

    #[test]
    fn reversing_a_polygon_makes_it_clockwise(p in polygons()) {
        let mut vertices = p.vertices().to_vec();
        vertices.reverse();
        let refused = ConvexPolygon::new(vertices).unwrap_err().to_string();
        prop_assert!(refused.contains("clockwise about"), "{}", refused);
    }

    #[test]
    fn inside_is_negative_half_planes_and_negative_distance(p in polygons(), q in points(1..2)) {
        let worst = p.half_planes().iter().map(|h| h.value(&q[0])).fold(f64::MIN, f64::max);
        let distance = p.signed_distance(&q[0]);
        prop_assert_eq!(worst <= 0.0, distance <= 0.0);
        if worst <= 0.0 {
            // Inside, the nearest boundary point is on the nearest edge's line.
            prop_assert!((distance - worst).abs() < 1e-9);
        } else {
            prop_assert!(distance >= worst - 1e-9);
        }
    }

    #[test]
    fn an_inset_keeps_its_distance_and_loses_nothing_more(
        p in polygons(), q in points(20..21), d in 0.0..0.5,
    ) {
        let inner = p.inset(d);
        for point in &q {
            let depth = -p.signed_distance(point);
            let kept = inner.as_ref().is_some_and(|i| i.contains(point, 1e-6));
            // 1e-5: an inset whose width falls below the separation of vertices counts as empty.
            prop_assert!(!kept || depth >= d - 2e-6, "kept at {depth} with an inset of {d}");
            prop_assert!(kept || depth <= d + 1e-5, "lost at {depth} with an inset of {d}");
        }
    }

    #[test]
    fn an_intersection_is_what_both_contain(a in polygons(), b in polygons(), q in points(20..21)) {
        let both = a.intersection(&b);
        for p in &q {
            let depth = -a.signed_distance(p).max(b.signed_distance(p));
            let inside = both.as_ref().is_some_and(|i| i.contains(p, 0.0));
            prop_assert!(!inside || depth >= -2e-6);
            prop_assert!(inside || depth <= 2e-6);
        }
        let area = |p: &Option<ConvexPolygon>| p.as_ref().map_or(0.0, ConvexPolygon::area);
        prop_assert!((area(&both) - area(&b.intersection(&a))).abs() < 1e-4);
    }

    #[test]
    fn a_clip_and_its_other_half_make_the_whole(p in polygons(), cut in points(2..3)) {
        let half = HalfPlane::left_of(&cut[0], &cut[1]);
        let area = |h: &HalfPlane| p.clip(h).map_or(0.0, |c| c.area());
        prop_assert!((area(&half) + area(&half.flipped()) - p.area()).abs() < 2e-5);
    }

    #[test]
    fn simplifying_never_grows_and_keeps_a_fair_share(p in polygons(), wanted in 3_usize..12) {
        let simple = p.simplified_inside(wanted);
        prop_assert!(simple.vertices().len() <= wanted.max(3));
        prop_assert!(ConvexPolygon::new(simple.vertices().to_vec()).is_ok());
        for v in simple.vertices() {
            prop_assert!(p.contains(v, 1e-12));
        }
        // No convex shape loses more than the disc does to its best inscribed polygon
        // (Sas 1939), and dropping the cheapest first stays within 5 % of the best.
        let k = wanted as f64;
        let disc = (k / std::f64::consts::TAU) * (std::f64::consts::TAU / k).sin();
        prop_assert!(simple.area() >= 0.95 * disc * p.area());
    }

    #[test]
    fn the_inscribed_circle_touches_and_stays_inside(p in polygons()) {
        let (centre, radius) = p.inscribed_circle();
        prop_assert!(radius > 0.0);
        prop_assert!((p.signed_distance(&centre) + radius).abs() < 1e-9);
        prop_assert_eq!(p.inset(1.001 * radius + 2e-6), None);
    }
}
