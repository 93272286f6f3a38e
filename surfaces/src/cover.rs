//! A plane region with holes, covered by a few large convex pieces that may overlap.
//!
//! Feet need convex polygons; a partition would put seams where a foot could stand. So every piece
//! is as large as it can be made: it is grown from a part of the region until edges of the region
//! stop it, and of all pieces grown the one that adds the most area is taken, again and again.

mod fragments;
mod grow;

use nalgebra::Point2;

use crate::ConvexPolygon;
pub use crate::Region;
use crate::polygon::ring_area;
use fragments::Fragments;
pub(crate) use grow::{Boundary, distance_to_segment};

/// When a cover is good enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Part of the region's area to cover, 0…1.
    pub coverage: f64,
    /// A piece that adds less than this area is not worth having, m².
    pub gain_min_m2: f64,
    /// Largest number of pieces.
    pub pieces_max: usize,
    /// Largest number of vertices of a piece, at least 3; pieces with more are simplified from
    /// the inside.
    pub vertices_max: usize,
    /// Largest number of triangles of the region that pieces are grown from at first, the largest
    /// ones; what these leave is grown from afterwards. Each costs about (edges of the region)².
    pub seeds_max: usize,
}

/// The cover of a region by bodies to avoid.
pub const BODIES: Config = Config {
    coverage: 0.98,
    gain_min_m2: 0.002,
    pieces_max: 12,
    vertices_max: 12,
    seeds_max: 12,
};

/// What two parts side by side may lack of a convex whole, m²: rounding.
const JOINT_M2: f64 = 1e-9;

/// One piece of a cover.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The piece; it does not leave the region by more than a micrometre.
    pub polygon: ConvexPolygon,
    /// The area it adds to the pieces before it, m².
    pub gain_m2: f64,
}

/// Convex pieces of a region, the one that added the most first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cover {
    /// The pieces; they may overlap.
    pub pieces: Vec<Piece>,
    /// Part of the region's area that they cover, 0…1.
    pub coverage: f64,
}

/// Covers a region by convex pieces.
///
/// Every piece lies in the region; at most `pieces_max` are taken, the most useful first, until
/// `coverage` is reached or no piece would add `gain_min_m2`.
pub fn cover(region: &Region, config: &Config) -> Cover {
    let area = region.area();
    let vertices_max = config.vertices_max.max(3);
    // A region that is convex already needs no search.
    if let Some(whole) = region.as_convex() {
        let polygon = whole.simplified_inside(vertices_max);
        let gain_m2 = polygon.area();
        if polygon.vertices().len() == whole.vertices().len() && gain_m2 >= config.gain_min_m2 {
            let pieces = vec![Piece { polygon, gain_m2 }];
            return Cover {
                pieces,
                coverage: 1.0,
            };
        }
    }
    let boundary = Boundary::new(region.rings().iter().map(|ring| &ring.vertices[..]));
    let triangles = region.triangles();
    let mut uncovered = Fragments::new(triangles.iter().map(|t| t.to_vec()));
    let mut candidates = Candidates::default();
    for seed in seeds(&triangles, config.seeds_max) {
        // What grows from inside a piece is mostly that piece again.
        if !candidates.contain(&seed) {
            candidates.push(boundary.grow(&seed), vertices_max);
        }
    }
    let mut pieces: Vec<Piece> = Vec::new();
    while pieces.len() < config.pieces_max && uncovered.area() > (1.0 - config.coverage) * area {
        if let Some(piece) = candidates.take_best(&uncovered, config.gain_min_m2) {
            uncovered.subtract(&piece.polygon);
            pieces.push(piece);
            continue;
        }
        // What the first seeds left: grow from the remainders, the largest first. A piece can add
        // several of them, so that much smaller ones count.
        let Some(seed) = uncovered.take_largest(0.1 * config.gain_min_m2) else {
            break;
        };
        candidates.push(boundary.grow(&seed), vertices_max);
    }
    drop_redundant(&mut pieces);
    Cover {
        pieces,
        coverage: (1.0 - uncovered.area() / area).clamp(0.0, 1.0),
    }
}

/// The area of a polygon that none of the others covers, m².
pub fn area_outside(polygon: &ConvexPolygon, others: &[ConvexPolygon]) -> f64 {
    let mut rest = Fragments::new(std::iter::once(polygon.vertices().to_vec()));
    for other in others {
        rest.subtract(other);
    }
    rest.area()
}

