//! A region with holes, covered by few large convex pieces.

mod grow;
mod open;
mod polish;
mod ring;
mod rows;
mod segments;

use nalgebra::Point2;
use surfaces::ConvexPolygon;

use crate::Config;
use grow::{Piece, Region};
use open::Open;
use polish::polished;
pub(super) use ring::Ring;
use rows::{Frame, Rows};
use segments::Point;

/// The cover stops when this ratio of the face is covered.
const RATIO: f64 = 0.93;
/// Most pieces of one face, and most corners of one: corners are dropped, so that a piece only shrinks.
const PIECES_MAX: usize = 12;
const VERTICES_MAX: usize = 12;
/// A further piece must add this ratio of the face, or this much on a face of any size, m².
const GAIN_MIN_RATIO: f64 = 0.03;
const GAIN_MIN_M2: f64 = 0.06;

/// Places that further pieces are grown from, before the best of all is taken.
const SEEDS: usize = 4;
/// Area that other pieces cover already counts this much: pieces overlap, not end at seams.
const OVERLAP_WORTH: f32 = 0.05;

/// Convex pieces of the region between the rings (the outer one first, then holes), greedily:
/// each adds most to those before it. They overlap rather than meet at seams, and no edge of the
/// region reaches more than `slack_m` into one.
///
/// Pieces are grown and compared in 32 bits about the middle of the region, cut out in 64.
pub(in crate::organised) fn cover(
    rings: &[Vec<Point2<f64>>],
    slack_m: f64,
    config: &Config,
) -> Vec<Ring> {
    let Some(outer) = rings.first() else {
        return Vec::new();
    };
    let mut hull = Ring::default();
    hull.hull(&mut outer.clone());
    let (low, high) = hull.bounds();
    let middle = low + 0.5 * (high - low);
    let near = |p: &Point2<f64>| [(p.x - middle.x) as f32, (p.y - middle.y) as f32];
    let mut edges: Vec<(Point, Point)> = Vec::with_capacity(rings.iter().map(Vec::len).sum());
    for ring in rings {
        let next = ring.iter().cycle().skip(1);
        edges.extend(ring.iter().zip(next).map(|(a, b)| (near(a), near(b))));
    }
    let frame = Frame::new(near(&low)[1], near(&high)[1]);
    let mut region = Region::new(&frame, &hull.sides(near), &edges, slack_m as f32);
    // What is convex but for the slack is one piece.
    if region.is_convex() {
        return usable(hull, config).into_iter().collect();
    }
    let mut open = Open::new(&frame, &edges);
    let total_m2 = f64::from(open.area(&frame));
    let worthwhile = (GAIN_MIN_RATIO * total_m2).min(GAIN_MIN_M2);
    let gain_min_m2 = config.area_min_m2.max(worthwhile);
    let mut pieces: Vec<Ring> = Vec::new();
    let mut started: Vec<Piece> = Vec::with_capacity(2 * SEEDS);
    while pieces.len() < PIECES_MAX {
        // Start from the places that are farthest from every edge and in no piece so far.
        let worth = |rows: &Rows| open.gain(&frame, rows) + OVERLAP_WORTH * rows.area(&frame);
        for seed in open.seeds(&frame, SEEDS) {
            if !started.iter().any(|piece| piece.keeps(&seed)) {
                started.extend(region.start(&seed));
            }
        }
        // Grow the one that adds most, and turn its cuts to where they cost least.
        let most = started
            .iter()
            .map(|piece| worth(&piece.rows))
            .enumerate()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        let Some((index, _)) = most else { break };
        // What adds too little as it is started is not worth growing.
        let gain = |rows: &Rows| f64::from(open.gain(&frame, rows));
        if !pieces.is_empty() && gain(&started[index].rows) < gain_min_m2 {
            break;
        }
        let start = started.swap_remove(index);
        let grown = region.grow(&start, &worth);
        let best = grown.as_ref().unwrap_or(&start);
        let turned =
            polished(&region, best).filter(|turned| worth(&turned.rows) >= worth(&best.rows));
        let forms = [turned.as_ref(), grown.as_ref(), Some(&start)];
        let ring = |piece: &Piece| usable(hull.clone().without(&piece.cuts, &middle), config);
        let Some(ring) = forms.into_iter().flatten().find_map(ring) else {
            break;
        };
        let mut rows = Rows::ALL;
        for side in ring.sides(near) {
            rows.cut(&frame, &side);
        }
        if !pieces.is_empty() && gain(&rows) < gain_min_m2 {
            break;
        }
        open.close(&rows);
        pieces.push(ring);
        // Enough, or less left than a further piece must add.
        let left_m2 = f64::from(open.area(&frame));
        if left_m2 <= (1.0 - RATIO) * total_m2 || left_m2 < gain_min_m2 {
            break;
        }
    }
    pieces
}

