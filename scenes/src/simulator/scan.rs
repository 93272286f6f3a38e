//! One shot of the sensor.

use nalgebra::{Isometry3, Point3, Vector3};

use super::body::{Hit, World};
use super::camera::Pinhole;
use super::dropout;
use super::field::Field;
use super::noise::DepthNoise;
use super::rng::Stream;

/// A depth image and what it should have been.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// The camera.
    pub camera: Pinhole,
    /// Measured depth, mm, row by row; 0 where there is none.
    pub depth_mm: Vec<u16>,
    /// True depth along the pixel's own ray, m; NaN where the ray meets nothing.
    pub true_depth_m: Vec<f64>,
    /// Face of the world that the pixel's own ray meets.
    pub face: Vec<Option<usize>>,
}

impl Scan {
    /// The depth, mm, as a file: a 16-bit grey PNG.
    ///
    /// # Errors
    /// An image that is too large for the format.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut file = Vec::new();
        let (width, height) = (self.camera.width as u32, self.camera.height as u32);
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::High);
        let bytes: Vec<u8> = self.depth_mm.iter().flat_map(|v| v.to_be_bytes()).collect();
        encoder.write_header()?.write_image_data(&bytes)?;
        Ok(file)
    }
}

/// Random streams, one an error.
#[derive(Clone, Copy)]
enum Source {
    JitterU,
    JitterV,
    Depth,
    Distortion,
    Edge,
    Grazing,
    Speckle,
    Blob,
}

/// The image that a sensor at `X_WV` (optical frame V: x right, y down, z forward) takes of `world`.
///
///   z' = quantise( z·(1 + δ_LF) + σ(z)·n ),   z at a point displaced by the lateral jitter
///
/// Jitter that stays on the same face does not bias the depth: there the pixel's own ray counts.
/// Source: \[nguyen2012\] for σ(z) and the lateral noise.
#[allow(non_snake_case)]
pub fn scan(
    world: &World,
    camera: &Pinhole,
    X_WV: &Isometry3<f64>,
    noise: &DepthNoise,
    seed: u64,
) -> Scan {
    let distortion = distortion(camera, noise, seed);
    scan_distorted(world, camera, X_WV, noise, &distortion, seed)
}

/// The slowly varying error of a device, as a field of RMS 1 to be scaled by
/// [`DepthNoise::distortion`].
pub fn distortion(camera: &Pinhole, noise: &DepthNoise, seed: u64) -> Field {
    let stream = Stream::new(seed, Source::Distortion as u64);
    Field::smooth(camera.width, camera.height, noise.distortion_px, stream)
}

/// As [`scan`], by a device with this [`distortion`]: the same in all its images.
#[allow(non_snake_case)]
pub fn scan_distorted(
    world: &World,
    camera: &Pinhole,
    X_WV: &Isometry3<f64>,
    noise: &DepthNoise,
    distortion: &Field,
    seed: u64,
) -> Scan {
    let stream = |source: Source| Stream::new(seed, source as u64);
    let smooth =
        |sigma_px, source| Field::smooth(camera.width, camera.height, sigma_px, stream(source));

    // 1. What each pixel's ray meets, and what it sees instead because of the lateral jitter.
    let p_WV = Point3::from(X_WV.translation.vector);
    let (ju, jv) = (smooth(1.0, Source::JitterU), smooth(1.0, Source::JitterV));
    let ray_W = |i: usize, jitter: f64| -> Vector3<f64> {
        let u = (i % camera.width) as f64 + jitter * ju.values[i];
        let v = (i / camera.width) as f64 + jitter * jv.values[i];
        X_WV * camera.ray(u, v)
    };
    let cast = |ray: Vector3<f64>| world.cast(&p_WV, &ray);
    let pixels = 0..camera.pixels();
    let rays_W: Vec<Vector3<f64>> = (pixels.clone().map(|i| ray_W(i, noise.jitter_px))).collect();
    let nominal: Vec<Option<Hit>> = pixels.clone().map(|i| cast(ray_W(i, 0.0))).collect();
    let seen: Vec<Option<Hit>> = rays_W.iter().copied().map(cast).collect();

    // 2. Depth with distortion, correlated noise and quantised disparity.
    let n = smooth(noise.correlation_px, Source::Depth);
    let measured: Vec<Option<f64>> = (pixels.clone())
        .map(|i| {
            let hit = seen[i]?;
            let z = nominal[i]
                .filter(|own| own.face == hit.face)
                .map_or(hit.t, |own| own.t);
            let distorted = z * (1.0 + noise.distortion * distortion.values[i]);
            Some(noise.quantise(distorted + noise.sigma_m(z) * n.values[i], camera.fx))
        })
        .collect();

    // 3. Pixels without a value.
    let mut valid: Vec<bool> = seen.iter().map(Option::is_some).collect();
    let (p, edge) = (noise.edge_dropout, stream(Source::Edge));
    dropout::edges(&mut valid, &seen, camera, p, edge);
    dropout::shadow(&mut valid, &seen, &rays_W, world, X_WV, noise.baseline_m);
    let streams = [Source::Grazing, Source::Speckle, Source::Blob].map(stream);
    dropout::incidence_and_speckle(&mut valid, &seen, &rays_W, world, camera, noise, streams);

    // 4. Millimetres, within the sensor's range.
    let millimetres = |i: usize| {
        let z = measured[i].filter(|_| valid[i])?;
        let in_range = z > noise.range_min_m && z < noise.range_max_m;
        let mm = (z * 1000.0).round();
        (in_range && mm >= 1.0 && mm <= f64::from(u16::MAX)).then_some(mm as u16)
    };
    Scan {
        camera: *camera,
        depth_mm: pixels.map(|i| millimetres(i).unwrap_or(0)).collect(),
        true_depth_m: (nominal.iter().map(|hit| hit.map_or(f64::NAN, |hit| hit.t))).collect(),
        face: nominal.iter().map(|hit| hit.map(|hit| hit.face)).collect(),
    }
}
