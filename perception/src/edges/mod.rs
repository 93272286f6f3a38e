//! What ends a face at each edge of its outline: a walk outward over what was seen.
//!
//! From places along an edge the walk leaves the face straight outward, over the pixels of the face
//! that were taken off its edge and over unmeasured ones, to the first that shows something else:
//!
//! - on a plane that meets the face's there: nearer beyond their line it rises from the face, a fold;
//!   farther away the face ends, the edge is real;
//! - farther away than the face's plane: the face ends, the edge is real;
//! - nearer than the plane, with a step: it hides how the face goes on, occluded;
//! - the border of what the sensor measured, or the range that is used: field of view;
//! - nothing for far, or the face again: unknown.
//!
//! Most of an edge's places decide. The picture is a depth image or a cloud's directions
//! ([`crate::spherical_range_image`]).

mod pixel_ray;
mod profile;

use nalgebra::{Point2, Vector2};
use surfaces::EdgeKind;

use crate::extraction::Segmentation;
use crate::sensor::Noise;
pub(crate) use pixel_ray::PixelRay;
use profile::leaves_px;

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

/// Places along an edge are this far apart, px, and no more of them are looked at.
const APART_PX: f64 = 12.0;
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
/// Steepest slope along the ray that something without a plane has, tan 80°.
const STEEPEST: f64 = 5.7;

/// What the walk from a place found, or those from an edge's places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    /// What ends the face.
    pub kind: EdgeKind,
    /// How far on that is, px: where the planes of both sides meet; else in the middle between the last pixel of the
    /// face and the first that shows something else, where no more lies between than drops out on both sides of an
    /// edge; else right after the last pixel of the face.
    pub at_px: f64,
    /// Whether the planes of both sides meet there.
    pub meet: bool,
}

/// What ends a face at the edges of a ring, each from a corner to the next: what most of an edge's places found, and
/// the median of how far on.
///
/// The face, on the plane `label`, is on the ring's left where `left` says so, else on its right (in
/// the picture's axes as a mathematician draws them).
pub(crate) fn kinds(
    picture: &impl Picture,
    label: u16,
    ring: &[Point2<f64>],
    left: bool,
) -> impl Iterator<Item = Found> {
    let next = ring.iter().skip(1).chain(ring.first());
    let (mut found, mut at_px) = (Vec::new(), Vec::new());
    ring.iter().zip(next).map(move |(a, b)| {
        let along = b - a;
        let length = along.norm();
        if length <= 1e-9 {
            return Found {
                kind: EdgeKind::Unknown,
                at_px: 0.0,
                meet: false,
            };
        }
        let ahead = along / length;
        let right = Vector2::new(ahead.y, -ahead.x);
        let out = PixelRay::new(&if left { right } else { -right });
        let count = (length / APART_PX).ceil() as usize;
        let count = count.clamp(1, PLACES_MAX);
        let place = |t: f64| a + along * t;
        found.clear();
        found.extend(walks(picture, label, count, place, &out));
        // Most edges are short: their one place decides alone.
        if let &[found] = &found[..] {
            return found;
        }
        let kind = EdgeKind::most(found.iter().map(|found| found.kind));
        let meet = 2 * found.iter().filter(|found| found.meet).count() > found.len();
        at_px.clear();
        at_px.extend(found.iter().map(|found| found.at_px));
        let half = (at_px.len() - 1) / 2;
        let (_, &mut middle, _) = at_px.select_nth_unstable_by(half, f64::total_cmp);
        // The border of the view is where it is, whatever the face does before it.
        let end = |at_px| Found { kind, at_px, meet };
        if kind == EdgeKind::FieldOfView {
            return end(middle);
        }
        // Real edges are round: what leaves the plane farther inside is the face still.
        let leaves = leaves_px(picture, label, places(count).map(place), &out, middle)
            .unwrap_or(middle)
            .max(0.0);
        end(middle.min(leaves))
    })
}

