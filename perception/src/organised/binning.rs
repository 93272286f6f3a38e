//! Images finer than what is told in pixels is meant for.

use crate::scan::DepthImage;
use crate::sensor::{Intrinsics, Noise};

/// Cells, edges, gaps and the waves of the noise are told in pixels of cameras of about this focal length, px.
const FOCAL_PX: f64 = 525.0;
/// Pixels of a block that are nearer than so many standard deviations are of one surface.
const SIGMAS: f64 = 5.0;

/// How many pixels of an image are to be one, each way: of one that is finer by so much.
pub(super) fn ratio(depth: &DepthImage) -> usize {
    let f = 0.5 * (depth.intrinsics.fx + depth.intrinsics.fy);
    (f / FOCAL_PX).round().max(1.0) as usize
}

/// The image with blocks of `ratio` × `ratio` pixels as one: the mean of those of one surface with the measured pixel
/// that is nearest to the block's middle. A margin narrower than a block is left out.
pub(super) fn binned(depth: &DepthImage, ratio: usize, noise: &Noise) -> DepthImage {
    let (width, height) = (depth.width / ratio, depth.height / ratio);
    let middle = (ratio as f64 - 1.0) / 2.0;
    let mut order: Vec<(usize, usize)> =
        (0..ratio * ratio).map(|i| (i % ratio, i / ratio)).collect();
    let off = |(x, y): &(usize, usize)| (*x as f64 - middle).hypot(*y as f64 - middle);
    order.sort_by(|a, b| off(a).total_cmp(&off(b)));
    let block = |x: usize, y: usize| {
        let first = y * ratio * depth.width + x * ratio;
        let measured = (order.iter())
            .map(|(x, y)| f64::from(depth.z_m[first + y * depth.width + x]))
            .filter(|z| *z > 0.0)
            .map(f64::recip);
        let Some(nearest) = measured.clone().next() else {
            return 0.0;
        };
        let limit = SIGMAS * noise.sigma_at_inverse(nearest);
        let same = measured.filter(|w| (w - nearest).abs() <= limit);
        let (sum, count) = same.fold((0.0, 0.0), |(sum, count), w| (sum + w, count + 1.0));
        (count / sum) as f32
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let (k, n) = (depth.intrinsics, ratio as f64);
    DepthImage {
        width,
        height,
        z_m: places.map(|(x, y)| block(x, y)).collect(),
        intrinsics: Intrinsics {
            fx: k.fx / n,
            fy: k.fy / n,
            cx: (k.cx - middle) / n,
            cy: (k.cy - middle) / n,
        },
    }
}

/// What is known of a binned image's pixels for those of the image itself, `none` in the margin.
pub(super) fn spread<T: Copy>(
    known: &[T],
    width: usize,
    of: &DepthImage,
    ratio: usize,
    none: T,
) -> Vec<T> {
    let height = known.len() / width.max(1);
    let at = |i: usize| {
        let (x, y) = (i % of.width / ratio, i / of.width / ratio);
        let inside = x < width && y < height;
        inside.then(|| known[y * width + x])
    };
    (0..of.z_m.len()).map(|i| at(i).unwrap_or(none)).collect()
}
