//! What ends a face at each edge of its outline: a walk outward over what was seen.
//!
//! From places along an edge the walk leaves the face straight outward, over the pixels of the face
//! that were taken off its edge and over unmeasured ones, to the first that shows something else:
//!
//! - farther away than the face's plane, or on a plane that meets it there: the face ends, the edge
//!   is real;
//! - nearer than the plane, with a step: it hides how the face goes on, occluded;
//! - the border of what the sensor measured, or the range that is used: field of view;
//! - nothing for far, or the face again: unknown.
//!
//! Most of an edge's places decide. The picture is a depth image or a cloud's directions
//! ([`crate::directions`]).

use nalgebra::{Point2, Vector2};
use surfaces::EdgeKind;

use crate::extraction::Segmentation;
use crate::sensor::Noise;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shown {
    /// It is beyond what the sensor measures.
    Outside,
    /// Nothing was measured.
    Nothing,
    /// A point that has the label asked for.
    Face,
    /// Another point, with its inverse depth and the index of its plane, or [`NONE`].
    Other { w: f64, label: u16, used: bool },
}

/// The label of a point without a plane.
pub(crate) const NONE: u16 = Segmentation::NONE;

/// What was seen, on pixels.
pub(crate) trait Picture {
    /// What a pixel (column, row) shows to someone who asks for a label.
    fn at(&self, label: u16, pixel: [i32; 2]) -> Shown;
    /// Inverse depth of a pixel's point, 1/m, if it is used and has this label.
    fn on(&self, label: u16, pixel: [i32; 2]) -> Option<f64>;
    /// Inverse depth of a plane at a place, 1/m; `None` where it is not known or not met.
    fn plane(&self, label: u16, p: &Point2<f64>) -> Option<f64>;
    /// Angle between neighbouring pixels, rad.
    fn pixel_rad(&self) -> f64;
    /// The sensor's noise.
    fn noise(&self) -> &Noise;
}

/// The pixels nearest to places one step after another, which count in whole parts of a pixel.
struct Steps {
    at: [i64; 2],
    by: [i64; 2],
}

impl Steps {
    /// A pixel has 2 to this many parts.
    const BITS: u32 = 16;

    /// From `first` steps after a place on.
    fn new(from: &Point2<f64>, step: &Vector2<f64>, first: f64) -> Self {
        // Pixels have their middles at whole numbers.
        let at = from + step * first;
        let parts = f64::from(1_u32 << Self::BITS);
        Self {
            at: [at.x, at.y].map(|x| ((x + 0.5) * parts).floor() as i64),
            by: [step.x, step.y].map(|x| (x * parts) as i64),
        }
    }
}

impl Iterator for Steps {
    type Item = [i32; 2];

    #[inline]
    fn next(&mut self) -> Option<[i32; 2]> {
        let pixel = self.at.map(|x| (x >> Self::BITS) as i32);
        let [x, y] = &mut self.at;
        *x = x.wrapping_add(self.by[0]);
        *y = y.wrapping_add(self.by[1]);
        Some(pixel)
    }
}

/// Places along an edge are this far apart, px, and no more of them are looked at.
const APART_PX: f64 = 4.0;
const PLACES_MAX: usize = 24;
/// The walk ends after so many pixels.
const STEPS_MAX: usize = 96;
/// Without a measurement for more than this, the border of the view is not what cuts a face, px.
const BORDER_PX: usize = 32;
/// So many pixels of the face after a gap of so many are the face again; the band beside an edge in
/// which measurements drop out holds fewer.
const AGAIN_PX: usize = 4;
const GAP_PX: usize = 3;
/// Measurements drop out within two pixels of an edge on either side, and a little more: where more is
/// missing, it is one side's shadow.
const DROPPED_PX: usize = 5;
/// A point without a plane may be on the edge of one that is seen so many pixels on.
const BESIDE_PX: usize = 4;
/// A point is on a plane within √((5σ)² + (3κw)²), as pixels are that close a gap.
const SIGMAS: f64 = 5.0;
const SYSTEMATICS: f64 = 3.0;
/// Where two surfaces meet is known to this, px.
const MEETING_PX: f64 = 2.0;
/// Steps of a profile across an edge: so many, from so far inside; the first are the reference.
const PROFILE: usize = 24;
const INNER: usize = 12;
const REFERENCE: usize = 6;
/// Points leave a plane where their mean is off it by so many of its standard deviations, by so many of
/// the slowly varying error's change from step to step, and by this part of a single point's.
const LEAVES_SIGMAS: f64 = 3.0;
const WAVES_SIGMAS: f64 = 2.0;
const LEAVES_MIN: f64 = 0.5;
/// Fewer places are no mean.
const PLACES_MIN: usize = 2;
/// Where they are still as near as this in the end, they are the face's, in the same units.
const LEAVES_END: f64 = 1.2;
/// Steepest slope along the ray that something without a plane has, tan 80°.
const STEEPEST: f64 = 5.7;

