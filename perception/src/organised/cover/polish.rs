//! The cuts of a piece, turned to where they cost least.

use wide::{f32x8, u32x8};

use super::grow::{Piece, Region};
use super::rows::{Frame, Rows};
use super::segments::{Cut, Point, Segments};

/// LabelBoundaries that take off less than this ratio of a piece stay as they are.
const SLIVER: f32 = 0.003;

/// The piece with each cut replaced by the one that keeps most among those that keep its centroid and keep
/// out the same edges: the lines through two of the corners that are then in the way.
pub(super) fn polished(region: &Region, piece: &Piece) -> Option<Piece> {
    let frame = region.frame;
    let (centre, _) = piece.rows.ellipse(frame, &[0.0; 2])?;
    let mut cuts = piece.cuts.clone();
    let mut sides = Sides::of(region, &cuts);
    // What the cuts after each leave.
    let mut after = vec![Rows::ALL; cuts.len()];
    for i in (1..cuts.len()).rev() {
        let mut rows = after[i].clone();
        rows.cut(frame, &cuts[i]);
        after[i - 1] = rows;
    }
    let mut rows = region.hull.clone();
    let mut corners: Vec<Point> = Vec::with_capacity(64);
    let mut needless = Vec::new();
    for i in 0..cuts.len() {
        let own = bit(i);
        let mut without = rows.clone();
        without.both(&after[i]);
        let old = without.area_within(frame, &cuts[i]);
        // Slivers are not worth it.
        if without.area(frame) - old >= SLIVER * old {
            corners.clear();
            for (sides, edges) in sides.iter().zip(&region.edges) {
                let free = sides.free(own);
                if free != 0 {
                    sides.corners(edges, free, &cuts, i, region.slack_m, &mut corners);
                }
            }
            if corners.is_empty() {
                needless.push(i);
                // Nothing is out of it.
                cuts[i].b = f32::INFINITY;
                sides.iter_mut().for_each(|sides| sides.forget(own));
                continue;
            }
            if let Some(cut) = best_cut(frame, &without, &corners, &cuts[i], &centre)
                && without.area_within(frame, &cut) > old * 1.001
            {
                cuts[i] = cut;
                for (sides, edges) in sides.iter_mut().zip(&region.edges) {
                    sides.set(own, edges, &cut, region.slack_m);
                }
            }
        }
        rows.cut(frame, &cuts[i]);
    }
    for i in needless.into_iter().rev() {
        cuts.remove(i);
    }
    Some(Piece { cuts, rows })
}

/// On which side of the cuts eight edges wholly lie, one bit a cut; of cuts after the last bit nothing is
/// said.
#[derive(Clone, Copy, Default)]
struct Sides {
    out: u32x8,
    within: u32x8,
}

impl Sides {
    fn of(region: &Region, cuts: &[Cut]) -> Vec<Self> {
        let mut sides = vec![Self::default(); region.edges.len()];
        for (i, cut) in cuts.iter().enumerate() {
            let own = bit(i);
            for (sides, edges) in sides.iter_mut().zip(&region.edges) {
                sides.set(own, edges, cut, region.slack_m);
            }
        }
        sides
    }

    /// What is known of the cut with this bit.
    #[inline]
    fn set(&mut self, own: u32x8, edges: &Segments, cut: &Cut, slack_m: f32) {
        let [ha, hb] = edges.values(&cut.n, cut.b - slack_m);
        let out = ha.fast_min(hb).simd_ge(f32x8::ZERO);
        let within = ha.fast_max(hb).simd_le(f32x8::ZERO);
        self.out = (self.out & !own) | (lanes(out) & own);
        self.within = (self.within & !own) | (lanes(within) & own);
    }

    /// A cut that nothing is out of.
    fn forget(&mut self, own: u32x8) {
        self.out &= !own;
        self.within |= own;
    }

    /// The edges that are wholly out of no half-plane but the one with this bit, one bit each.
    #[inline]
    fn free(&self, own: u32x8) -> u32 {
        (self.out & !own).simd_eq(u32x8::ZERO).to_bitmask()
    }

