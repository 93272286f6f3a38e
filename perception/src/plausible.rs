//! Depth images that are likely read with the wrong model of their sensor, and clouds with the wrong place of theirs.

use nalgebra::Vector3;

use crate::{DepthImage, Scan};

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

/// Side of the directions in which points are compared, rad.
const DIRECTION_RAD: f64 = 0.01;
/// A point is hidden behind one this much nearer, as a part of its distance and m.
const BEHIND: [f64; 2] = [0.2, 0.2];
/// Where a sensor stood fewer of the points that share their direction are hidden from it: they lie at edges.
const HIDDEN_MAX: f64 = 0.25;

/// As many points tell, every so manyth of the cloud's.
const POINTS_MAX: usize = 300_000;

/// What is likely wrong, in words.
pub(crate) fn doubts(scan: &Scan, range_max_m: f64) -> Vec<String> {
    let Some(image) = &scan.depth else {
        return hidden(scan, range_max_m).into_iter().collect();
    };
    [off_centre(image), focal_length(image), distances(image)]
        .into_iter()
        .flatten()
        .collect()
}

/// Why a cloud was likely not seen from where its sensor is said to have stood: no sensor sees what is behind
/// something else. On the wrong side of a face its normal is the wrong one.
fn hidden(scan: &Scan, range_max_m: f64) -> Option<String> {
    let tau = std::f64::consts::TAU;
    let [cols, rows] = [tau, tau / 2.0].map(|angle| (angle / DIRECTION_RAD) as usize + 1);
    let step = scan.cloud.points.len() / POINTS_MAX + 1;
    let points = scan.cloud.finite().step_by(step);
    let from_eye = points.map(|p| Vector3::from(p.map(f64::from)) - scan.eye_V);
    let seen = from_eye.filter_map(|p| {
        let r = p.norm();
        let azimuth = p.y.atan2(p.x) + tau / 2.0;
        let polar = (p.z / r).clamp(-1.0, 1.0).acos();
        let [x, y] = [azimuth, polar].map(|angle| (angle / DIRECTION_RAD) as usize);
        (r > 0.0 && r <= range_max_m).then(|| (y.min(rows - 1) * cols + x.min(cols - 1), r as f32))
    });
    let seen: Vec<(usize, f32)> = seen.collect();
    let mut nearest = vec![(f32::INFINITY, 0_u32); cols * rows];
    for &(at, r) in &seen {
        let (least, count) = &mut nearest[at];
        (*least, *count) = (least.min(r), *count + 1);
    }
    let shared = seen.iter().filter(|(at, _)| nearest[*at].1 > 1);
    let (mut count, mut behind) = (0_usize, 0_usize);
    for &(at, r) in shared {
        count += 1;
        let far = BEHIND[0] as f32 * r + BEHIND[1] as f32;
        behind += usize::from(r - nearest[at].0 > far);
    }
    let part = behind as f64 / count.max(1) as f64;
    (count >= COUNT_MIN && part > HIDDEN_MAX).then(|| {
        let [x, y, z]: [f64; 3] = scan.eye_V.into();
        format!(
            "{:.0} % of its points lie behind others as seen from ({x}, {y}, {z}) in its frame: no sensor stood there, and \
             faces may be turned round; give the --eye, a place from which what is to be walked on is seen from above",
            100.0 * part
        )
    })
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
