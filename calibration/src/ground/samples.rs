//! Rays and inverse depths, from an image or a cloud.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use nalgebra::Vector3;
use perception::{DepthImage, Noise, PointCloud, Scan};

use super::GroundConfig;

/// Pixels of an image that are nearer to each other than this part of the noise's correlation area
/// repeat each other, and every second (third, …) will do.
const STRIDE_AREA: f64 = 9.0;
/// Angle of a pixel where a cloud does not say: that of a depth camera of 640 columns, rad.
const PIXEL_RAD: f64 = 1.0 / 550.0;
/// Cells of one side of the cube on which a cloud's directions are counted.
const CUBE_CELLS: f64 = 48.0;

/// Points of a scan as rays with inverse depth, within range.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// r, in V: (x, y, 1) of a pixel, a unit vector of a point.
    pub rays: Vec<[f32; 3]>,
    /// w: inverse depth along z of a pixel, inverse range of a point, 1/m.
    pub inverse: Vec<f32>,
    /// 1/σ of w as a single sample, slowly varying error included, m.
    pub sharpness: Vec<f32>,
    /// ω: weight in the fit, correlation counted, m².
    pub weight: Vec<f32>,
}

impl Samples {
    /// The samples of a scan: of its image where it has one, else of its cloud.
    pub fn of(scan: &Scan, config: &GroundConfig) -> Self {
        match &scan.depth {
            Some(image) => Self::of_image(image, &scan.noise, config),
            None => Self::of_cloud(&scan.cloud, &scan.eye_V, &scan.noise, config),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// The point of sample i, in V, m.
    pub fn point(&self, i: usize) -> Vector3<f64> {
        Vector3::from(self.rays[i].map(f64::from)) / f64::from(self.inverse[i])
    }

    fn of_image(image: &DepthImage, noise: &Noise, config: &GroundConfig) -> Self {
        let [area_noise, area_slow] =
            [noise.correlation_px, noise.systematic_scale_px].map(|s| 4.0 * PI * s * s);
        let stride = ((area_noise / STRIDE_AREA).sqrt().floor() as usize).max(1);
        let per_sample = (stride * stride) as f64;
        let areas = [area_noise, area_slow].map(|area| (area / per_sample).max(1.0));
        let k = &image.intrinsics;
        let mut samples = Self::default();
        let room = image.z_m.len() / (stride * stride) + 1;
        samples.reserve(room);
        let near = config.range_min_m.max(1e-3);
        for (v, row) in image
            .z_m
            .chunks_exact(image.width.max(1))
            .enumerate()
            .step_by(stride)
        {
            let y = (v as f64 - k.cy) / k.fy;
            for (u, z) in row.iter().enumerate().step_by(stride) {
                let z = f64::from(*z);
                let x = (u as f64 - k.cx) / k.fx;
                // The range along the ray, so that image and cloud keep the same points.
                let square = z * z * (x * x + y * y + 1.0);
                if square >= near * near && square <= config.range_max_m * config.range_max_m {
                    samples.push([x, y, 1.0], 1.0 / z, noise.sigma_inverse(z), noise, areas);
                }
            }
        }
        samples
    }

    #[allow(non_snake_case)]
    fn of_cloud(
        cloud: &PointCloud,
        eye_V: &Vector3<f64>,
        noise: &Noise,
        config: &GroundConfig,
    ) -> Self {
        let near = config.range_min_m.max(1e-3);
        let seen: Vec<(Vector3<f64>, f64)> = cloud
            .finite()
            .map(|p| Vector3::from(p.map(f64::from)) - eye_V)
            .map(|p| (p, p.norm()))
            .filter(|(_, range)| (near..=config.range_max_m).contains(range))
            .collect();
        // Samples within one correlated patch: density × 4π s², s as an angle.
        let density = seen.len() as f64 / solid_angle(seen.iter().map(|(p, _)| p)).max(1e-9);
        let areas = [noise.correlation_px, noise.systematic_scale_px].map(|s| {
            let angle = s * PIXEL_RAD;
            (density * 4.0 * PI * angle * angle).max(1.0)
        });
        let mut samples = Self::default();
        samples.reserve(seen.len());
        for (p, range) in &seen {
            let ray = p / *range;
            samples.push(
                ray.into(),
                1.0 / range,
                noise.sigma_inverse(*range),
                noise,
                areas,
            );
        }
        samples
    }

    fn reserve(&mut self, room: usize) {
        self.rays.reserve(room);
        self.inverse.reserve(room);
        self.sharpness.reserve(room);
        self.weight.reserve(room);
    }

    fn push(
        &mut self,
        ray: [f64; 3],
        inverse: f64,
        sigma: f64,
        noise: &Noise,
        [area_noise, area_slow]: [f64; 2],
    ) {
        let slow = noise.systematic_ratio * inverse;
        let (white, slow) = (sigma * sigma, slow * slow);
        self.rays.push(ray.map(|x| x as f32));
        self.inverse.push(inverse as f32);
        self.sharpness.push((1.0 / (white + slow).sqrt()) as f32);
        self.weight
            .push((1.0 / (area_noise * white + area_slow * slow)) as f32);
    }
}

/// Solid angle that the directions cover, sr: cells of a cube's sides with a direction in them.
fn solid_angle<'a>(directions: impl Iterator<Item = &'a Vector3<f64>>) -> f64 {
    let mut cells = BTreeSet::new();
    for direction in directions {
        let side = direction.iamax();
        let depth = direction[side];
        let cell = |axis: usize| ((direction[axis] / depth + 1.0) * 0.5 * CUBE_CELLS) as i32;
        cells.insert((
            side,
            depth > 0.0,
            cell((side + 1) % 3),
            cell((side + 2) % 3),
        ));
    }
    // A cell of edge 2/n at (a, b) of the side covers (2/n)² / (1 + a² + b²)^1.5.
    let edge = 2.0 / CUBE_CELLS;
    cells
        .iter()
        .map(|(_, _, i, j)| {
            let centre = |k: &i32| (f64::from(*k) + 0.5) * edge - 1.0;
            let (a, b) = (centre(i), centre(j));
            edge * edge / (1.0 + a * a + b * b).powf(1.5)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_all_around_cover_the_sphere() {
        let n = 200_000;
        // A spiral with equal areas.
        let directions: Vec<Vector3<f64>> = (0..n)
            .map(|i| {
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
                let (s, c) = (2.399_963 * f64::from(i)).sin_cos();
                let r = (1.0 - z * z).sqrt();
                Vector3::new(r * c, r * s, z)
            })
            .collect();
        let all = solid_angle(directions.iter());
        assert!((all / (4.0 * PI) - 1.0).abs() < 1e-3, "{all}");
        let half = solid_angle(directions.iter().filter(|d| d.z > 0.0));
        assert!((half / (2.0 * PI) - 1.0).abs() < 0.05, "{half}");
    }
}