    /// Adds the ends of what of the `free` edges reaches into all half-planes but `i`.
    fn corners(
        &self,
        edges: &Segments,
        free: u32,
        cuts: &[Cut],
        i: usize,
        slack_m: f32,
        to: &mut Vec<Point>,
    ) {
        // The cuts that it is not within.
        let all = u32x8::splat(u32::MAX >> (32 - cuts.len().clamp(1, 32)));
        let crossed = (!self.within & !bit(i) & all).to_array();
        for (k, a, b) in edges.of(free) {
            let mut left = Some((a, b));
            let mut crossed = crossed[k];
            while crossed != 0
                && let Some(edge) = left
            {
                left = clipped(&edge, &cuts[crossed.trailing_zeros() as usize], slack_m);
                crossed &= crossed - 1;
            }
            let mut others = cuts.iter().enumerate().skip(32).filter(|(c, _)| *c != i);
            let left = left.and_then(|edge| {
                others.try_fold(edge, |edge, (_, cut)| clipped(&edge, cut, slack_m))
            });
            if let Some((a, b)) = left {
                // Edges mostly follow each other.
                if to.last() != Some(&a) {
                    to.push(a);
                }
                to.push(b);
            }
        }
    }
}

/// The bit of a cut.
fn bit(i: usize) -> u32x8 {
    u32x8::splat(1_u32.checked_shl(i as u32).unwrap_or(0))
}

/// All bits of the lanes of which something is true.
fn lanes(is: f32x8) -> u32x8 {
    u32x8::from(is.to_array().map(f32::to_bits))
}

/// What of an edge reaches more than `slack` into the half-plane.
#[inline]
fn clipped(&(a, b): &(Point, Point), keep: &Cut, slack: f32) -> Option<(Point, Point)> {
    let (ha, hb) = (keep.value(&a) + slack, keep.value(&b) + slack);
    if ha >= 0.0 && hb >= 0.0 {
        return None;
    }
    if ha <= 0.0 && hb <= 0.0 {
        return Some((a, b));
    }
    let t = ha / (ha - hb);
    let p = [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
    Some(if ha > 0.0 { (p, b) } else { (a, p) })
}

/// The half-plane that keeps `centre` and most of the piece, and no corner: of those along the sides of
/// the corners' hull, from where it touches `old` on as long as they get better.
fn best_cut(
    frame: &Frame,
    piece: &Rows,
    corners: &[Point],
    old: &Cut,
    centre: &Point,
) -> Option<Cut> {
    let mut corners_of = corners.iter();
    let first = corners_of.next()?;
    let nearer = |best, p| {
        if old.value(p) < old.value(best) {
            p
        } else {
            best
        }
    };
    let touched = corners_of.fold(first, nearer);
    let mut best: Option<(f32, Cut)> = None;
    for turn in [1.0, -1.0] {
        let (mut here, mut most) = (*touched, f32::NEG_INFINITY);
        for _ in 0..corners.len() {
            let next = around(corners, &here, turn);
            let (a, b) = if turn > 0.0 {
                (next, here)
            } else {
                (here, next)
            };
            // The far side of the hull's side: the hull is out, the centre must be in.
            let Some(cut) = Cut::left_of(&a, &b).filter(|cut| cut.value(centre) <= 0.0) else {
                break;
            };
            let area = piece.area_within(frame, &cut);
            if area <= most {
                break;
            }
            if best.as_ref().is_none_or(|(best, _)| area > *best) {
                best = Some((area, cut));
            }
            (here, most) = (next, area);
        }
    }
    best.map(|(_, cut)| cut)
}

/// The corner of the points' hull that follows one, counter-clockwise for a positive turn.
///
/// Source: gift wrapping.
fn around(points: &[Point], from: &Point, turn: f32) -> Point {
    let mut next = *from;
    let mut along = [0.0; 2];
    for p in points {
        let d = [p[0] - from[0], p[1] - from[1]];
        let off = (along[0] * d[1] - along[1] * d[0]) * turn;
        let far = d[0] * d[0] + d[1] * d[1];
        // All others are to be on the left of the side; of those on it the farthest counts.
        if off < 0.0 || (off == 0.0 && far > along[0] * along[0] + along[1] * along[1]) {
            (next, along) = (*p, d);
        }
    }
    next
}
