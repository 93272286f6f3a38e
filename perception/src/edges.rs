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

use crate::sensor::Noise;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shown {
    /// It is beyond what the sensor measures.
    Outside,
    /// Nothing was measured.
    Nothing,
    /// A point, with its inverse depth and the index of its plane, or [`NONE`].
    Point { w: f64, label: u16, used: bool },
}

/// The label of a point without a plane.
pub(crate) const NONE: u16 = u16::MAX;

/// What was seen, on pixels.
pub(crate) trait Picture {
    /// What the nearest pixel shows.
    fn at(&self, p: &Point2<f64>) -> Shown;
    /// Inverse depth of a plane at a place, 1/m; `None` where it is not known or not met.
    fn plane(&self, label: u16, p: &Point2<f64>) -> Option<f64>;
    /// Angle between neighbouring pixels, rad.
    fn pixel_rad(&self) -> f64;
    /// The sensor's noise.
    fn noise(&self) -> &Noise;
}

/// Places along an edge are this far apart, px, and no more of them are looked at.
const APART_PX: f64 = 4.0;
const PLACES_MAX: usize = 48;
/// The walk ends after so many pixels.
const STEPS_MAX: usize = 96;
/// Without a measurement for more than this, the border of the view is not what cuts a face, px.
const BORDER_PX: usize = 32;
/// So many pixels of the face after a gap of so many are the face again; the band beside an edge in
/// which measurements drop out holds fewer.
const AGAIN_PX: usize = 4;
const GAP_PX: usize = 3;
/// A point without a plane may be on the edge of one that is seen so many pixels on.
const BESIDE_PX: usize = 4;
/// A point is on a plane within √((5σ)² + (3κw)²), as pixels are that close a gap.
const SIGMAS: f64 = 5.0;
const SYSTEMATICS: f64 = 3.0;
/// Where two surfaces meet is known to this, px.
const MEETING_PX: f64 = 2.0;
/// Steepest slope along the ray that something without a plane has, tan 80°.
const STEEPEST: f64 = 5.7;

/// The kinds of a ring's edges, each from a corner to the next.
///
/// The face, on the plane `label`, is on the ring's left where `left` says so, else on its right (in
/// the picture's axes as a mathematician draws them).
pub(crate) fn kinds(
    picture: &impl Picture,
    label: u16,
    ring: &[Point2<f64>],
    left: bool,
) -> Vec<EdgeKind> {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(a, b)| {
            let along = b - a;
            let Some(ahead) = along.try_normalize(1e-9) else {
                return EdgeKind::Unknown;
            };
            let right = Vector2::new(ahead.y, -ahead.x);
            let out = if left { right } else { -right };
            let places = ((along.norm() / APART_PX).ceil() as usize).clamp(1, PLACES_MAX);
            let found = (0..places).map(|i| {
                let t = (i as f64 + 0.5) / places as f64;
                beyond(picture, label, &(a + along * t), &out)
            });
            EdgeKind::most(found)
        })
        .collect()
}

/// What ends the face beyond one place of its outline.
pub(crate) fn beyond(
    picture: &impl Picture,
    label: u16,
    from: &Point2<f64>,
    out: &Vector2<f64>,
) -> EdgeKind {
    // Steps from one pixel to the next.
    let step = out / out.x.abs().max(out.y.abs()).max(1e-9);
    let at = |k: usize| from + step * k as f64;
    // The last pixel of the face before something else, and how many of it followed a gap.
    let (mut last, mut again, mut unlabelled) = (0, 0, None);
    for k in 1..=STEPS_MAX {
        let p = at(k);
        let (w, its) = match picture.at(&p) {
            Shown::Outside if k - last > BORDER_PX => return EdgeKind::Unknown,
            Shown::Outside => return EdgeKind::FieldOfView,
            Shown::Nothing => continue,
            Shown::Point {
                w,
                label: its,
                used,
            } => {
                let own = || picture.plane(label, &p);
                let on = || own().is_some_and(|own| near(picture, own, w));
                if !used && on() {
                    return EdgeKind::FieldOfView;
                }
                if its == label || (its == NONE && on()) {
                    again += usize::from(again > 0 || k - last > GAP_PX);
                    if again > AGAIN_PX {
                        return EdgeKind::Unknown;
                    }
                    last = k;
                    unlabelled = None;
                    continue;
                }
                if own().is_none_or(|own| w <= own) {
                    return EdgeKind::Real;
                }
                (w, its)
            }
        };
        // Something nearer than the plane: hidden, unless it meets the plane.
        if picture.plane(its, &p).is_some() {
            return if meets(picture, [label, its], &at(last), &p, &step) {
                EdgeKind::Real
            } else {
                EdgeKind::Occluded
            };
        }
        let (first, nearest) = *unlabelled.get_or_insert((k, w));
        if k - first >= BESIDE_PX {
            let own = picture.plane(label, &at(first)).unwrap_or(0.0);
            let steps = (first - last) as f64 + MEETING_PX;
            let rise = steps * picture.pixel_rad() * STEEPEST * nearest;
            return if nearest - own <= rise {
                EdgeKind::Real
            } else {
                EdgeKind::Occluded
            };
        }
    }
    match unlabelled {
        Some(_) => EdgeKind::Occluded,
        None => EdgeKind::Unknown,
    }
}

/// Whether a point lies on a plane, both by inverse depth.
fn near(picture: &impl Picture, own: f64, w: f64) -> bool {
    let noise = picture.noise();
    let sigma = SIGMAS * noise.sigma_inverse(1.0 / own.max(1e-6));
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
    let sigma = 3.0 * noise.sigma_inverse(1.0 / w.max(1e-6));
    apart_here.abs() <= sigma.hypot(SYSTEMATICS * noise.systematic_ratio * w) + slope * reach
}