/// A piece with as few corners as asked for, if it is large enough.
fn usable(mut piece: Ring, config: &Config) -> Option<Ring> {
    if piece.0.len() > VERTICES_MAX {
        let polygon = ConvexPolygon::hull(&piece.0).ok()?;
        let polygon = polygon.simplified_inside(VERTICES_MAX);
        piece = Ring(polygon.vertices().to_vec());
    }
    let large = piece.area() >= config.area_min_m2 && piece.is_wide(config.width_min_m);
    large.then_some(piece)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn ring(corners: &[[f64; 2]]) -> Vec<Point2<f64>> {
        corners.iter().map(|&c| Point2::from(c)).collect()
    }

    fn cover_of(rings: &[Vec<Point2<f64>>]) -> Vec<ConvexPolygon> {
        let pieces = cover(rings, 1e-3, &Config::default());
        let polygon = |piece: &Ring| ConvexPolygon::hull(&piece.0).unwrap();
        pieces.iter().map(polygon).collect()
    }

    /// The point of a segment that is nearest to p.
    fn closest(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> Point2<f64> {
        let along = b - a;
        let t = (p - a).dot(&along) / along.norm_squared();
        a + along * t.clamp(0.0, 1.0)
    }

    /// Area of the region, and of what the pieces cover of it, on a fine lattice; panics where a
    /// piece leaves the region by more than the slack.
    fn covered(rings: &[Vec<Point2<f64>>], pieces: &[ConvexPolygon]) -> f64 {
        let edges: Vec<(Point2<f64>, Point2<f64>)> = rings
            .iter()
            .flat_map(|r| r.iter().copied().zip(r.iter().copied().cycle().skip(1)))
            .collect();
        let inside = |p: &Point2<f64>| {
            let crossed = edges.iter().filter(|(a, b)| {
                (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
            });
            crossed.count() % 2 == 1
        };
        let (mut region, mut both) = (0, 0);
        for i in 0..200 {
            for j in 0..200 {
                let p = Point2::new(0.0, 0.0) + Vector2::new(i as f64 + 0.5, j as f64 + 0.5) * 0.01;
                let held = pieces.iter().any(|piece| piece.contains(&p, 0.0));
                let near = |(a, b): &(Point2<f64>, Point2<f64>)| (p - closest(a, b, &p)).norm();
                let near = edges.iter().map(near).fold(f64::INFINITY, f64::min);
                assert!(
                    !held || inside(&p) || near < 0.002,
                    "{p} is covered and outside"
                );
                region += usize::from(inside(&p));
                both += usize::from(inside(&p) && held);
            }
        }
        both as f64 / region as f64
    }

    #[test]
    fn a_convex_region_is_one_piece_and_itself() {
        let rings = [ring(&[[0.1, 0.1], [1.8, 0.2], [1.6, 1.4], [0.2, 1.7]])];
        let pieces = cover_of(&rings);
        assert_eq!(pieces.len(), 1);
        assert!((pieces[0].area() - ConvexPolygon::hull(&rings[0]).unwrap().area()).abs() < 1e-9);
    }

    #[test]
    fn l_u_and_ring_are_covered_by_few_pieces_that_stay_inside() {
        let l = ring(&[
            [0., 0.],
            [2., 0.],
            [2., 0.5],
            [0.6, 0.5],
            [0.6, 2.],
            [0., 2.],
        ]);
        let u = ring(&[
            [0., 0.],
            [2., 0.],
            [2., 2.],
            [1.5, 2.],
            [1.5, 0.5],
            [0.5, 0.5],
            [0.5, 2.],
            [0., 2.],
        ]);
        let square = ring(&[[0., 0.], [2., 0.], [2., 2.], [0., 2.]]);
        let hole = ring(&[[0.6, 0.6], [0.6, 1.3], [1.3, 1.3], [1.3, 0.6]]);
        for (rings, most) in [(vec![l], 2), (vec![u], 3), (vec![square, hole], 4)] {
            let pieces = cover_of(&rings);
            let ratio = covered(&rings, &pieces);
            assert!(pieces.len() <= most, "{} pieces", pieces.len());
            assert!(ratio > 0.95, "{ratio}");
        }
    }
}
