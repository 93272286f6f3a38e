//! Growing a convex part of a region until the region's edges stop it.
//!
//! The piece begins as the hull of the region. While an edge of the region runs through its
//! interior, a line between the seed and that edge cuts it: of all directions in which the two can
//! be separated, the one that leaves the piece the most area. No edge of the region runs through
//! the interior at the end, and the seed is inside: so is the whole piece.

use nalgebra::{Point2, Vector2};

use crate::polygon::{ConvexPolygon, HalfPlane, clip_ring, ring_area};

/// An edge this far inside a piece is inside, m; less is rounding.
const INSIDE_M: f64 = 1e-7;
/// The seed may be this far beyond a line that separates it from an edge it touches, m.
const TOUCH_M: f64 = 2e-8;
/// Points nearer than this give no direction, m.
const APART_M: f64 = 1e-6;
/// A line that is along no edge of the region must leave this much more: what remains beside lines
/// along the edges is easier to cover.
const SLANTED: f64 = 0.95;
/// Growing again from a piece ends when it adds less than this part of the area.
const GROWTH_MIN: f64 = 1e-6;
/// Each round begins from the piece of the one before, so few change anything.
const ROUNDS_MAX: usize = 4;

/// The edges of a region and its hull.
pub(crate) struct Boundary {
    edges: Vec<Edge>,
    hull: Vec<Point2<f64>>,
}

/// An edge of the region with the unit normals of itself and its two neighbours in the ring.
struct Edge {
    ends: [Point2<f64>; 2],
    normals: [Vector2<f64>; 3],
}

impl Boundary {
    /// Of a region's rings, its interior on their left, the outer one first.
    pub fn new<'a>(rings: impl Iterator<Item = &'a [Point2<f64>]>) -> Self {
        let mut edges = Vec::new();
        let mut hull: Option<Vec<Point2<f64>>> = None;
        for ring in rings {
            // A region has an area, so its outer ring has a hull.
            hull.get_or_insert_with(|| {
                ConvexPolygon::hull(ring).map_or(ring.to_vec(), |hull| hull.vertices().to_vec())
            });
            let count = ring.len();
            let normal = |i: usize| HalfPlane::left_of(&ring[i % count], &ring[(i + 1) % count]).n;
            for i in 0..count {
                edges.push(Edge {
                    ends: [ring[i], ring[(i + 1) % count]],
                    normals: [normal(i), normal(i + count - 1), normal(i + 1)],
                });
            }
        }
        let hull = hull.unwrap_or_default();
        Self { edges, hull }
    }

    /// A convex ring around the seed (a convex counter-clockwise ring in the region) that no edge
    /// of the region enters.
    pub fn grow(&self, seed: &[Point2<f64>]) -> Vec<Point2<f64>> {
        let mut piece = self.grow_once(seed);
        for _ in 1..ROUNDS_MAX {
            // Each line was the best for its own edge: with the piece for a seed all are chosen
            // anew, none can take anything away, some can be moved outward.
            let larger = self.grow_once(&piece);
            let gain = ring_area(&larger) - ring_area(&piece);
            if gain <= GROWTH_MIN * ring_area(&piece) {
                break;
            }
            piece = larger;
        }
        piece
    }

    fn grow_once(&self, seed: &[Point2<f64>]) -> Vec<Point2<f64>> {
        // Nearest first: a line that keeps a near edge out mostly keeps out what is behind it.
        let mut order: Vec<(f64, usize)> = (0..self.edges.len())
            .map(|i| (self.edges[i].distance(seed), i))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut piece = self.hull.clone();
        let mut sides = sides(&piece);
        let mut cuts: Vec<HalfPlane> = Vec::new();
        for (_, i) in order {
            let edge = &self.edges[i];
            if edge.enters(&sides) {
                let cut = edge.best_cut(seed, &piece);
                piece = clip_ring(&piece, &cut);
                sides.push(cut);
                cuts.push(cut);
            }
        }
        self.drop_redundant(cuts, piece)
    }

    /// Drops the lines whose work the others do as well, the first ones first.
    fn drop_redundant(
        &self,
        mut cuts: Vec<HalfPlane>,
        mut piece: Vec<Point2<f64>>,
    ) -> Vec<Point2<f64>> {
        let hull = sides(&self.hull);
        // How many of the lines have an edge of the region wholly beyond them: another's removal lets
        // none of these in.
        let beyond = |edge: &Edge, side: &HalfPlane| {
            edge.ends.iter().all(|end| side.value(end) >= -INSIDE_M)
        };
        let count = |edge: &Edge| cuts.iter().filter(|cut| beyond(edge, cut)).count();
        let mut kept_out: Vec<usize> = self.edges.iter().map(count).collect();
        let mut i = 0;
        while i < cuts.len() {
            let others = cuts.iter().enumerate().filter(|(j, _)| *j != i);
            let others = others.map(|(_, cut)| *cut);
            let without: Vec<HalfPlane> = hull.iter().copied().chain(others).collect();
            let mut watched = self.edges.iter().zip(&kept_out);
            let needed = watched.any(|(edge, count)| {
                *count == usize::from(beyond(edge, &cuts[i])) && edge.enters(&without)
            });
            if needed {
                i += 1;
                continue;
            }
            let dropped = cuts.remove(i);
            for (edge, count) in self.edges.iter().zip(&mut kept_out) {
                *count -= usize::from(beyond(edge, &dropped));
            }
            let whole = self.hull.clone();
            piece = cuts.iter().fold(whole, |ring, cut| clip_ring(&ring, cut));
        }
        piece
    }
}

