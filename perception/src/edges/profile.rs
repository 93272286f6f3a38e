//! Where the points of a face leave its plane, across an edge.

use nalgebra::Point2;

use super::pixel_ray::PixelRay;
use super::{APART_PX, Picture};

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

/// Where the points that count as the face's leave its plane across an edge, px: something narrow may
/// go on from the edge, the front of a board, that is within the noise of the plane point by point and
/// in the mean over the edge is not. `None` where they stay on it up to where the face
/// ends, `end_px` on in the median.
///
/// Residuals of inverse depth in units of their noise, averaged over the edge's places step by step,
/// against those farther inside; the slowly varying error is in both.
pub(super) fn leaves_px(
    picture: &impl Picture,
    label: u16,
    from: impl ExactSizeIterator<Item = Point2<f64>>,
    out: &PixelRay,
    end_px: f64,
) -> Option<f64> {
    if from.len() < PLACES_MIN {
        return None;
    }
    // No farther than the face goes.
    let ahead = (end_px / out.length).max(0.0) as usize + 2;
    let mut sums = [(0.0, 0.0); PROFILE];
    let sums = &mut sums[..(INNER + ahead).min(PROFILE)];
    let noise = picture.noise();
    let (mut places, mut slow) = (0.0, 0.0);
    for place in from {
        // Along a line of pixels a plane's inverse depth is a straight line, its noise nearly constant.
        let [Some(own), Some(next)] =
            [0.0, 1.0].map(|k| picture.plane(label, &out.place(&place, k)))
        else {
            continue;
        };
        let slope = next - own;
        let inverse = 1.0 / noise.sigma_at_inverse(own);
        places += 1.0;
        slow += noise.systematic_ratio * own * inverse;
        let first = -(INNER as f64);
        let mut own = own + first * slope;
        for ((sum, count), pixel) in sums.iter_mut().zip(out.pixels(&place, first)) {
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
    let waves = WAVES_SIGMAS * slow / places * out.length / noise.systematic_scale_px;
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
        (off > limit.max(LEAVES_MIN)).then_some(at * out.length)
    })
}
