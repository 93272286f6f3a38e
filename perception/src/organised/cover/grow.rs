//! One convex piece, grown from a point until the edges of the region stop it.

use nalgebra::{Matrix2, Point2, Vector2};
use surfaces::HalfPlane;

use super::ring::Ring;

/// Most rounds of growing a piece about its own ellipse.
const ROUNDS: usize = 6;
/// Rounds over the cuts of a piece, each replaced by a better one.
const POLISHES: usize = 2;
/// Most corners of the region beyond one cut for which better cuts are sought.
const CORNERS: usize = 40;

/// An edge of the region.
pub(super) type Edge = (Point2<f64>, Point2<f64>);

/// A piece as it was grown: the hull of the region and what was cut off it.
pub(super) struct Grown {
    pub ring: Ring,
    cuts: Vec<HalfPlane>,
}

/// What stops a piece: the edges of its region, but for those of its hull.
pub(super) struct Region {
    hull: Ring,
    edges: Vec<Edge>,
    slack_m: f64,
}

impl Region {
    /// The region with these edges and this hull; edges reach up to `slack_m` into a piece.
    pub fn new(hull: Ring, edges: &[Edge], slack_m: f64) -> Self {
        let edges = Self::inside(edges, &hull, slack_m);
        Self {
            hull,
            edges,
            slack_m,
        }
    }

    /// The hull of the region.
    pub fn hull(&self) -> &Ring {
        &self.hull
    }

    /// Grows a convex piece around a point: cut by the edges nearest in the metric of an ellipse,
    /// then again in that of the piece's own second moments, while it is worth more.
    ///
    /// Source: the alternation of [deits2015], with the moments in place of the inscribed ellipse.
    pub fn grow(&self, seed: &Point2<f64>, worth: &dyn Fn(&Ring) -> f64) -> Option<Grown> {
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
    pub fn polished(&self, mut piece: Grown, worth: &dyn Fn(&Ring) -> f64) -> Ring {
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
pub(super) fn closest(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> Point2<f64> {
    let along = b - a;
    let square = along.norm_squared();
    let t = if square > 0.0 {
        ((p - a).dot(&along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    a + along * t
}
