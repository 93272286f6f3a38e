//! One convex piece, grown from a point until the edges of the region stop it.

use nalgebra::{Matrix2, Point2, Vector2};
use surfaces::HalfPlane;

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
    scratch: Scratch,
}

impl Region {
    /// The region with these edges and this hull; edges reach up to `slack_m` into a piece.
    pub fn new(hull: Ring, edges: &[Edge], slack_m: f64) -> Self {
        let sides: Vec<HalfPlane> = hull
            .edges()
            .filter(|(a, b)| a != b)
            .map(|(a, b)| HalfPlane::left_of(a, b))
            .collect();
        // The parts of the edges that reach into the hull.
        let inside = |edge: &Edge| {
            let mut sides = sides.iter();
            sides.try_fold(*edge, |edge, side| clipped(&edge, side, slack_m))
        };
        let edges = edges.iter().filter_map(inside).collect();
        Self {
            hull,
            edges,
            slack_m,
            scratch: Scratch::default(),
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
    pub fn grow(&mut self, seed: &Point2<f64>, worth: &dyn Fn(&Ring) -> f64) -> Option<Grown> {
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
        let mut polished = Ring::default();
        let mut sides = Sides::new(&self.edges, &piece.cuts, self.slack_m);
        for _ in 0..POLISHES {
            polished = self.polish(&centre, &mut piece.cuts, &mut sides);
        }
        if worth(&polished) >= worth(&piece.ring) {
            polished
        } else {
            piece.ring
        }
    }

    /// The hull, cut off at the nearest edge, then at the nearest edge left, and so on; near in
    /// the metric ‖M (p − c)‖. Returns the cuts too.
    fn inflate(&mut self, centre: &Point2<f64>, metric: &Matrix2<f64>) -> Option<Grown> {
        let back = metric.try_inverse()?;
        let (piece, left) = (&mut self.scratch.piece, &mut self.scratch.ahead);
        piece.copy(&self.hull);
        // In coordinates that make the metric Euclidean, each edge with its nearest point.
        let flat = |p: &Point2<f64>| Point2::from(metric * (p - centre));
        left.clear();
        left.extend(
            self.edges
                .iter()
                .map(|(a, b)| Ahead::new((flat(a), flat(b)))),
        );
        let mut cuts = Vec::with_capacity(CUTS);
        let mut nearest = Nearest::default();
        left.iter().for_each(|ahead| nearest.take(ahead));
        while let Some(q) = nearest.point {
            // Tangent to the ellipse through the nearest point.
            let out = metric.transpose() * q;
            let n = out.try_normalize(1e-12)?;
            let b = n.dot(&(centre + back * q).coords);
            let cut = HalfPlane { n, b };
            piece.clip(&cut, &mut self.scratch.spare);
            cuts.push(cut);
            // The same cut in those coordinates, where lengths along its normal are ‖M⁻ᵀ n‖.
            let length = q.norm();
            let flat = HalfPlane {
                n: q / length,
                b: length,
            };
            let slack = self.slack_m * out.norm() / length;
            nearest = Nearest::default();
            let mut kept = 0;
            for i in 0..left.len() {
                let ahead = &left[i];
                let Some(edge) = clipped(&ahead.edge, &flat, slack) else {
                    continue;
                };
                let ahead = if edge == ahead.edge {
                    *ahead
                } else {
                    Ahead::new(edge)
                };
                nearest.take(&ahead);
                left[kept] = ahead;
                kept += 1;
            }
            left.truncate(kept);
        }
        (piece.0.len() >= 3).then(|| Grown {
            ring: piece.clone(),
            cuts,
        })
    }

    /// Replaces each cut by the one that keeps most among those that keep `centre` and keep out
    /// the same edges: the lines through two of the corners that are then in the way. Returns what
    /// the cuts leave of the hull.
    fn polish(
        &self,
        centre: &Point2<f64>,
        cuts: &mut Vec<HalfPlane>,
        sides: &mut Vec<Sides>,
    ) -> Ring {
        // What the cuts before this one leave of the hull.
        let mut piece = self.hull.clone();
        let mut around = Ring::default();
        let (mut without, mut spare) = (Ring::default(), Ring::default());
        let mut corners: Vec<Point2<f64>> = Vec::new();
        let mut i = 0;
        while i < cuts.len() {
            without.copy(&piece);
            for cut in &cuts[i + 1..] {
                without.clip(cut, &mut spare);
            }
            let old = without.area_within(&cuts[i]);
            // Slivers are not worth it.
            if without.area() - old >= SLIVER * old {
                corners.clear();
                for (sides, edge) in sides.iter().zip(&self.edges) {
                    if let Some((a, b)) = sides.clipped(edge, cuts, i, self.slack_m) {
                        if corners.last() != Some(&a) {
                            corners.push(a);
                        }
                        corners.push(b);
                    }
                }
                if corners.is_empty() {
                    cuts.remove(i);
                    *sides = Sides::new(&self.edges, cuts, self.slack_m);
                    continue;
                }
                around.hull(&mut corners);
                if let Some((area, cut)) = best_cut(&without, &around, centre)
                    && area > old * 1.001
                {
                    cuts[i] = cut;
                    Sides::replace(sides, i, &self.edges, &cut, self.slack_m);
                }
            }
            piece.clip(&cuts[i], &mut spare);
            i += 1;
        }
        piece
    }
}

/// On which side of the cuts an edge wholly lies, one bit a cut; of cuts after the last bit nothing
/// is said.
#[derive(Clone, Copy, Default)]
struct Sides {
    out: u64,
    within: u64,
}

impl Sides {
    /// Of all edges.
    fn new(edges: &[Edge], cuts: &[HalfPlane], slack_m: f64) -> Vec<Self> {
        let mut sides = vec![Self::default(); edges.len()];
        for (i, cut) in cuts.iter().enumerate() {
            Self::replace(&mut sides, i, edges, cut, slack_m);
        }
        sides
    }

    /// Says it of another cut `i`.
    fn replace(sides: &mut [Self], i: usize, edges: &[Edge], cut: &HalfPlane, slack_m: f64) {
        let bit = 1_u64.checked_shl(i as u32).unwrap_or(0);
        for (sides, (a, b)) in sides.iter_mut().zip(edges) {
            let (ha, hb) = (cut.value(a) + slack_m, cut.value(b) + slack_m);
            let flag = |is: bool| if is { bit } else { 0 };
            sides.out = sides.out & !bit | flag((ha >= 0.0) & (hb >= 0.0));
            sides.within = sides.within & !bit | flag((ha <= 0.0) & (hb <= 0.0));
        }
    }

    /// What of the edge reaches into all half-planes but `i`.
    fn clipped(&self, edge: &Edge, cuts: &[HalfPlane], i: usize, slack_m: f64) -> Option<Edge> {
        let but = 1_u64.checked_shl(i as u32).unwrap_or(0);
        if self.out & !but != 0 {
            return None;
        }
        let across = |k: usize| k != i && (k >= 64 || self.within >> k & 1 == 0);
        let mut cuts = cuts.iter().enumerate().filter(|(k, _)| across(*k));
        cuts.try_fold(*edge, |edge, (_, cut)| clipped(&edge, cut, slack_m))
    }
}

/// Cuts that are made room for.
const CUTS: usize = 16;

/// Room that is used again.
#[derive(Default)]
struct Scratch {
    ahead: Vec<Ahead>,
    piece: Ring,
    spare: Ring,
}

/// The nearest point of the edges ahead.
#[derive(Default)]
struct Nearest {
    point: Option<Vector2<f64>>,
    square: f64,
}

impl Nearest {
    #[inline]
    fn take(&mut self, ahead: &Ahead) {
        if self.point.is_none() || ahead.square < self.square {
            self.point = Some(ahead.nearest);
            self.square = ahead.square;
        }
    }
}

/// An edge ahead of a growing piece, about its centre.
#[derive(Clone, Copy)]
struct Ahead {
    edge: Edge,
    /// The point of it that is nearest to the centre, and the square of its distance.
    nearest: Vector2<f64>,
    square: f64,
}

impl Ahead {
    fn new(edge: Edge) -> Self {
        let nearest = closest(&edge.0, &edge.1, &Point2::origin()).coords;
        Self {
            edge,
            nearest,
            square: nearest.norm_squared(),
        }
    }
}

/// The half-plane that keeps `centre` and most of the piece, and no inner point of what is `around`
/// the edges: of those along its sides.
fn best_cut(piece: &Ring, around: &Ring, centre: &Point2<f64>) -> Option<(f64, HalfPlane)> {
    let mut best: Option<(f64, HalfPlane)> = None;
    for (a, b) in around.edges().filter(|(a, b)| a != b) {
        // The far side of the hull's side: the hull is out, the centre must be in.
        let cut = HalfPlane::left_of(b, a);
        if cut.value(centre) > 0.0 {
            continue;
        }
        let area = piece.area_within(&cut);
        if best.as_ref().is_none_or(|(most, _)| area > *most) {
            best = Some((area, cut));
        }
    }
    best
}

/// What of an edge reaches more than `slack` into the half-plane.
#[inline]
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
