use geo::{Area, BooleanOps, Coord, LineString, Polygon};
use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::Error;

fn ring(points: &[[f64; 2]]) -> Vec<Point2<f64>> {
    points.iter().map(|p| Point2::from(*p)).collect()
}

fn region(rings: &[&[[f64; 2]]]) -> Region {
    Region::new(rings.iter().map(|r| ring(r))).unwrap()
}

fn everything() -> Config {
    Config {
        coverage: 1.0 - 1e-9,
        gain_min_m2: 1e-9,
        pieces_max: 1000,
        vertices_max: 1000,
        seeds_max: 48,
    }
}

fn to_geo(points: &[Point2<f64>]) -> LineString<f64> {
    points.iter().map(|p| Coord { x: p.x, y: p.y }).collect()
}

/// Area of the pieces' union and of their parts outside the region, by an independent library.
fn union_and_excess(region: &Region, cover: &Cover) -> (f64, f64) {
    let holes = region.rings()[1..]
        .iter()
        .map(|r| to_geo(&r.vertices))
        .collect();
    let whole = Polygon::new(to_geo(&region.rings()[0].vertices), holes);
    let pieces: Vec<Polygon<f64>> = cover
        .pieces
        .iter()
        .map(|p| Polygon::new(to_geo(p.polygon.vertices()), vec![]))
        .collect();
    let union = geo::unary_union(&pieces);
    (
        union.unsigned_area(),
        union.difference(&whole).unsigned_area(),
    )
}

const L: &[[f64; 2]] = &[
    [0.0, 0.0],
    [2.0, 0.0],
    [2.0, 1.0],
    [1.0, 1.0],
    [1.0, 2.0],
    [0.0, 2.0],
];

#[test]
fn an_l_is_two_overlapping_rectangles() {
    let cover = cover(&region(&[L]), &everything());
    let areas: Vec<f64> = cover.pieces.iter().map(|p| p.polygon.area()).collect();
    assert_eq!(areas.len(), 2, "{areas:?}");
    for area in areas {
        approx::assert_relative_eq!(area, 2.0, max_relative = 1e-6);
    }
    approx::assert_relative_eq!(cover.pieces[1].gain_m2, 1.0, max_relative = 1e-6);
    approx::assert_relative_eq!(cover.coverage, 1.0, max_relative = 1e-9);
}