/// What the walk from one place found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    /// What ends the face.
    pub kind: EdgeKind,
    /// How far on that is, px: in the middle between the last pixel of the face and the first that
    /// shows something else, where no more lies between than drops out on both sides of an edge; else
    /// right after the last pixel of the face.
    pub at_px: f64,
}

/// The kinds of a ring's edges, each from a corner to the next, and how far on the face ends in
/// the median of an edge's places, px.
///
/// The face, on the plane `label`, is on the ring's left where `left` says so, else on its right (in
/// the picture's axes as a mathematician draws them).
pub(crate) fn kinds(
    picture: &impl Picture,
    label: u16,
    ring: &[Point2<f64>],
    left: bool,
) -> Vec<(EdgeKind, f64)> {
    let next = ring.iter().cycle().skip(1);
    let (mut found, mut at_px) = (Vec::new(), Vec::new());
    ring.iter()
        .zip(next)
        .map(|(a, b)| {
            let along = b - a;
            let Some(ahead) = along.try_normalize(1e-9) else {
                return (EdgeKind::Unknown, 0.0);
            };
            let right = Vector2::new(ahead.y, -ahead.x);
            let out = if left { right } else { -right };
            let places = |apart_px: f64| {
                let count = (along.norm() / apart_px).ceil() as usize;
                let count = count.clamp(1, PLACES_MAX);
                (0..count).map(move |i| a + along * ((i as f64 + 0.5) / count as f64))
            };
            found.clear();
            found.extend(places(APART_PX).map(|place| beyond(picture, label, &place, &out)));
            at_px.clear();
            at_px.extend(found.iter().map(|found| found.at_px));
            let half = (at_px.len() - 1) / 2;
            let (_, &mut middle, _) = at_px.select_nth_unstable_by(half, f64::total_cmp);
            // What is off the plane goes along the whole edge: half of the places tell as much.
            let from = places(2.0 * APART_PX);
            // Real edges are round: what leaves the plane farther inside is the face still.
            let leaves = leaves_px(picture, label, from, &out, middle)
                .unwrap_or(middle)
                .max(0.0);
            (
                EdgeKind::most(found.iter().map(|f| f.kind)),
                middle.min(leaves),
            )
        })
        .collect()
}

/// Where the points that count as the face's leave its plane across an edge, px: something narrow may
/// go on from the edge, the front of a board, that is within the noise of the plane point by point and
/// in the mean over the edge is not. `None` where they stay on it up to where the face
/// ends, `end_px` on in the median.
///
/// Residuals of inverse depth in units of their noise, averaged over the edge's places step by step,
/// against those farther inside; the slowly varying error is in both.
fn leaves_px(
    picture: &impl Picture,
    label: u16,
    from: impl ExactSizeIterator<Item = Point2<f64>>,
    out: &Vector2<f64>,
    end_px: f64,
) -> Option<f64> {
    if from.len() < PLACES_MIN {
        return None;
    }
    let step = out / out.x.abs().max(out.y.abs()).max(1e-9);
    // No farther than the face goes.
    let ahead = (end_px / step.norm()).max(0.0) as usize + 2;
    let mut sums = [(0.0, 0.0); PROFILE];
    let sums = &mut sums[..(INNER + ahead).min(PROFILE)];
    let noise = picture.noise();
    let (mut places, mut slow) = (0.0, 0.0);
    for place in from {
        // Along a line of pixels a plane's inverse depth is a straight line, its noise nearly constant.
        let [Some(own), Some(next)] = [0.0, 1.0].map(|k| picture.plane(label, &(place + step * k)))
        else {
            continue;
        };
        let slope = next - own;
        let inverse = 1.0 / noise.sigma_at_inverse(own);
        places += 1.0;
        slow += noise.systematic_ratio * own * inverse;
        let first = -(INNER as f64);
        let mut own = own + first * slope;
        for ((sum, count), pixel) in sums.iter_mut().zip(Steps::new(&place, &step, first)) {
            if let Some(w) = picture.on(label, pixel) {
                *sum += (own - w) * inverse;
                *count += 1.0;
            }
            own += slope;
        }
    }
    if places < PLACES_MIN as f64 {
        return None;
    }
    // Places nearer than a correlated error is wide tell less than their number.
    let apart = APART_PX / (std::f64::consts::PI.sqrt() * noise.correlation_px);
    let alike = apart.min(1.0);
    let total = |part: &[(f64, f64)]| {
        let add = |a: (f64, f64), b: &(f64, f64)| (a.0 + b.0, a.1 + b.1);
        part.iter().fold((0.0, 0.0), add)
    };
    let (inner, beyond) = sums.split_at(REFERENCE);
    let (sum, count) = total(inner);
    if count < REFERENCE as f64 {
        return None;
    }
    let reference = sum / count;
    // Slowly varying errors differ by so much a step, in the same units.
    let waves = WAVES_SIGMAS * slow / places * step.norm() / noise.systematic_scale_px;
    // Two steps at a time, while most places are on the face: the first from which on they are off the
    // plane, if they end up well off it.
    let off = |pair: &[(f64, f64)]| {
        let (sum, count) = total(pair);
        (count >= places).then(|| ((sum / count - reference).abs(), count))
    };
    let offs = beyond.windows(2).map_while(off);
    if offs
        .clone()
        .last()
        .is_none_or(|(last, _)| last < LEAVES_END)
    {
        return None;
    }
    offs.enumerate().find_map(|(k, (off, count))| {
        let limit = LEAVES_SIGMAS / (0.5 * count * alike).sqrt();
        let wave = waves * (0.5 * REFERENCE as f64 + k as f64 + 1.0);
        let limit = (limit * limit + wave * wave).sqrt();
        let at = (REFERENCE + k) as f64 - INNER as f64 - 0.5;
        (off > limit.max(LEAVES_MIN)).then_some(at * step.norm())
    })
}