/// The half planes of a convex ring's edges.
fn sides(ring: &[Point2<f64>]) -> Vec<HalfPlane> {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let long = edges.filter(|(p, q)| (*q - *p).norm() >= APART_M);
    long.map(|(p, q)| HalfPlane::left_of(p, q)).collect()
}

impl Edge {
    /// The distance from a convex ring to the edge, 0 where they touch, m.
    fn distance(&self, seed: &[Point2<f64>]) -> f64 {
        let [a, b] = &self.ends;
        let from_seed = seed.iter().map(|p| distance_to_segment(p, a, b));
        let ring = seed.iter().zip(seed.iter().cycle().skip(1));
        let from_ends =
            ring.flat_map(|(c, d)| [distance_to_segment(a, c, d), distance_to_segment(b, c, d)]);
        from_seed.chain(from_ends).fold(f64::INFINITY, f64::min)
    }

    /// Whether the edge runs through the interior of an intersection of half planes.
    fn enters(&self, sides: &[HalfPlane]) -> bool {
        let [a, b] = &self.ends;
        let (mut from, mut to) = (0.0, 1.0);
        for side in sides {
            let (at_a, at_b) = (side.value(a) + INSIDE_M, side.value(b) + INSIDE_M);
            if at_a >= 0.0 && at_b >= 0.0 {
                return false;
            }
            if at_a > 0.0 || at_b > 0.0 {
                let crossing = at_a / (at_a - at_b);
                if at_a > 0.0 {
                    from = f64::max(from, crossing);
                } else {
                    to = f64::min(to, crossing);
                }
                if to <= from {
                    return false;
                }
            }
        }
        true
    }

    /// The half plane of the seed, bounded by a line between the seed and the edge, that leaves
    /// the piece the most area.
    ///
    /// Two convex sets in the plane that do not overlap are separated by a line along an edge of
    /// one of them; lines through an end of the edge, square to its way to the nearest corner of the seed or along it, and along
    /// the neighbouring edges of the region leave larger pieces. Each line touches the edge.
    /// Where rounding lets the two overlap, it is the line that takes least of the seed.
    fn best_cut(&self, seed: &[Point2<f64>], piece: &[Point2<f64>]) -> HalfPlane {
        let mut best: Option<(f64, HalfPlane)> = None;
        let mut least = (
            f64::INFINITY,
            HalfPlane::left_of(&self.ends[1], &self.ends[0]),
        );
        let mut try_normal = |n: Vector2<f64>, handicap: f64| {
            let along = |p: &Point2<f64>| n.dot(&p.coords);
            let b = self.ends.iter().map(along).fold(f64::INFINITY, f64::min);
            let reach = seed.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            let cut = HalfPlane { n, b };
            if reach - b < least.0 {
                least = (reach - b, cut);
            }
            if reach > b + TOUCH_M {
                return;
            }
            let area = area_left(piece, &cut) * handicap;
            if best.is_none_or(|(largest, _)| area > largest) {
                best = Some((area, cut));
            }
        };
        for n in self.normals {
            try_normal(n, 1.0);
            try_normal(-n, 1.0);
        }
        for (p, q) in seed.iter().zip(seed.iter().cycle().skip(1)) {
            if (q - p).norm() >= APART_M {
                try_normal(HalfPlane::left_of(p, q).n, SLANTED);
            }
        }
        for end in &self.ends {
            let gaps = seed.iter().map(|p| end - p);
            let shorter = |a: Vector2<f64>, b: Vector2<f64>| {
                if b.norm_squared() < a.norm_squared() {
                    b
                } else {
                    a
                }
            };
            let nearest = gaps.reduce(shorter).unwrap_or_default();
            if let Some(direction) = nearest.try_normalize(APART_M) {
                let across = Vector2::new(-direction.y, direction.x);
                try_normal(direction, SLANTED);
                try_normal(across, SLANTED);
                try_normal(-across, SLANTED);
            }
        }
        best.map_or(least.1, |(_, cut)| cut)
    }
}

/// The area of the part of a convex ring in a half plane, m².
fn area_left(ring: &[Point2<f64>], half_plane: &HalfPlane) -> f64 {
    let Some(mut a) = ring.last() else {
        return 0.0;
    };
    let origin = *a;
    let mut value_a = half_plane.value(a);
    let mut last: Option<Point2<f64>> = None;
    let mut first: Option<Point2<f64>> = None;
    let mut doubled = 0.0;
    let mut add = |p: Point2<f64>| {
        if let Some(q) = last {
            doubled += (q - origin).perp(&(p - origin));
        }
        first.get_or_insert(p);
        last = Some(p);
    };
    for b in ring {
        let value_b = half_plane.value(b);
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            add(a + (b - a) * (value_a / (value_a - value_b)));
        }
        if value_b <= 0.0 {
            add(*b);
        }
        (a, value_a) = (b, value_b);
    }
    if let (Some(p), Some(q)) = (first, last) {
        doubled += (q - origin).perp(&(p - origin));
    }
    0.5 * doubled
}

/// Distance of a point from a segment, m.
pub(crate) fn distance_to_segment(p: &Point2<f64>, a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    let edge = b - a;
    let length = edge.norm_squared();
    let along = if length > 0.0 {
        (edge.dot(&(p - a)) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p - (a + edge * along)).norm()
}
