//! Tests of rings.

use super::super::face::tests::of_labels as faces;
use super::*;

fn rings_of(picture: &[&str]) -> Vec<Vec<Point2<f64>>> {
    let labels: Vec<u16> = picture
        .iter()
        .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
        .collect();
    let faces = faces(&labels, picture[0].len());
    assert_eq!(faces.len(), 1);
    rings(&faces[0], 0.3, 0.0)
}

#[test]
fn a_square_with_a_hole_has_two_rings_of_opposite_turn() {
    let rings = rings_of(&[
        "#######", "#######", "##...##", "##...##", "#######", "#######",
    ]);
    assert_eq!(rings.len(), 2);
    // Through pixel centres, cut across the corners of the hole: 6 × 5, and 4 × 3 − 4/2.
    assert_eq!(area(&rings[0]).abs(), 30.0);
    assert_eq!(area(&rings[1]).abs(), 10.0);
    assert!(area(&rings[0]) * area(&rings[1]) < 0.0);
}

#[test]
fn an_l_keeps_its_corner() {
    let rings = rings_of(&["##....", "##....", "##....", "######", "######"]);
    assert_eq!(rings.len(), 1);
    // 1 × 4 and 4 × 1, and half a pixel cut across the inner corner.
    assert_eq!(area(&rings[0]).abs(), 8.5);
}

#[test]
fn a_shallow_notch_is_filled_and_a_deep_one_is_not() {
    let picture = ["##########", "####..####", "##########"];
    let deep = ["###....###", "###....###", "##########", "##########"];
    for (picture, corners) in [(&picture[1..], 4), (&deep[..], 8)] {
        let labels: Vec<u16> = picture
            .iter()
            .flat_map(|row| row.bytes().map(|b| if b == b'#' { 0 } else { u16::MAX }))
            .collect();
        let face = &faces(&labels, 10)[0];
        assert_eq!(rings(face, 1.2, 0.3)[0].len(), corners);
    }
}

#[test]
fn a_low_bulge_is_cut_off_and_a_narrow_face_keeps_its_corners() {
    const WIDTH: usize = 160;
    let wide = "#".repeat(WIDTH).repeat(WIDTH);
    let bulge = format!("{}###{}", ".".repeat(80), ".".repeat(77)).repeat(2);
    let narrow = "#".repeat(WIDTH).repeat(5);
    for (picture, px, corners) in [
        (bulge.clone() + &wide, 3.0, 4),
        (bulge + &wide, 1.0, 8),
        (narrow, 3.0, 4),
    ] {
        let label = |b: u8| if b == b'#' { 0 } else { u16::MAX };
        let labels: Vec<u16> = picture.bytes().map(label).collect();
        let rings = rings(&faces(&labels, WIDTH)[0], 0.5, px);
        assert_eq!(rings[0].len(), corners, "{px}");
    }
}

#[test]
fn a_ring_is_nowhere_farther_off_the_traced_one_than_allowed() {
    // Ragged discs, from a congruential generator.
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 16) / 65536.0
    };
    let (notch_px, bulge_px) = (1.5, 3.5);
    let limits = Limits::new(notch_px, bulge_px);
    let (mut notch, mut bulge) = (0.0_f64, 0.0_f64);
    for radius in [9.0, 20.0, 30.0] {
        let mut held = |u: i32, v: i32| {
            let (x, y) = (f64::from(u - 40), f64::from(v - 40));
            x.hypot(y) + 6.0 * random() - 3.0 < radius
        };
        let labels: Vec<u16> = (0..80 * 80)
            .map(|i| if held(i % 80, i / 80) { 0 } else { u16::MAX })
            .collect();
        for trace in faces(&labels, 80).iter().flat_map(traces) {
            let mut ring = Ring::new(trace, limits);
            ring.drop_corners();
            let n = ring.points.count;
            let ends = ring.kept.iter().skip(1).chain(ring.kept.first());
            for (&a, &b) in ring.kept.iter().zip(ends) {
                let steps = (b + n - a) % n;
                let [from, to] = [a, b].map(|k| ring.points.at(k));
                for p in (1..steps).map(|k| ring.points.at((a + k) % n)) {
                    let (left, distance) = off(&from, &to, &p);
                    let most = if left { &mut notch } else { &mut bulge };
                    *most = most.max(distance);
                }
            }
        }
    }
    // And what is allowed is used.
    assert!((1.0..=notch_px).contains(&notch), "{notch}");
    assert!((2.5..=bulge_px).contains(&bulge), "{bulge}");
}

/// Whether a point is on the left of a segment, and its distance from it.
fn off(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> (bool, f64) {
    let (along, from) = (b - a, p - a);
    let t = (from.dot(&along) / along.norm_squared().max(1e-9)).clamp(0.0, 1.0);
    (along.perp(&from) > 0.0, (from - along * t).norm())
}

#[test]
fn the_worst_of_a_range_is_the_first_that_is_farthest_off() {
    let limits = Limits::new(2.0, 1.0);
    let zigzag = (0..23).map(|i: i32| Point2::new(f64::from(i % 7), f64::from(i * i % 11) - 5.0));
    let points: Vec<Point2<f64>> = zigzag.collect();
    let chain = Chain::new(&points);
    for (a, b) in (0..23).flat_map(|a| (a..23).map(move |b| (a, b))) {
        let excess = |k: usize| {
            let (left, distance) = off(&points[a], &points[b], &points[k]);
            (distance / if left { 2.0 } else { 1.0 }).powi(2)
        };
        let chord = Chord::new(&points[a], &points[b], limits);
        let range = (a + 1).min(b)..b;
        let most = range.clone().map(excess).fold(0.0, f64::max);
        assert!((chain.farthest(&chord, range.clone()) - most).abs() < 1e-9);
        let worst = range.clone().find(|k| excess(*k) > most - 1e-9);
        let worst = worst.filter(|_| most > 1.0);
        let found = chain.worst(&chord, range);
        assert_eq!(found.map(excess), worst.map(excess), "{a} to {b}");
    }
}

#[test]
fn rings_part_the_face_from_all_other_pixels() {
    // Specks and holes of all forms, from a congruential generator.
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 24
    };
    const WIDTH: usize = 14;
    for full in (60..230).step_by(10) {
        let labels: Vec<u16> = (0..WIDTH * 12)
            .map(|_| if random() < full { 0 } else { u16::MAX })
            .collect();
        for face in faces(&labels, WIDTH) {
            let rings = rings(&face, 0.0, 0.0);
            let held = |u: usize, v: usize| {
                let mut runs = face.runs.iter();
                runs.any(|r| r.0 as usize == v && (r.1..r.2).contains(&(u as u32)))
            };
            for (u, v) in (0..WIDTH * 12).map(|i| (i % WIDTH, i / WIDTH)) {
                let edges = (rings.iter()).flat_map(|r| r.iter().zip(r.iter().cycle().skip(1)));
                let (x, y) = (u as f64, v as f64);
                let crossed = edges.filter(|(a, b)| {
                    (a.y > y) != (b.y > y) && x < a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)
                });
                let inside = crossed.count() % 2 == 1;
                let around = |u: usize, v: usize| {
                    let beside = (0..9).map(|k| (u + k % 3, v + k / 3));
                    beside
                        .into_iter()
                        .all(|(u, v)| u > 0 && v > 0 && held(u - 1, v - 1))
                };
                assert!(held(u, v) || !inside, "{u} {v} is not the face's");
                assert!(
                    !around(u, v) || inside,
                    "{u} {v} is in the middle of the face"
                );
            }
        }
    }
}