/// What ends the face beyond so many places of an edge, each in the middle of a part of it: where the edge is at a
/// part t of its length, and the way outward.
pub(crate) fn walks(
    picture: &impl Picture,
    label: u16,
    count: usize,
    place: impl Fn(f64) -> Point2<f64>,
    out: &PixelRay,
) -> impl Iterator<Item = Found> {
    places(count).map(move |t| beyond(picture, label, &place(t), out))
}

fn places(count: usize) -> impl ExactSizeIterator<Item = f64> {
    (0..count).map(move |i| (i as f64 + 0.5) / count as f64)
}

/// What ends the face beyond one place of its outline.
fn beyond(picture: &impl Picture, label: u16, from: &Point2<f64>, out: &PixelRay) -> Found {
    let at = |k: usize| out.place(from, k as f64);
    let found = |kind: EdgeKind, last: usize, first: usize| {
        let between = first - last - 1;
        let half = if between <= DROPPED_PX {
            0.5 * between as f64
        } else {
            0.0
        };
        Found {
            kind,
            at_px: (last as f64 + 0.5 + half) * out.length,
            meet: false,
        }
    };
    // Where the plane of what follows meets the face's the face ends, and by which is nearer beyond the other one rises
    // or falls: a single point there tells neither.
    let meeting = |last: usize, first: usize, its: u16| {
        let met = meet_at(picture, [label, its], &at(last), &at(first), out)?;
        let kind = if met.rises {
            EdgeKind::Fold
        } else {
            EdgeKind::Real
        };
        let end = found(kind, last, first);
        Some(met.steps.map_or(end, |steps| Found {
            at_px: (last as f64 + steps) * out.length,
            meet: true,
            ..end
        }))
    };
    // The last pixel of the face before something else, and how many of it followed a gap.
    let (mut last, mut again, mut unlabelled) = (0, 0, None);
    for (k, pixel) in (1..STEPS_MAX + 1).zip(out.pixels(from, 1.0)) {
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
            if again > 0 || k - last > GAP_PX {
                again += 1;
                if again > AGAIN_PX {
                    return found(EdgeKind::Unknown, last, last + 1);
                }
            }
            last = k;
            unlabelled = None;
            continue;
        };
        if let Some(end) = meeting(last, k, its) {
            return end;
        }
        if own().is_none_or(|own| w <= own) {
            return found(EdgeKind::Real, last, k);
        }
        // Something nearer than the plane that does not meet it hides it.
        if picture.plane(its, &at(k)).is_some() {
            let first = unlabelled.map_or(k, |(first, _)| first);
            return found(EdgeKind::Occluded, last, first);
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

/// Where two planes meet.
struct Met {
    /// Whether the other one is nearer than the face's beyond.
    rises: bool,
    /// How many steps on that is; `None` where it is anywhere within the noise.
    steps: Option<f64>,
}

/// Where two planes meet between two places, if they do as well as it is known.
fn meet_at(
    picture: &impl Picture,
    labels: [u16; 2],
    from: &Point2<f64>,
    to: &Point2<f64>,
    out: &PixelRay,
) -> Option<Met> {
    let apart = |p: &Point2<f64>| {
        let [own, its] = labels.map(|label| picture.plane(label, p));
        Some((own?, its? - own?))
    };
    let middle = from + (to - from) * 0.5;
    let (w, apart_here) = apart(&middle)?;
    let (_, further) = apart(&out.place(&middle, 1.0))?;
    let slope = further - apart_here;
    let half = 0.5 * (to - from).norm() / out.length;
    let noise = picture.noise();
    let sigma = 3.0 * noise.sigma_at_inverse(w);
    let slow = SYSTEMATICS * noise.systematic_ratio * w;
    let known = (sigma * sigma + slow * slow).sqrt();
    let reach = half + MEETING_PX;
    let within = |off: f64| apart_here.abs() <= off + slope.abs() * reach;
    (slope != 0.0 && within(known)).then(|| Met {
        rises: slope > 0.0,
        steps: within(0.0).then(|| half - apart_here / slope),
    })
}
