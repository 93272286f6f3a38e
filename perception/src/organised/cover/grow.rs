//! One convex piece, grown from a point until the edges of the region stop it.

use nalgebra::{Matrix2, Point2, Vector2};
use surfaces::{ConvexPolygon, HalfPlane};

use super::ring::Ring;

/// Most rounds of growing a piece about its own ellipse.
const ROUNDS: usize = 6;
/// Rounds over the cuts of a piece, each replaced by a better one.
const POLISHES: usize = 2;
/// Cuts that take off less than this ratio of a piece stay as they are.
const SLIVER: f64 = 0.003;

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
        let sides: Vec<HalfPlane> = hull
            .edges()
            .filter(|(a, b)| a != b)
            .map(|(a, b)| HalfPlane::left_of(a, b))
            .collect();
        let edges = Self::inside(edges, sides.iter(), slack_m);
        Self {
            hull,
            edges,
            slack_m,
        }
    }

    /// Whether no edge reaches into the hull.
    pub fn is_convex(&self) -> bool {
        self.edges.is_empty()
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
        // In coordinates that make the metric Euclidean, each edge with its nearest point.
        let flat = |p: &Point2<f64>| Point2::from(metric * (p - centre));
        let near = |a: &Point2<f64>, b: &Point2<f64>| closest(a, b, &Point2::origin()).coords;
        let edges = self.edges.iter().map(|(a, b)| (flat(a), flat(b)));
        let mut left: Vec<(Edge, Vector2<f64>)> =
            edges.map(|(a, b)| ((a, b), near(&a, &b))).collect();
        let mut cuts = Vec::new();
        loop {
            let nearest = left
                .iter()
                .map(|(_, q)| *q)
                .min_by(|p, q| p.norm_squared().total_cmp(&q.norm_squared()));
            let Some(q) = nearest else { break };
            // Tangent to the ellipse through the nearest point.
            let out = metric.transpose() * q;
            let n = out.try_normalize(1e-12)?;
            let b = n.dot(&(centre + back * q).coords);
            let cut = HalfPlane { n, b };
            piece = piece.clip(&cut);
            // The same cut in those coordinates, where lengths along its normal are ‖M⁻ᵀ n‖.
            let length = q.norm();
            let flat = HalfPlane {
                n: q / length,
                b: length,
            };
            let slack = self.slack_m * out.norm() / length;
            left.retain_mut(|(edge, nearest)| match clipped(edge, &flat, slack) {
                Some(kept) => {
                    if kept != *edge {
                        *edge = kept;
                        *nearest = near(&edge.0, &edge.1);
                    }
                    true
                }
                None => false,
            });
            cuts.push(cut);
        }
        (piece.0.len() >= 3).then_some(Grown { ring: piece, cuts })
    }

    /// The parts of the edges that reach into all of the half-planes.
    fn inside<'a>(
        edges: &[Edge],
        planes: impl Iterator<Item = &'a HalfPlane> + Clone,
        slack_m: f64,
    ) -> Vec<Edge> {
        let within = |edge: &Edge| {
            let mut planes = planes.clone();
            planes.try_fold(*edge, |edge, plane| clipped(&edge, plane, slack_m))
        };
        edges.iter().filter_map(within).collect()
    }

    /// Replaces each cut by the one that keeps most among those that keep `centre` and keep out
    /// the same edges: the lines through two of the corners that are then in the way.
    fn polish(&self, centre: &Point2<f64>, cuts: &mut Vec<HalfPlane>) {
        let mut i = 0;
        while i < cuts.len() {
            let others = || (0..cuts.len()).filter(|&k| k != i).map(|k| &cuts[k]);
            let without = others().fold(self.hull.clone(), |ring, cut| ring.clip(cut));
            let old = without.clip(&cuts[i]).area();
            // Slivers are not worth it.
            if without.area() - old < SLIVER * old {
                i += 1;
                continue;
            }
            let left = Self::inside(&self.edges, others(), self.slack_m);
            if left.is_empty() {
                cuts.remove(i);
                continue;
            }
            if let Some((area, cut)) = best_cut(&without, &left, centre)
                && area > old * 1.001
            {
                cuts[i] = cut;
            }
            i += 1;
        }
    }
}

/// The half-plane that keeps `centre` and most of the piece, and no inner point of the edges: of
/// those along a side of the edges' convex hull.
fn best_cut(piece: &Ring, edges: &[Edge], centre: &Point2<f64>) -> Option<(f64, HalfPlane)> {
    let corners: Vec<Point2<f64>> = edges.iter().flat_map(|(a, b)| [*a, *b]).collect();
    let sides = match ConvexPolygon::hull(&corners) {
        Ok(hull) => hull.half_planes(),
        // All on one line: it has two sides.
        Err(_) => {
            let first = corners.first()?;
            let far = |a: &&Point2<f64>, b: &&Point2<f64>| {
                (*a - first)
                    .norm_squared()
                    .total_cmp(&(*b - first).norm_squared())
            };
            let last = corners.iter().max_by(far).filter(|p| *p != first)?;
            let side = HalfPlane::left_of(first, last);
            vec![side, side.flipped()]
        }
    };
    let mut best: Option<(f64, HalfPlane)> = None;
    for side in sides {
        // The far side of the hull's side: the hull is out, the centre must be in.
        let cut = side.flipped();
        if cut.value(centre) > 0.0 {
            continue;
        }
        let area = piece.clip(&cut).area();
        if best.as_ref().is_none_or(|(most, _)| area > *most) {
            best = Some((area, cut));
        }
    }
    best
}

/// What of an edge reaches more than `slack` into the half-plane.
fn clipped(&(a, b): &Edge, keep: &HalfPlane, slack: f64) -> Option<Edge> {
    let (ha, hb) = (keep.value(&a) + slack, keep.value(&b) + slack);
    if ha >= 0.0 && hb >= 0.0 {
        return None;
    }
    if ha <= 0.0 && hb <= 0.0 {
        return Some((a, b));
    }
    let p = a + (b - a) * (ha / (ha - hb));
    Some(if ha > 0.0 { (p, b) } else { (a, p) })
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
