//! Rays and inverse depths, from an image or a cloud.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use nalgebra::Vector3;
use perception::{DepthImage, Noise, PointCloud, Scan};

use super::GroundConfig;
use super::config::{RANGE_MAX_M, RANGE_MIN_M};

/// Pixels of an image that are nearer to each other than this part of the noise's correlation area
/// repeat each other, and every second (third, …) will do.
const STRIDE_AREA: f64 = 9.0;
/// Angle of a pixel where a cloud does not say: that of a depth camera of 640 columns, rad.
const PIXEL_RAD: f64 = 1.0 / 550.0;
/// Cells of one side of the cube on which a cloud's directions are counted.
const CUBE_CELLS: f64 = 48.0;

/// Points of a scan as rays with inverse depth, within range.
#[derive(Debug, Clone, Default)]
pub(super) struct Samples {
    /// r, in V: (x, y, 1) of a pixel, a unit vector of a point.
    pub rays: Vec<[f32; 3]>,
    /// w: inverse depth along z of a pixel, inverse range of a point, 1/m.
    pub inverse: Vec<f32>,
    /// 1/σ of w as a single sample, slowly varying error included, m.
    pub sharpness: Vec<f32>,
    /// ω: weight in the fit, correlation counted, m².
    pub weight: Vec<f32>,
    /// Share of 1/ω that is drawn anew in each frame.
    pub anew: Vec<f32>,
    /// Cell of the device's distortion.
    pub cells: Vec<u32>,
    /// Standard deviation of that distortion: of w as a ratio of w, the same in all frames.
    pub pattern_ratio: f64,
}

/// How samples are weighed.
struct Weighing<'a> {
    noise: &'a Noise,
    /// Samples over which the pixel's noise and the slowly varying error repeat themselves.
    areas: [f64; 2],
    /// Share of the latter's variance that all frames have in common.
    shared: f64,
}