#[test]
fn a_u_is_three_pieces_and_a_frame_four() {
    let u: &[[f64; 2]] = &[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    assert_eq!(cover(&region(&[u]), &everything()).pieces.len(), 3);
    let outer: &[[f64; 2]] = &[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
    let hole: &[[f64; 2]] = &[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]];
    let frame = cover(&region(&[outer, hole]), &everything());
    assert_eq!(frame.pieces.len(), 4);
    // Each is a whole side, three by one: they overlap at the corners.
    for piece in &frame.pieces {
        approx::assert_relative_eq!(piece.polygon.area(), 3.0, max_relative = 1e-6);
    }
}

#[test]
fn a_convex_region_is_one_piece_as_it_stands() {
    let square: &[[f64; 2]] = &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let cover = cover(&region(&[square]), &BODIES);
    assert_eq!(cover.pieces.len(), 1);
    assert_eq!(cover.pieces[0].polygon.vertices(), &ring(square)[..]);
    assert_eq!(cover.coverage, 1.0);
}

#[test]
fn pieces_that_add_too_little_are_left_out() {
    // A square metre with a tab of one square centimetre.
    let tab: &[[f64; 2]] = &[
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.5],
        [1.01, 0.5],
        [1.01, 0.51],
        [1.0, 0.51],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    let config = Config {
        coverage: 1.0,
        gain_min_m2: 2e-4,
        ..everything()
    };
    let cover = cover(&region(&[tab]), &config);
    assert_eq!(cover.pieces.len(), 1);
    approx::assert_relative_eq!(cover.coverage, 1.0 / 1.0001, max_relative = 1e-6);
}

#[test]
fn no_piece_has_more_vertices_than_allowed() {
    let disc: Vec<[f64; 2]> = (0..90)
        .map(|i| (std::f64::consts::TAU * f64::from(i) / 90.0).sin_cos())
        .map(|(s, c)| [c, s])
        .collect();
    let config = Config {
        vertices_max: 8,
        ..BODIES
    };
    let cover = cover(&region(&[&disc]), &config);
    // The disc is convex: the largest octagon in it is all that one piece can give, 90 %, and a
    // second one turned against it would add too little.
    assert_eq!(cover.pieces.len(), 1);
    assert_eq!(cover.pieces[0].polygon.vertices().len(), 8);
    let (union, excess) = union_and_excess(&region(&[&disc]), &cover);
    let share = union / region(&[&disc]).area();
    approx::assert_relative_eq!(share, cover.coverage, max_relative = 1e-6);
    assert!(share > 0.89 && excess < 1e-9, "{share} {excess}");
}

#[test]
fn bad_rings_are_refused_by_name() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.2]];
    let closed = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
    let outside = [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]];
    let cases: Vec<(Vec<Vec<Point2<f64>>>, &str)> = vec![
        (vec![], "at least 3 vertices"),
        (
            vec![ring(&square), ring(&square[..2])],
            "ring 1: a polygon needs at least 3",
        ),
        (
            vec![ring(&[[0.0, f64::NAN], [1.0, 0.0], [1.0, 1.0]])],
            "ring 0: vertex 0 is not within",
        ),
        (vec![ring(&closed)], "ring 0: vertex 3 repeats vertex 0"),
        (
            vec![ring(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])],
            "on one line",
        ),
        (vec![ring(&bow_tie)], "crosses itself"),
        (vec![ring(&square), ring(&outside)], "crosses itself"),
    ];
    for (rings, message) in cases {
        let error: Error = Region::new(rings.clone()).unwrap_err();
        assert!(error.to_string().contains(message), "{rings:?}: {error}");
    }
}

/// Star-shaped rings: any radii about a centre make a simple, usually concave one.
fn stars() -> impl Strategy<Value = Region> {
    let hole = prop::option::of(prop::collection::vec(0.1..0.25_f64, 3..8));
    (prop::collection::vec(0.3..2.0_f64, 5..16), hole).prop_filter_map(
        "crossing",
        |(outer, hole)| {
            let star = |radii: Vec<f64>| -> Vec<Point2<f64>> {
                let count = radii.len() as f64;
                let at = |(i, r): (usize, f64)| {
                    let (s, c) = (std::f64::consts::TAU * i as f64 / count).sin_cos();
                    Point2::new(r * c, r * s)
                };
                radii.into_iter().enumerate().map(at).collect()
            };
            let rings = std::iter::once(star(outer)).chain(hole.map(star));
            Region::new(rings).ok()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn pieces_stay_in_the_region_and_cover_what_is_claimed(region in stars()) {
        let cover = cover(&region, &everything());
        let (union, excess) = union_and_excess(&region, &cover);
        // A piece leaves the region by 1e-7 m at most; the perimeters here are below 100 m.
        prop_assert!(excess < 1e-5, "excess {excess}");
        prop_assert!((union / region.area() - cover.coverage).abs() < 1e-5);
        prop_assert!(cover.coverage > 1.0 - 1e-5, "coverage {}", cover.coverage);
        // Never more pieces than a triangulation has.
        prop_assert!(cover.pieces.len() <= region.triangles().len());
    }

    #[test]
    fn gains_add_up_to_the_coverage_before_anything_is_dropped(region in stars()) {
        let config = Config { pieces_max: 2, ..everything() };
        let cover = cover(&region, &config);
        let gains: f64 = cover.pieces.iter().map(|p| p.gain_m2).sum();
        prop_assert!((gains / region.area() - cover.coverage).abs() < 1e-6);
    }
}
