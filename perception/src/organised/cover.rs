//! A region with holes, covered by few large convex pieces.

use nalgebra::{Matrix2, Point2, SymmetricEigen, Vector2};
use serde::{Deserialize, Serialize};
use surfaces::{ConvexPolygon, HalfPlane};

use crate::Error;
use crate::error::within;

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
    pub(super) fn check(&self) -> Result<(), Error> {
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

/// Samples of a region, about this many.
const SAMPLES: f64 = 450.0;
/// Places that further pieces are grown from, before the best of all is taken.
const SEEDS: usize = 4;
/// Most rounds of growing a piece about its own ellipse.
const ROUNDS: usize = 6;
/// Rounds over the cuts of a piece, each replaced by a better one.
const POLISHES: usize = 2;
/// Most corners of the region beyond one cut for which better cuts are sought.
const CORNERS: usize = 40;
/// Area that other pieces cover already counts this much: pieces overlap, not end at seams.
const OVERLAP_WORTH: f64 = 0.05;

/// An edge of the region.
type Edge = (Point2<f64>, Point2<f64>);

/// Convex pieces of the region between the rings (the outer one first, then holes), greedily:
/// each adds most to those before it. They overlap rather than meet at seams, and no edge of the
/// region reaches more than `slack_m` into one.
pub(super) fn cover(
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
    let region = Region {
        edges: Region::inside(&edges, &hull, slack_m),
        hull,
        slack_m,
    };
    let (mut uncovered, cell_m2) = samples(&region.hull, &edges);
    let total_m2 = uncovered.len() as f64 * cell_m2;
    let worthwhile = (config.gain_min_ratio * total_m2).min(config.gain_min_m2);
    let gain_min_m2 = config.area_min_m2.max(worthwhile);
    let mut pieces: Vec<ConvexPolygon> = Vec::new();
    let mut grown: Vec<Grown> = Vec::new();
    while pieces.len() < config.pieces_max {
        // Grow from the places that are farthest from every edge and in no piece grown so far.
        let gained = |piece: &Ring| {
            uncovered.iter().filter(|s| piece.contains(&s.p)).count() as f64 * cell_m2
        };
        let worth = |piece: &Ring| gained(piece) + OVERLAP_WORTH * piece.area();
        for seed in seeds(&uncovered) {
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
        let Ok(piece) = ConvexPolygon::hull(&ring.0) else {
            break;
        };
        let piece = piece.simplified_inside(config.vertices_max);
        let ring = Ring(piece.vertices().to_vec());
        let gain_m2 = gained(&ring);
        let large = piece.area() >= config.area_min_m2
            && 2.0 * piece.inscribed_circle().1 >= config.width_min_m;
        if !large || !pieces.is_empty() && gain_m2 < gain_min_m2 {
            break;
        }
        uncovered.retain(|s| !ring.contains(&s.p));
        pieces.push(piece);
        if uncovered.len() as f64 * cell_m2 <= (1.0 - config.ratio) * total_m2 {
            break;
        }
    }
    pieces
}

/// A piece as it was grown: the hull of the region and what was cut off it.
struct Grown {
    ring: Ring,
    cuts: Vec<HalfPlane>,
}

/// A sample of the region and its distance from the nearest edge.
struct Sample {
    p: Point2<f64>,
    free: f64,
}

/// A lattice of points inside the region, and the area that each stands for.
fn samples(hull: &Ring, edges: &[Edge]) -> (Vec<Sample>, f64) {
    let pitch = (hull.area() / SAMPLES).sqrt();
    let ends = |axis: usize| {
        let along = || hull.0.iter().map(move |v| v[axis]);
        let low = along().fold(f64::INFINITY, f64::min);
        (low, along().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((x0, x1), (y0, y1)) = (ends(0), ends(1));
    let mut inside = Vec::new();
    let rows = ((y1 - y0) / pitch).ceil().min(4.0 * SAMPLES) as usize;
    for row in 0..rows {
        // Crossings of the row with the edges, left to right: odd intervals are inside.
        let y = y0 + (row as f64 + 0.5) * pitch;
        let mut crossings: Vec<f64> = edges
            .iter()
            .filter(|(a, b)| (a.y > y) != (b.y > y))
            .map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
            .collect();
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let first = ((pair[0].max(x0) - x0) / pitch - 0.5).ceil().max(0.0) as usize;
            let last = pair[1].min(x1);
            let xs = (first..).map(|k| x0 + (k as f64 + 0.5) * pitch);
            inside.extend(xs.take_while(|x| *x < last).map(|x| {
                let p = Point2::new(x, y);
                let near = |(a, b): &Edge| (p - closest(a, b, &p)).norm_squared();
                let free = edges.iter().map(near).fold(f64::INFINITY, f64::min).sqrt();
                Sample { p, free }
            }));
        }
    }
    (inside, pitch * pitch)
}

/// The samples farthest from every edge, each outside of the free circles of those before it.
fn seeds(samples: &[Sample]) -> Vec<Point2<f64>> {
    let mut seeds: Vec<&Sample> = Vec::new();
    while seeds.len() < SEEDS {
        // The first of equals, so that the result does not depend on anything else.
        let apart = |s: &&Sample| seeds.iter().all(|t| (s.p - t.p).norm() > 2.0 * t.free);
        let best = samples
            .iter()
            .filter(apart)
            .reduce(|a, b| if b.free > a.free { b } else { a });
        let Some(best) = best else { break };
        seeds.push(best);
    }
    seeds.iter().map(|s| s.p).collect()
}

/// Corners of a convex polygon, counter-clockwise: [`ConvexPolygon`] without its checks, for the
/// many polygons that are only compared.
#[derive(Clone)]
struct Ring(Vec<Point2<f64>>);

impl Ring {
    fn edges(&self) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
        let next = self.0[1.min(self.0.len())..].iter().chain(self.0.first());
        self.0.iter().zip(next)
    }

    fn area(&self) -> f64 {
        let Some(o) = self.0.first() else { return 0.0 };
        self.edges()
            .map(|(a, b)| (a - o).perp(&(b - o)))
            .sum::<f64>()
            / 2.0
    }

    fn contains(&self, p: &Point2<f64>) -> bool {
        self.edges().all(|(a, b)| (b - a).perp(&(p - a)) >= 0.0)
    }

    /// The part in the half-plane {n·p ≤ b}.
    fn clip(&self, cut: &HalfPlane) -> Self {
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for (a, c) in self.edges() {
            let (ha, hc) = (cut.value(a), cut.value(c));
            if ha <= 0.0 {
                kept.push(*a);
            }
            if (ha < 0.0 && hc > 0.0) || (ha > 0.0 && hc < 0.0) {
                kept.push(a + (c - a) * (ha / (ha - hc)));
            }
        }
        Self(kept)
    }

    /// Centroid, and the matrix that makes the second moments those of a circle.
    fn ellipse(&self) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let o = self.0.first()?;
        let (mut area, mut first, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
        for (a, b) in self.edges() {
            // ∫ 1, p and p pᵀ over the triangle (o, a, b), about o.
            let (a, b) = (a - o, b - o);
            let (sum, double) = (a + b, a.perp(&b));
            area += double / 2.0;
            first += sum * (double / 6.0);
            second +=
                (a * a.transpose() + b * b.transpose() + sum * sum.transpose()) * (double / 24.0);
        }
        let mean: Vector2<f64> = first / area;
        let eigen = SymmetricEigen::new(second / area - mean * mean.transpose());
        let scale = eigen.eigenvalues.map(|l| 1.0 / l.sqrt());
        let metric = Matrix2::from_diagonal(&scale) * eigen.eigenvectors.transpose();
        metric
            .iter()
            .all(|x| x.is_finite())
            .then_some((o + mean, metric))
    }
}

/// What stops a piece: the edges of its region, but for those of its hull.
struct Region {
    hull: Ring,
    edges: Vec<Edge>,
    slack_m: f64,
}

impl Region {
    /// Grows a convex piece around a point: cut by the edges nearest in the metric of an ellipse,
    /// then again in that of the piece's own second moments, while it is worth more.
    ///
    /// Source: the alternation of [deits2015], with the moments in place of the inscribed ellipse.
    fn grow(&self, seed: &Point2<f64>, worth: &dyn Fn(&Ring) -> f64) -> Option<Grown> {
        let mut best = self.inflate(seed, &Matrix2::identity())?;
        let mut most = worth(&best.ring);
        let mut about = best.ring.ellipse();
        for _ in 0..ROUNDS {
            let Some((centre, metric)) = about else { break };
            let Some(next) = self.inflate(&centre, &metric) else {
                break;
            };
            let now = worth(&next.ring);
            let better = now > most * 1.005;
            about = next.ring.ellipse();
            if now > most {
                (best, most) = (next, now);
            }
            if !better {
                break;
            }
        }
        Some(best)
    }

    /// The piece with each cut turned to where it costs least, where that is worth more.
    fn polished(&self, mut piece: Grown, worth: &dyn Fn(&Ring) -> f64) -> Ring {
        let Some((centre, _)) = piece.ring.ellipse() else {
            return piece.ring;
        };
        for _ in 0..POLISHES {
            self.polish(&centre, &mut piece.cuts);
        }
        let polished = piece
            .cuts
            .iter()
            .fold(self.hull.clone(), |ring, cut| ring.clip(cut));
        if worth(&polished) >= worth(&piece.ring) {
            polished
        } else {
            piece.ring
        }
    }

    /// The hull, cut off at the nearest edge, then at the nearest edge left, and so on; near in
    /// the metric ‖M (p − c)‖. Returns the cuts too.
    fn inflate(&self, centre: &Point2<f64>, metric: &Matrix2<f64>) -> Option<Grown> {
        let back = metric.try_inverse()?;
        let mut piece = self.hull.clone();
        let mut left = self.edges.clone();
        let mut cuts = Vec::new();
        let flat = |p: &Point2<f64>| Point2::from(metric * (p - centre));
        loop {
            let nearest = left
                .iter()
                .map(|(a, b)| closest(&flat(a), &flat(b), &Point2::origin()).coords)
                .min_by(|p, q| p.norm_squared().total_cmp(&q.norm_squared()));
            let Some(q) = nearest else { break };
            // Tangent to the ellipse through the nearest point.
            let n = (metric.transpose() * q).try_normalize(1e-12)?;
            let b = n.dot(&(centre + back * q).coords);
            let cut = HalfPlane { n, b };
            piece = piece.clip(&cut);
            clip(&mut left, &cut, self.slack_m);
            cuts.push(cut);
        }
        (piece.0.len() >= 3).then_some(Grown { ring: piece, cuts })
    }

    /// The parts of the edges that reach into the piece.
    fn inside(edges: &[Edge], piece: &Ring, slack_m: f64) -> Vec<Edge> {
        let mut left = edges.to_vec();
        for (a, b) in piece.edges() {
            if a != b {
                clip(&mut left, &HalfPlane::left_of(a, b), slack_m);
            }
        }
        left
    }

    /// Replaces each cut by the one that keeps most among those that keep `centre` and keep out
    /// the same edges: the lines through two of the corners that are then in the way.
    fn polish(&self, centre: &Point2<f64>, cuts: &mut Vec<HalfPlane>) {
        let mut i = 0;
        while i < cuts.len() {
            let others = cuts.iter().enumerate().filter(|(k, _)| *k != i);
            let without = others.fold(self.hull.clone(), |ring, (_, cut)| ring.clip(cut));
            let left = Self::inside(&self.edges, &without, self.slack_m);
            if left.is_empty() {
                cuts.remove(i);
                continue;
            }
            let old = without.clip(&cuts[i]).area();
            if let Some((area, cut)) = best_cut(&without, &left, centre)
                && area > old * 1.001
            {
                cuts[i] = cut;
            }
            i += 1;
        }
    }
}

/// The half-plane that keeps `centre` and most of the piece, and no inner point of the edges.
fn best_cut(piece: &Ring, edges: &[Edge], centre: &Point2<f64>) -> Option<(f64, HalfPlane)> {
    if 2 * edges.len() > CORNERS {
        return None;
    }
    let corners: Vec<Point2<f64>> = edges.iter().flat_map(|(a, b)| [*a, *b]).collect();
    let mut best: Option<(f64, HalfPlane)> = None;
    for (i, p) in corners.iter().enumerate() {
        for q in &corners[i + 1..] {
            let Some(along) = (q - p).try_normalize(1e-9) else {
                continue;
            };
            let n = Vector2::new(along.y, -along.x);
            let n = if n.dot(&(centre - p)) > 0.0 { -n } else { n };
            let cut = HalfPlane {
                n,
                b: n.dot(&p.coords),
            };
            if corners.iter().any(|r| cut.value(r) < -1e-9) {
                continue;
            }
            let area = piece.clip(&cut).area();
            if best.as_ref().is_none_or(|(most, _)| area > *most) {
                best = Some((area, cut));
            }
        }
    }
    best
}

/// Keeps of every edge what reaches more than `slack` into the half-plane.
fn clip(edges: &mut Vec<Edge>, keep: &HalfPlane, slack: f64) {
    edges.retain_mut(|(a, b)| {
        let (ha, hb) = (keep.value(a) + slack, keep.value(b) + slack);
        if ha >= 0.0 && hb >= 0.0 {
            return false;
        }
        if ha > 0.0 || hb > 0.0 {
            let p = *a + (*b - *a) * (ha / (ha - hb));
            *(if ha > 0.0 { a } else { b }) = p;
        }
        true
    });
}

/// The point of a segment that is nearest to p.
fn closest(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> Point2<f64> {
    let along = b - a;
    let square = along.norm_squared();
    let t = if square > 0.0 {
        ((p - a).dot(&along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    a + along * t
}

#[cfg(test)]
mod tests {
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