impl Samples {
    /// The samples of a scan: of its image where it has one, else of its cloud.
    pub fn of(scan: &Scan, config: &GroundConfig) -> Self {
        let mut noise = scan.noise;
        noise.systematic_ratio = config.distortion_ratio.unwrap_or(noise.systematic_ratio);
        match &scan.depth {
            Some(image) => Self::of_image(image, &noise, config),
            None => Self::of_cloud(&scan.cloud, &scan.eye_V, &noise, config),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    fn of_image(image: &DepthImage, noise: &Noise, config: &GroundConfig) -> Self {
        let [area_noise, area_slow] =
            [noise.correlation_px, noise.systematic_scale_px].map(|s| 4.0 * PI * s * s);
        let stride = ((area_noise / STRIDE_AREA).sqrt().floor() as usize).max(1);
        let per_sample = (stride * stride) as f64;
        let weighing = Weighing {
            noise,
            areas: [area_noise, area_slow].map(|area| (area / per_sample).max(1.0)),
            shared: config.distortion_shared,
        };
        let k = &image.intrinsics;
        let mut samples = Self::patterned(noise, config);
        // Cells of the area over which the slow error repeats itself.
        let edge = area_slow.sqrt().max(1.0);
        let columns = (image.width as f64 / edge) as u32 + 1;
        let room = image.z_m.len() / (stride * stride) + 1;
        samples.reserve(room);
        let rows = image.z_m.chunks_exact(image.width.max(1)).enumerate();
        for (v, row) in rows.step_by(stride) {
            let y = (v as f64 - k.cy) / k.fy;
            let row_of_cells = (v as f64 / edge) as u32 * columns;
            for (u, z) in row.iter().enumerate().step_by(stride) {
                let z = f64::from(*z);
                let x = (u as f64 - k.cx) / k.fx;
                // The range along the ray, so that image and cloud keep the same points.
                let square = z * z * (x * x + y * y + 1.0);
                if (RANGE_MIN_M * RANGE_MIN_M..=RANGE_MAX_M * RANGE_MAX_M).contains(&square) {
                    let cell = row_of_cells + (u as f64 / edge) as u32;
                    samples.push([x, y, 1.0], z, cell, &weighing);
                }
            }
        }
        samples
    }

    fn of_cloud(
        cloud: &PointCloud,
        eye_V: &Vector3<f64>,
        noise: &Noise,
        config: &GroundConfig,
    ) -> Self {
        let ranged = |p: &[f32; 3]| {
            let p = Vector3::from(p.map(f64::from)) - eye_V;
            (p, p.norm())
        };
        let within = |(_, range): &(Vector3<f64>, f64)| (RANGE_MIN_M..=RANGE_MAX_M).contains(range);
        let seen: Vec<_> = cloud.finite().map(ranged).filter(within).collect();
        // Samples within one correlated patch: density × 4π s², s as an angle.
        let density = seen.len() as f64 / solid_angle(seen.iter().map(|(p, _)| p)).max(1e-9);
        let angles = [noise.correlation_px, noise.systematic_scale_px]
            .map(|s| (4.0 * PI).sqrt() * s * PIXEL_RAD);
        let weighing = Weighing {
            noise,
            areas: angles.map(|angle| (density * angle * angle).max(1.0)),
            shared: config.distortion_shared,
        };
        let mut samples = Self::patterned(noise, config);
        samples.reserve(seen.len());
        let cells = (2.0 / angles[1].max(1e-2)).round().clamp(1.0, 200.0);
        for (p, range) in &seen {
            let [side, i, j] = cube_cell(p, cells);
            let cell = (side * cells as u32 + i) * cells as u32 + j;
            samples.push((p / *range).into(), *range, cell, &weighing);
        }
        samples
    }

    fn patterned(noise: &Noise, config: &GroundConfig) -> Self {
        Self {
            pattern_ratio: noise.systematic_ratio * config.distortion_shared.sqrt(),
            ..Self::default()
        }
    }

    fn reserve(&mut self, room: usize) {
        self.rays.reserve(room);
        self.inverse.reserve(room);
        self.sharpness.reserve(room);
        self.weight.reserve(room);
        self.anew.reserve(room);
        self.cells.reserve(room);
    }

    /// Adds the point at `depth_m` along `ray`.
    fn push(&mut self, ray: [f64; 3], depth_m: f64, cell: u32, weighing: &Weighing) {
        let inverse = 1.0 / depth_m;
        let sigma = weighing.noise.sigma_inverse(depth_m);
        let slow = weighing.noise.systematic_ratio * inverse;
        let (white, slow) = (sigma * sigma, slow * slow);
        self.rays.push(ray.map(|x| x as f32));
        self.inverse.push(inverse as f32);
        self.sharpness.push((1.0 / (white + slow).sqrt()) as f32);
        let [area_noise, area_slow] = weighing.areas;
        let (white, slow) = (area_noise * white, area_slow * slow);
        self.weight.push((1.0 / (white + slow)) as f32);
        let anew = (white + (1.0 - weighing.shared) * slow) / (white + slow);
        self.anew.push(anew as f32);
        self.cells.push(cell);
    }
}

/// Side of the cube that a direction meets (0–5), and the cell there of `cells` a row and column.
fn cube_cell(direction: &Vector3<f64>, cells: f64) -> [u32; 3] {
    let axis = direction.iamax();
    let depth = direction[axis];
    let cell = |other: usize| {
        let at = (direction[other % 3] / depth + 1.0) * 0.5 * cells;
        at.clamp(0.0, cells - 1.0) as u32
    };
    let side = 2 * axis as u32 + u32::from(depth > 0.0);
    [side, cell(axis + 1), cell(axis + 2)]
}

/// Solid angle that the directions cover, sr: cells of a cube's sides with a direction in them.
fn solid_angle<'a>(directions: impl Iterator<Item = &'a Vector3<f64>>) -> f64 {
    let cells: BTreeSet<[u32; 3]> = directions.map(|d| cube_cell(d, CUBE_CELLS)).collect();
    // A cell of edge 2/n at (a, b) of the side covers (2/n)² / (1 + a² + b²)^1.5.
    let edge = 2.0 / CUBE_CELLS;
    let angle = |[_, i, j]: &[u32; 3]| {
        let [a, b] = [i, j].map(|k| (f64::from(*k) + 0.5) * edge - 1.0);
        edge * edge / (1.0 + a * a + b * b).powf(1.5)
    };
    cells.iter().map(angle).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_all_around_cover_the_sphere() {
        let n = 200_000;
        // A spiral with equal areas.
        let directions = (0..n).map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
            let (s, c) = (2.399_963 * f64::from(i)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * c, r * s, z)
        });
        let directions: Vec<Vector3<f64>> = directions.collect();
        let all = solid_angle(directions.iter());
        assert!((all / (4.0 * PI) - 1.0).abs() < 1e-3, "{all}");
        let half = solid_angle(directions.iter().filter(|d| d.z > 0.0));
        assert!((half / (2.0 * PI) - 1.0).abs() < 0.05, "{half}");
    }
}
