//! Pixels without a value: beside depth edges, in the projector's shadow, at grazing incidence.

use nalgebra::{Isometry3, Point3, Vector3};

use super::body::{Hit, World};
use super::camera::Pinhole;
use super::field::Field;
use super::noise::DepthNoise;
use super::rng::Stream;

/// Jump between neighbouring pixels that makes a depth edge, fraction of the nearer depth.
const EDGE_JUMP: f64 = 0.03;
/// Width of the band beside a depth edge where pixels drop out, pixels.
const EDGE_BAND_PX: usize = 2;
/// A point is in shadow if the projector's ray to it ends earlier than this fraction of its way.
const SHADOW_FRACTION: f64 = 0.985;

/// Removes the pixels beside depth edges with the configured probability.
pub fn edges(valid: &mut [bool], hits: &[Option<Hit>], camera: &Pinhole, p: f64, stream: Stream) {
    let (w, h) = (camera.width, camera.height);
    let depth = |i: usize| hits[i].map_or(f64::INFINITY, |hit| hit.t);
    let is_jump = |i: usize, j: usize| {
        let (a, b) = (depth(i), depth(j));
        a.is_finite() != b.is_finite() || (a.is_finite() && (a - b).abs() > EDGE_JUMP * a.min(b))
    };
    let mut near = vec![false; w * h];
    for y in 0..h {
        for x in 0..w {
            let i = y * w + x;
            if x + 1 < w && is_jump(i, i + 1) {
                near[i] = true;
                near[i + 1] = true;
            }
            if y + 1 < h && is_jump(i, i + w) {
                near[i] = true;
                near[i + w] = true;
            }
        }
    }
    for _ in 0..EDGE_BAND_PX {
        near = dilate(&near, w, h);
    }
    for (i, valid) in valid.iter_mut().enumerate() {
        *valid &= !(near[i] && stream.uniform(i as u64) < p);
    }
}

/// The set grown by the pixel's four neighbours.
fn dilate(set: &[bool], w: usize, h: usize) -> Vec<bool> {
    let at = |x: usize, y: usize| set[y * w + x];
    let grown = |i: usize| {
        let (x, y) = (i % w, i / w);
        at(x, y)
            || (x > 0 && at(x - 1, y))
            || (x + 1 < w && at(x + 1, y))
            || (y > 0 && at(x, y - 1))
            || (y + 1 < h && at(x, y + 1))
    };
    (0..w * h).map(grown).collect()
}

/// Removes the points that the projector, beside the camera, does not light.
pub fn shadow(
    valid: &mut [bool],
    hits: &[Option<Hit>],
    rays_W: &[Vector3<f64>],
    world: &World,
    X_WV: &Isometry3<f64>,
    baseline_m: f64,
) {
    if baseline_m == 0.0 {
        return;
    }
    let p_WV = Point3::from(X_WV.translation.vector);
    let p_WP = X_WV * Point3::new(baseline_m, 0.0, 0.0);
    for (i, valid) in valid.iter_mut().enumerate() {
        let Some(hit) = hits[i].filter(|_| *valid) else {
            continue;
        };
        let point = p_WV + rays_W[i] * hit.t;
        let first = world.cast(&p_WP, &(point - p_WP));
        *valid = first.is_none_or(|first| first.t >= SHADOW_FRACTION);
    }
}

/// Removes points at grazing incidence, single pixels and blobs.
pub fn incidence_and_speckle(
    valid: &mut [bool],
    hits: &[Option<Hit>],
    rays_W: &[Vector3<f64>],
    world: &World,
    camera: &Pinhole,
    noise: &DepthNoise,
    [grazing, speckle, blob]: [Stream; 3],
) {
    let normals: Vec<Vector3<f64>> = world.faces().map(|face| face.normal_W).collect();
    let blobs = Field::smooth(camera.width, camera.height, 3.0, blob);
    for (i, valid) in valid.iter_mut().enumerate() {
        let Some(hit) = hits[i] else { continue };
        let cosine = normals[hit.face].dot(&rays_W[i]).abs() / rays_W[i].norm();
        let index = i as u64;
        let lost = cosine < noise.blind_cosine
            || (cosine < noise.grazing_cosine && grazing.uniform(index) < noise.grazing_dropout)
            || speckle.uniform(index) < noise.speckle_dropout
            || blobs.values[i] > noise.blob_level;
        *valid &= !lost;
    }
}
