//! A region with holes, covered by few large convex pieces.

mod grow;
mod lattice;
mod ring;

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use surfaces::ConvexPolygon;

use crate::Error;
use crate::error::within;
use grow::{Edge, Grown, Region};
use lattice::Lattice;
use ring::Ring;

/// How a face is covered by convex polygons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoverConfig {
    /// The cover stops when this ratio of the face is covered.
    pub ratio: f64,
    /// Most pieces of one face.
    pub pieces_max: usize,
    /// Most corners of one piece; corners are dropped, so that a piece only shrinks.
    pub vertices_max: usize,
    /// Smallest piece, and smallest area that any further piece must add, m².
    pub area_min_m2: f64,
    /// A further piece must add this ratio of the face, or `gain_min_m2`.
    pub gain_min_ratio: f64,
    /// A further piece that adds this much is worth it on a face of any size, m².
    pub gain_min_m2: f64,
    /// Smallest width of a piece (diameter of the largest inscribed circle), m.
    pub width_min_m: f64,
}

impl Default for CoverConfig {
    fn default() -> Self {
        Self {
            ratio: 0.93,
            pieces_max: 12,
            vertices_max: 12,
            area_min_m2: 0.005,
            gain_min_ratio: 0.03,
            gain_min_m2: 0.06,
            width_min_m: 0.04,
        }
    }
}

impl CoverConfig {
    pub(in crate::organised) fn check(&self) -> Result<(), Error> {
        within("ratio", self.ratio, 0.01, 1.0, "must be in [0.01, 1]")?;
        within(
            "pieces_max",
            self.pieces_max as f64,
            1.0,
            1000.0,
            "must be in [1, 1000]",
        )?;
        within(
            "vertices_max",
            self.vertices_max as f64,
            3.0,
            1000.0,
            "must be in [3, 1000]",
        )?;
        within(
            "area_min_m2",
            self.area_min_m2,
            0.0,
            1e6,
            "must not be negative",
        )?;
        within(
            "gain_min_ratio",
            self.gain_min_ratio,
            0.0,
            1.0,
            "must be in [0, 1]",
        )?;
        within(
            "gain_min_m2",
            self.gain_min_m2,
            0.0,
            1e6,
            "must not be negative",
        )?;
        within(
            "width_min_m",
            self.width_min_m,
            0.0,
            1e3,
            "must not be negative",
        )
    }
}

/// Places that further pieces are grown from, before the best of all is taken.
const SEEDS: usize = 4;
/// Area that other pieces cover already counts this much: pieces overlap, not end at seams.
const OVERLAP_WORTH: f64 = 0.05;

/// Convex pieces of the region between the rings (the outer one first, then holes), greedily:
/// each adds most to those before it. They overlap rather than meet at seams, and no edge of the
/// region reaches more than `slack_m` into one.
pub(in crate::organised) fn cover(
    rings: &[Vec<Point2<f64>>],
    slack_m: f64,
    config: &CoverConfig,
) -> Vec<ConvexPolygon> {
    let Some(Ok(hull)) = rings.first().map(|outer| ConvexPolygon::hull(outer)) else {
        return Vec::new();
    };
    let edges: Vec<Edge> = rings
        .iter()
        .flat_map(|ring| {
            ring.iter()
                .copied()
                .zip(ring.iter().copied().cycle().skip(1))
        })
        .collect();
    let hull = Ring(hull.vertices().to_vec());
    let mut region = Region::new(hull, &edges, slack_m);
    // What is convex but for the slack is one piece.
    if region.is_convex() {
        let piece = region.hull().clone();
        return usable(&piece, config).into_iter().collect();
    }
    let mut open = Lattice::new(region.hull(), &edges);
    let total_m2 = open.area();
    let worthwhile = (config.gain_min_ratio * total_m2).min(config.gain_min_m2);
    let gain_min_m2 = config.area_min_m2.max(worthwhile);
    let mut pieces: Vec<ConvexPolygon> = Vec::new();
    let mut grown: Vec<Grown> = Vec::new();
    while pieces.len() < config.pieces_max {
        // Grow from the places that are farthest from every edge and in no piece grown so far.
        let worth = |piece: &Ring| open.gain(piece) + OVERLAP_WORTH * piece.area();
        for seed in open.seeds(SEEDS) {
            if !grown.iter().any(|g| g.ring.contains(&seed)) {
                grown.extend(region.grow(&seed, &worth));
            }
        }
        // Take the one that adds most, its cuts turned to where they cost least.
        let most = grown
            .iter()
            .map(|g| worth(&g.ring))
            .enumerate()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        let Some((index, _)) = most else { break };
        let ring = region.polished(grown.swap_remove(index), &worth);
        let Some(piece) = usable(&ring, config) else {
            break;
        };
        let ring = Ring(piece.vertices().to_vec());
        if !pieces.is_empty() && open.gain(&ring) < gain_min_m2 {
            break;
        }
        open.close(&ring);
        pieces.push(piece);
        // Enough, or less left than a further piece must add.
        if open.area() <= (1.0 - config.ratio) * total_m2 || open.area() < gain_min_m2 {
            break;
        }
    }
    pieces
}

/// The polygon of a piece, with as few corners as asked for, if it is large enough.
fn usable(ring: &Ring, config: &CoverConfig) -> Option<ConvexPolygon> {
    let piece = ConvexPolygon::hull(&ring.0).ok()?;
    let piece = piece.simplified_inside(config.vertices_max);
    let large =
        piece.area() >= config.area_min_m2 && piece.inset(0.5 * config.width_min_m).is_some();
    large.then_some(piece)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::grow::closest;
    use super::*;

    fn ring(corners: &[[f64; 2]]) -> Vec<Point2<f64>> {
        corners.iter().map(|&c| Point2::from(c)).collect()
    }

    /// Area of the region, and of what the pieces cover of it, on a fine lattice; panics where a
    /// piece leaves the region by more than the slack.
    fn covered(rings: &[Vec<Point2<f64>>], pieces: &[ConvexPolygon]) -> f64 {
        let edges: Vec<Edge> = rings
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
                let near = |(a, b): &Edge| (p - closest(a, b, &p)).norm();
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
        let pieces = cover(&rings, 1e-3, &CoverConfig::default());
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
            let pieces = cover(&rings, 1e-3, &CoverConfig::default());
            let ratio = covered(&rings, &pieces);
            assert!(pieces.len() <= most, "{} pieces", pieces.len());
            assert!(ratio > 0.95, "{ratio}");
        }
    }
}
