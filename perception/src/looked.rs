//! What a camera or a bare cloud looked through, and what of it lies on no face.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3, Vector3};
use surfaces::free_space::{FreeSpace, HELD, RayEnd};

use crate::Scan;

/// Of so many points one counts.
const STEP: usize = 4;
/// Width of the bins of direction in which points are counted, as a ratio of the distance.
const BIN: f64 = 0.1;
/// Points that are counted there.
const BINNED: usize = 1500;

/// What of a view is asked for.
pub(crate) struct Asked {
    /// What it looked through.
    pub through: bool,
    /// What it shows beside the faces.
    pub beside: bool,
}

/// What a scan looked through by its points in range; `on_face` says of which a face is known to hold them.
pub(crate) fn looked(
    scan: &Scan,
    X_WV: &Isometry3<f64>,
    range_max_m: f64,
    on_face: &[bool],
    asked: Asked,
) -> FreeSpace {
    let turn = X_WV.rotation.to_rotation_matrix();
    if !asked.through && !asked.beside {
        return FreeSpace::default();
    }
    let mut found = FreeSpace {
        eye_W: X_WV * Point3::from(scan.eye_V),
        ..FreeSpace::default()
    };
    let count = scan.cloud.points.len();
    let width = scan
        .depth
        .as_ref()
        .map_or(count, |image| image.width)
        .max(1);
    for (number, first) in (0..count).step_by(width).enumerate() {
        let columns = (count - first).min(width);
        for u in (0..columns).step_by(STEP) {
            let i = first + u;
            let is_held = on_face.get(i) == Some(&true);
            let beside = asked.beside && !is_held;
            // Of each row of an image others than of the next.
            let held = asked.beside && is_held && (i / STEP + number).is_multiple_of(HELD);
            if !(asked.through || beside || held) {
                continue;
            }
            // An image is a third of its points to fetch.
            let p_V = match &scan.depth {
                Some(image) => image.point(u, number),
                None => Point3::from(scan.cloud.points[i].map(f64::from)),
            };
            let range = (p_V.coords - scan.eye_V).norm();
            // Not where a coordinate is not a number.
            if range > range_max_m || range.is_nan() {
                continue;
            }
            let p_W = turn * p_V + X_WV.translation.vector;
            if held {
                found.held.push(p_W);
            }
            if asked.through || beside {
                let sigma = scan.noise.sigma_z_m(range);
                let systematic = scan.noise.systematic_ratio * range;
                let sigma_m = (sigma * sigma + systematic * systematic).sqrt();
                let end = RayEnd { p_W, sigma_m };
                if asked.through {
                    found.points.push(end);
                }
                if beside {
                    found.beside.push(end);
                }
            }
        }
    }
    if asked.beside {
        found.density = density(scan) / STEP as f64;
    }
    found
}

/// Points on a square that faces the sensor, of a side as long as it is far away: by the median of the bins of
/// direction with any.
fn density(scan: &Scan) -> f64 {
    let step = scan.cloud.points.len().div_ceil(BINNED).max(1);
    let mut bins: BTreeMap<[i32; 3], usize> = BTreeMap::new();
    let measured = |p: &&[f32; 3]| p.iter().all(|c| c.is_finite());
    let sample: Vec<[f32; 3]> = scan.cloud.points.iter().step_by(step).copied().collect();
    for p in sample.iter().filter(measured) {
        let way = Vector3::from(p.map(f64::from)) - scan.eye_V;
        let axis = way.iamax();
        let scale = 1.0 / (BIN * way[axis].abs().max(f64::MIN_POSITIVE));
        let [u, v] = [1, 2].map(|k| (way[(axis + k) % 3] * scale).floor() as i32);
        let side = axis as i32 * 2 + i32::from(way[axis] > 0.0);
        *bins.entry([side, u, v]).or_default() += 1;
    }
    let mut counts: Vec<usize> = bins.into_values().collect();
    let middle = counts.len() / 2;
    match counts.is_empty() {
        true => 0.0,
        false => (step * *counts.select_nth_unstable(middle).1) as f64 / (BIN * BIN),
    }
}
