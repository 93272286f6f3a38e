//! A region that is not convex, covered by few maximal convex pieces.

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};
use surfaces::{ConvexPolygon, HalfPlane};

use crate::Error;
use crate::error::within;

/// How a face is covered by convex polygons.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CoverConfig {
    /// Concavities no deeper than this are noise of the edge, px.
    pub notch_px: f64,
    /// The cover stops when this ratio of the face is covered.
    pub ratio: f64,
    /// Most pieces of one face.
    pub pieces_max: usize,
    /// Most corners of one piece; corners are dropped, so that a piece only shrinks.
    pub vertices_max: usize,
    /// Smallest piece, and smallest area that a further piece must add, m².
    pub area_min_m2: f64,
    /// Smallest width of a piece (diameter of the largest inscribed circle), m.
    pub width_min_m: f64,
}

impl Default for CoverConfig {
    fn default() -> Self {
        Self {
            notch_px: 1.5,
            ratio: 0.96,
            pieces_max: 8,
            vertices_max: 12,
            area_min_m2: 0.005,
            width_min_m: 0.04,
        }
    }
}

impl CoverConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        within(
            "notch_px",
            self.notch_px,
            0.0,
            64.0,
            "must be in [0, 64] px",
        )?;
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
            "width_min_m",
            self.width_min_m,
            0.0,
            1e3,
            "must not be negative",
        )
    }
}

/// A region on a raster, sampled.
///
/// The raster is the pixel plane of an image or a grid in the plane of the face: convex sets of
/// one are convex sets of the other.
pub(super) struct Region {
    /// Convex hull of the region.
    pub hull: ConvexPolygon,
    /// Sample points of the hull: position, area (m²), and whether the region holds them.
    pub samples: Vec<Sample>,
    /// Points just outside of the region's edge, all around it: no piece may hold one.
    pub outside: Vec<Point2<f64>>,
}

/// One sample of the hull.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub p: Point2<f64>,
    pub area_m2: f64,
    pub inside: bool,
}

/// What is left of the samples' worth.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Air,
    Uncovered,
    Covered,
}

/// A covered sample counts this much: it makes pieces overlap rather than end at a seam.
const OVERLAP_WORTH: f64 = 0.1;
/// Directions tried for each cut, and rounds of refinement around the best one.
const DIRECTIONS: usize = 48;
const REFINEMENTS: usize = 4;
/// Bins along a direction.
const BINS: usize = 96;

/// Convex pieces of the region, the first of most area; the greedy cover.
///
/// Every piece is cut from the hull: while a point outside of the region lies deeper than the
/// notch tolerance in the piece, the half-plane that loses least is cut off through it.
pub(super) fn cover(region: &Region, config: &CoverConfig) -> Vec<ConvexPolygon> {
    let mut kinds: Vec<Kind> = region
        .samples
        .iter()
        .map(|s| if s.inside { Kind::Uncovered } else { Kind::Air })
        .collect();
    let total: f64 = region
        .samples
        .iter()
        .filter(|s| s.inside)
        .map(|s| s.area_m2)
        .sum();
    let mut covered = 0.0;
    let mut pieces = Vec::new();
    for _ in 0..config.pieces_max {
        let Some(piece) = largest_piece(region, &kinds, config.notch_px) else {
            break;
        };
        // What the piece adds.
        let mut gain = 0.0;
        let mut next = kinds.clone();
        for (sample, kind) in region.samples.iter().zip(&mut next) {
            if *kind == Kind::Uncovered && piece.contains(&sample.p, 0.5) {
                gain += sample.area_m2;
                *kind = Kind::Covered;
            }
        }
        if gain < config.area_min_m2.max(0.02 * total) {
            break;
        }
        kinds = next;
        covered += gain;
        pieces.push(piece);
        if covered >= config.ratio * total {
            break;
        }
    }
    pieces
}