/// Convex parts of what none of the pieces covers of a region, without specks.
pub(crate) fn outside(
    region: &Region,
    pieces: &[ConvexPolygon],
    speck_m2: f64,
) -> Vec<ConvexPolygon> {
    let triangles = region.triangles();
    let mut rest = Fragments::new(triangles.iter().map(|t| t.to_vec()));
    for piece in pieces {
        rest.subtract(piece);
    }
    let mut parts: Vec<ConvexPolygon> = Vec::new();
    let fragments = rest.into_rings().filter(|ring| ring_area(ring) > speck_m2);
    for mut part in fragments.filter_map(|ring| ConvexPolygon::hull(&ring).ok()) {
        // What the sides of triangles and pieces only cut is one part.
        while let Some((i, whole)) = neighbour(&parts, &part) {
            parts.swap_remove(i);
            part = whole;
        }
        parts.push(part);
    }
    parts
}

/// The number of a polygon beside another with which it makes a convex one, and that.
fn neighbour(parts: &[ConvexPolygon], part: &ConvexPolygon) -> Option<(usize, ConvexPolygon)> {
    parts.iter().enumerate().find_map(|(i, other)| {
        let corners: Vec<_> = [part, other].map(ConvexPolygon::vertices).concat();
        let whole = ConvexPolygon::hull(&corners).ok()?;
        (whole.area() <= part.area() + other.area() + JOINT_M2).then_some((i, whole))
    })
}

/// The largest triangles, each also shrunk to its centre, which leaves the piece free to turn.
fn seeds(triangles: &[[Point2<f64>; 3]], most: usize) -> Vec<Vec<Point2<f64>>> {
    let mut largest: Vec<_> = triangles.iter().collect();
    largest.sort_by(|a, b| ring_area(&b[..]).total_cmp(&ring_area(&a[..])));
    largest.truncate(most);
    let both = largest.iter().flat_map(|triangle| {
        let centre = Point2::from(
            triangle
                .iter()
                .map(|v| v.coords)
                .sum::<nalgebra::Vector2<_>>()
                / 3.0,
        );
        let core = triangle.map(|v| centre + (v - centre) * 0.01);
        [triangle.to_vec(), core.to_vec()]
    });
    both.collect()
}

/// Pieces to choose from, each with an upper bound of what it adds.
#[derive(Default)]
struct Candidates {
    list: Vec<Piece>,
}

impl Candidates {
    /// Whether a ring lies in one of the pieces.
    fn contain(&self, ring: &[Point2<f64>]) -> bool {
        let inside = |piece: &Piece| ring.iter().all(|p| piece.polygon.contains(p, 1e-6));
        self.list.iter().any(inside)
    }

    fn push(&mut self, ring: Vec<Point2<f64>>, vertices_max: usize) {
        if let Some(polygon) = ConvexPolygon::from_ring(ring) {
            let polygon = polygon.simplified_inside(vertices_max);
            // No piece adds more than its area.
            let gain_m2 = polygon.area();
            self.list.push(Piece { polygon, gain_m2 });
        }
    }

    /// Takes out the piece that adds the most, if that is at least `gain_min_m2`.
    ///
    /// What a piece adds only falls as others are taken, so an old value is an upper bound: the
    /// first one that is still the largest after an update is the best.
    fn take_best(&mut self, uncovered: &Fragments, gain_min_m2: f64) -> Option<Piece> {
        loop {
            let larger = |best: usize, i: usize| {
                let better = self.list[i].gain_m2 > self.list[best].gain_m2;
                if better { i } else { best }
            };
            let best = (0..self.list.len()).reduce(larger)?;
            let bound = self.list[best].gain_m2;
            // Worthless pieces stay worthless.
            if bound < gain_min_m2 || bound <= 0.0 {
                self.list.clear();
                return None;
            }
            let gain = uncovered.area_in(&self.list[best].polygon);
            self.list[best].gain_m2 = gain;
            let others = self.list.iter().enumerate().filter(|(i, _)| *i != best);
            let next_bound = others.map(|(_, p)| p.gain_m2).fold(0.0, f64::max);
            if gain >= next_bound && gain >= gain_min_m2 && gain > 0.0 {
                return Some(self.list.swap_remove(best));
            }
        }
    }
}

/// Drops pieces that later ones have made superfluous, the smallest first.
fn drop_redundant(pieces: &mut Vec<Piece>) {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by(|a, b| {
        let area = |i: &usize| pieces[*i].polygon.area();
        area(a).total_cmp(&area(b))
    });
    let mut dropped = vec![false; pieces.len()];
    for i in order {
        let mut rest = Fragments::new(std::iter::once(pieces[i].polygon.vertices().to_vec()));
        for (j, other) in pieces.iter().enumerate() {
            if j != i && !dropped[j] {
                rest.subtract(&other.polygon);
            }
        }
        // A millionth of a piece is rounding.
        dropped[i] = rest.area() <= 1e-6 * pieces[i].polygon.area();
    }
    let mut keep = dropped.iter().map(|d| !d);
    pieces.retain(|_| keep.next().unwrap_or(true));
}

#[cfg(test)]
mod tests;