/// What ends the face beyond one place of its outline.
pub(crate) fn beyond(
    picture: &impl Picture,
    label: u16,
    from: &Point2<f64>,
    out: &Vector2<f64>,
) -> Found {
    // Steps from one pixel to the next.
    let step = out / out.x.abs().max(out.y.abs()).max(1e-9);
    let at = |k: usize| from + step * k as f64;
    let found = |kind: EdgeKind, last: usize, first: usize| {
        let between = first - last - 1;
        let half = if between <= DROPPED_PX {
            0.5 * between as f64
        } else {
            0.0
        };
        Found {
            kind,
            at_px: (last as f64 + 0.5 + half) * step.norm(),
        }
    };
    // The last pixel of the face before something else, and how many of it followed a gap.
    let (mut last, mut again, mut unlabelled) = (0, 0, None);
    for (k, pixel) in (1..STEPS_MAX + 1).zip(Steps::new(from, &step, 1.0)) {
        let own = || picture.plane(label, &at(k));
        let on = |w: f64| own().is_some_and(|own| near(picture, own, w));
        let other = match picture.at(label, pixel) {
            Shown::Outside if k - last > BORDER_PX => return found(EdgeKind::Unknown, last, k),
            Shown::Outside => return found(EdgeKind::FieldOfView, last, k),
            Shown::Nothing => continue,
            Shown::Face => None,
            Shown::Other { w, used, .. } if !used && on(w) => {
                return found(EdgeKind::FieldOfView, last, k);
            }
            Shown::Other { w, label, .. } => Some((w, label)).filter(|_| label != NONE || !on(w)),
        };
        let Some((w, its)) = other else {
            again += usize::from(again > 0 || k - last > GAP_PX);
            if again > AGAIN_PX {
                return found(EdgeKind::Unknown, last, last + 1);
            }
            last = k;
            unlabelled = None;
            continue;
        };
        if own().is_none_or(|own| w <= own) {
            return found(EdgeKind::Real, last, k);
        }
        // Something nearer than the plane: hidden, unless it meets the plane.
        let p = at(k);
        if picture.plane(its, &p).is_some() {
            let kind = if meets(picture, [label, its], &at(last), &p, &step) {
                EdgeKind::Real
            } else {
                EdgeKind::Occluded
            };
            let first = unlabelled.map_or(k, |(first, _)| first);
            return found(kind, last, first);
        }
        let (first, nearest) = *unlabelled.get_or_insert((k, w));
        if k - first >= BESIDE_PX {
            let own = picture.plane(label, &at(first)).unwrap_or(0.0);
            let steps = (first - last) as f64 + MEETING_PX;
            let rise = steps * picture.pixel_rad() * STEEPEST * nearest;
            let kind = if nearest - own <= rise {
                EdgeKind::Real
            } else {
                EdgeKind::Occluded
            };
            return found(kind, last, first);
        }
    }
    match unlabelled {
        Some((first, _)) => found(EdgeKind::Occluded, last, first),
        None => found(EdgeKind::Unknown, last, last + 1),
    }
}

/// Whether a point lies on a plane, both by inverse depth.
fn near(picture: &impl Picture, own: f64, w: f64) -> bool {
    let noise = picture.noise();
    let sigma = SIGMAS * noise.sigma_at_inverse(own);
    let systematic = SYSTEMATICS * noise.systematic_ratio * own;
    (w - own) * (w - own) <= sigma * sigma + systematic * systematic
}

/// Whether two planes meet between two places, as well as it is known where that is.
fn meets(
    picture: &impl Picture,
    labels: [u16; 2],
    from: &Point2<f64>,
    to: &Point2<f64>,
    step: &Vector2<f64>,
) -> bool {
    let apart = |p: &Point2<f64>| {
        let [own, its] = labels.map(|label| picture.plane(label, p));
        Some((own?, its? - own?))
    };
    let middle = from + (to - from) * 0.5;
    let (Some((w, apart_here)), Some((_, further))) = (apart(&middle), apart(&(middle + step)))
    else {
        return false;
    };
    let slope = (further - apart_here).abs() / step.norm();
    let reach = 0.5 * (to - from).norm() + MEETING_PX * step.norm();
    let noise = picture.noise();
    let sigma = 3.0 * noise.sigma_at_inverse(w);
    let slow = SYSTEMATICS * noise.systematic_ratio * w;
    apart_here.abs() <= (sigma * sigma + slow * slow).sqrt() + slope * reach
}