/// One convex piece of the region that holds much of what is uncovered.
fn largest_piece(region: &Region, kinds: &[Kind], notch_px: f64) -> Option<ConvexPolygon> {
    let mut piece = region.hull.clone();
    let mut outside = region.outside.clone();
    let mut samples: Vec<(Point2<f64>, f64)> = region
        .samples
        .iter()
        .zip(kinds)
        .map(|(s, kind)| {
            let worth = match kind {
                Kind::Air => -1.0,
                Kind::Uncovered => 1.0,
                Kind::Covered => OVERLAP_WORTH,
            };
            (s.p, worth * s.area_m2)
        })
        .collect();
    loop {
        // The outside points that are in the piece by more than the tolerance; the deepest one.
        let planes = piece.half_planes();
        let depth = |p: &Point2<f64>| {
            -planes
                .iter()
                .map(|h| h.value(p))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let mut deepest: Option<(f64, Point2<f64>)> = None;
        outside.retain(|p| {
            let d = depth(p);
            if d > notch_px && deepest.is_none_or(|(most, _)| d > most) {
                deepest = Some((d, *p));
            }
            d > notch_px
        });
        let Some((_, through)) = deepest else {
            return Some(piece);
        };
        let cut = best_cut(&through, &outside, &samples);
        piece = piece.clip(&cut)?;
        samples.retain(|(p, _)| cut.value(p) <= 0.0);
    }
}

/// The half-plane to keep: its line passes at or before `through`, touches an outside point, and
/// what it keeps is worth most.
fn best_cut(
    through: &Point2<f64>,
    outside: &[Point2<f64>],
    samples: &[(Point2<f64>, f64)],
) -> HalfPlane {
    let try_at = |angle: f64| {
        let n = Vector2::new(angle.cos(), angle.sin());
        let (worth, t) = best_offset(&n, through, outside, samples);
        (worth, angle, t)
    };
    let turn = std::f64::consts::TAU / DIRECTIONS as f64;
    let better = |a: (f64, f64, f64), b: (f64, f64, f64)| if b.0 > a.0 { b } else { a };
    let mut best = (0..DIRECTIONS)
        .map(|k| try_at(k as f64 * turn))
        .fold((f64::NEG_INFINITY, 0.0, through.x), better);
    let mut spread = turn / 2.0;
    for _ in 0..REFINEMENTS {
        let angle = best.1;
        best = better(better(best, try_at(angle - spread)), try_at(angle + spread));
        spread /= 2.0;
    }
    HalfPlane {
        n: Vector2::new(best.1.cos(), best.1.sin()),
        b: best.2,
    }
}

/// The most that {n·p ≤ t} can keep over the offsets t of outside points at or before `through`,
/// and that t.
fn best_offset(
    n: &Vector2<f64>,
    through: &Point2<f64>,
    outside: &[Point2<f64>],
    samples: &[(Point2<f64>, f64)],
) -> (f64, f64) {
    let last = n.dot(&through.coords);
    let first = outside
        .iter()
        .map(|p| n.dot(&p.coords))
        .fold(last, f64::min);
    // Worth of the samples by their place along n: below `first`, then in bins up to `last`.
    let scale = BINS as f64 / (last - first).max(1e-9);
    let mut below = 0.0;
    let mut bins = [0.0; BINS + 1];
    for (p, worth) in samples {
        let t = n.dot(&p.coords);
        if t <= first {
            below += worth;
        } else if t <= last {
            bins[(((t - first) * scale).ceil() as usize).min(BINS)] += worth;
        }
    }
    bins[0] += below;
    for k in 0..BINS {
        bins[k + 1] += bins[k];
    }
    let mut best = (bins[BINS], last);
    for p in outside {
        let t = n.dot(&p.coords);
        if t < last {
            let worth = bins[(((t - first) * scale).floor() as usize).min(BINS)];
            if worth > best.0 || (worth == best.0 && t > best.1) {
                best = (worth, t);
            }
        }
    }
    best
}
