//! One convex piece, grown from a point until the edges of the region stop it.

use super::rows::{Frame, Rows};
use super::segments::{Ahead, Cut, Point, Segments};

/// Most rounds of growing a piece about its own ellipse.
const ROUNDS: usize = 4;

/// LabelBoundaries that are made room for, and most of them.
const CUTS: usize = 16;
const CUTS_MAX: usize = 256;

/// A piece: what cuts leave of the hull of the region.
pub(super) struct Piece {
    pub cuts: Vec<Cut>,
    pub rows: Rows,
}

impl Piece {
    /// Whether the cuts leave a point.
    pub fn keeps(&self, p: &Point) -> bool {
        self.cuts.iter().all(|cut| cut.value(p) <= 0.0)
    }
}

/// What stops a piece: the edges of its region, but for those of its hull.
pub(super) struct Region<'a> {
    pub frame: &'a Frame,
    /// The rows of the hull.
    pub hull: Rows,
    /// The parts of the edges that reach into the hull.
    pub edges: Vec<Segments>,
    pub slack_m: f32,
    ahead: Ahead,
}

impl<'a> Region<'a> {
    /// The region with these edges and these sides of its hull; edges reach up to `slack_m` into a piece.
    pub fn new(frame: &'a Frame, sides: &[Cut], edges: &[(Point, Point)], slack_m: f32) -> Self {
        let mut inner = Segments::list(edges);
        let mut hull = Rows::ALL;
        for side in sides {
            hull.cut(frame, side);
            for edges in &mut inner {
                edges.clip(&side.n, side.b - slack_m);
            }
        }
        inner.retain(|edges| !edges.is_gone());
        Self {
            frame,
            hull,
            edges: inner,
            slack_m,
            ahead: Ahead::default(),
        }
    }

    /// Whether no edge reaches into the hull.
    pub fn is_convex(&self) -> bool {
        self.edges.is_empty()
    }

    /// A convex piece around a point, cut by the edges nearest to it.
    pub fn start(&mut self, seed: &Point) -> Option<Piece> {
        self.inflate(seed, &[1.0, 0.0, 1.0])
    }

    /// Grows it: cut by the edges nearest in the metric of its own second moments, while it is worth more.
    ///
    /// Source: the alternation of [deits2015], with the moments in place of the inscribed ellipse.
    pub fn grow(&mut self, start: &Piece, worth: &dyn Fn(&Rows) -> f32) -> Option<Piece> {
        let mut best = None;
        let mut most = worth(&start.rows);
        let mut about = start.rows.ellipse(self.frame, &[0.0; 2]);
        for _ in 0..ROUNDS {
            let Some((centre, metric)) = about else { break };
            let Some(next) = self.inflate(&centre, &metric) else {
                break;
            };
            let now = worth(&next.rows);
            let better = now > most * 1.005;
            about = next.rows.ellipse(self.frame, &centre);
            if now > most {
                (best, most) = (Some(next), now);
            }
            if !better {
                break;
            }
        }
        best
    }

    /// The hull, cut off at the nearest edge, then at the nearest edge left, and so on; near in
    /// the metric ‖M (p − c)‖, M = [[m₀, 0], [m₁, m₂]].
    fn inflate(&mut self, centre: &Point, metric: &[f32; 3]) -> Option<Piece> {
        let [m0, m1, m2] = *metric;
        // In coordinates that make the metric Euclidean.
        self.ahead.fill(&self.edges, centre, metric);
        let mut cuts = Vec::with_capacity(CUTS);
        let mut rows = self.hull.clone();
        while let Some(q) = self.ahead.nearest() {
            if cuts.len() == CUTS_MAX {
                return None;
            }
            let length = (q[0] * q[0] + q[1] * q[1]).sqrt();
            if length < 1e-9 {
                return None;
            }
            // Tangent to the ellipse through the nearest point: u·M (p − c) ≤ ‖q‖, u = q/‖q‖.
            let u = q.map(|x| x / length);
            let n = [m0 * u[0] + m1 * u[1], m2 * u[1]];
            let scale = (n[0] * n[0] + n[1] * n[1]).sqrt();
            let n = n.map(|x| x / scale);
            let b = length / scale + n[0] * centre[0] + n[1] * centre[1];
            let cut = Cut { n, b };
            rows.cut(self.frame, &cut);
            cuts.push(cut);
            // Lengths along its normal are ‖Mᵀ u‖ times as long there.
            let slack = (self.slack_m * scale).max(1e-5 * length);
            self.ahead.clip(&u, length - slack);
        }
        Some(Piece { cuts, rows })
    }
}
