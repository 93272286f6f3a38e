//! Depth images that are likely read with the wrong model of their sensor.

use crate::DepthImage;

/// Principal points are no farther from the middle of an image than this part of its size.
const OFF_CENTRE_MAX: f64 = 0.1;
/// Focal lengths of depth cameras, over the longer side of their image: 140° to 20° of view.
const FOCAL: std::ops::RangeInclusive<f64> = 0.18..=2.8;
/// Distance of the pixels that are compared, in focal lengths, and of those in the middle, px.
const REACH: f64 = 0.25;
const STEP: usize = 16;
/// As many comparisons tell.
const COUNT_MIN: usize = 200;
/// Distances along the rays bend less than depths by this factor. Depths of real and simulated frames bend
/// at most as much, 1/1.03 to 1/5; where planes are seen, distances taken for depths do by 0.22 to 0.43.
const BENDS_LESS: f64 = 0.5;

/// What is likely wrong, in words.
pub(crate) fn doubts(image: &DepthImage) -> Vec<String> {
    [off_centre(image), focal_length(image), distances(image)]
        .into_iter()
        .flatten()
        .collect()
}

/// Why an image's intrinsics are likely those of another size.
fn off_centre(image: &DepthImage) -> Option<String> {
    let k = image.intrinsics;
    let (width, height) = (image.width, image.height);
    let off = |c: f64, size: usize| ((c + 0.5) / size as f64 - 0.5).abs() > OFF_CENTRE_MAX;
    (off(k.cx, width) || off(k.cy, height)).then(|| {
        format!(
            "the principal point ({}, {}) is far from the middle of {width}x{height} pixels: intrinsics of another \
             image size?",
            k.cx, k.cy
        )
    })
}

/// Why an image's focal length is likely in another unit, or of another image size.
fn focal_length(image: &DepthImage) -> Option<String> {
    let k = image.intrinsics;
    let lengths = [k.fx, k.fy].map(|f| f / image.width.max(image.height) as f64);
    let told = lengths.iter().any(|f| !FOCAL.contains(f));
    told.then(|| {
        format!(
            "focal lengths of {} and {} px do not fit {}x{} pixels: in another unit, or of another image size?",
            k.fx, k.fy, image.width, image.height
        )
    })
}

/// Why an image's values are likely distances along the rays, which bend its planes.
///
/// On a plane 1/z is linear in the pixel; of a distance r = z √(1 + x² + y²) that is √(1 + x² + y²)/r. The
/// lower quartile of the second differences is that of planes.
fn distances(image: &DepthImage) -> Option<String> {
    let k = image.intrinsics;
    let (across, down) = ((REACH * k.fx) as usize, (REACH * k.fy) as usize);
    let inverse = |u: usize, v: usize| {
        let z = f64::from(image.z_m[v * image.width + u]);
        let (x, y) = ((u as f64 - k.cx) / k.fx, (v as f64 - k.cy) / k.fy);
        (z > 0.0).then(|| [1.0 / z, (1.0 + x * x + y * y).sqrt() / z])
    };
    let mut bends = [Vec::new(), Vec::new()];
    for v in (0..image.height).step_by(STEP) {
        for u in (0..image.width).step_by(STEP) {
            for (du, dv) in [(across, 0), (0, down)] {
                if u < du || v < dv || u + du >= image.width || v + dv >= image.height {
                    continue;
                }
                let three = (
                    inverse(u - du, v - dv),
                    inverse(u, v),
                    inverse(u + du, v + dv),
                );
                if let (Some(before), Some(here), Some(after)) = three {
                    for (i, bends) in bends.iter_mut().enumerate() {
                        bends.push(((before[i] + after[i]) / here[i] - 2.0).abs());
                    }
                }
            }
        }
    }
    if bends[0].len() < COUNT_MIN {
        return None;
    }
    let [as_depths, as_distances] = bends.map(|mut bends| {
        let quarter = bends.len() / 4;
        *bends.select_nth_unstable_by(quarter, f64::total_cmp).1
    });
    (as_distances < BENDS_LESS * as_depths).then(|| {
        format!(
            "its planes are bent, and {:.1} times less so if its values are distances along the rays: depths are \
             along the optical axis, z = r/√(1 + x² + y²)",
            as_depths / as_distances
        )
    })
}
