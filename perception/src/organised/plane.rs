//! The final plane of one region: weighted fit, residuals, covariance.
#![allow(non_snake_case)]

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Point3, Rotation2, Vector2, Vector3};

use super::growth::{CellNoise, Region};
use super::image::{CELL_PX, Grid, InverseImage, holed};
use super::labels::NONE;
use super::moments::{InversePlane, Moments};
use crate::sensor::Noise;

/// A plane in the sensor's frame: n·p = d, n away from the sensor, d > 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    /// Unit normal in V, away from the sensor.
    pub normal: Vector3<f64>,
    /// Distance of the sensor from the plane, m.
    pub distance: f64,
    /// The same plane on the pixels.
    pub inverse: InversePlane,
    /// Pixels it was fitted to.
    pub inliers: usize,
    /// Root mean square of their distances from it, m.
    pub rms_m: f64,
}

impl Plane {
    /// The point of the plane on the ray of a pixel, in V; `None` if the ray does not meet it.
    pub fn point(&self, image: &InverseImage, u: f64, v: f64) -> Option<Point3<f64>> {
        let w = self.inverse.at(u - image.centre.0, v - image.centre.1);
        let k = &image.intrinsics;
        (w > 1e-6).then(|| Point3::new((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0) / w)
    }

    /// Area of the plane that the pixel sees, m²: z³ / (d fx fy).
    pub fn pixel_area(&self, image: &InverseImage, u: f64, v: f64) -> f64 {
        let w = self
            .inverse
            .at(u - image.centre.0, v - image.centre.1)
            .max(1e-6);
        1.0 / (w.powi(3) * self.distance * image.intrinsics.fx * image.intrinsics.fy)
    }
}

/// Labels that keep fewer pixels than this are not fitted to them.
const PIXELS_MIN: f64 = 16.0;

/// Weighted least squares over the pixels of every label.
///
///   min Σ (a u + b v + c − w)² / (A_σ σ_w² + A_κ (κ w)²)
///
/// A = 4π s² is the number of pixels over which an error of correlation length s repeats itself:
/// it says how much the pixel's white noise and how much the slowly varying error weigh.
/// A label that keeps too few pixels has the plane that its region was grown with; `None` where that
/// is none.
pub(super) fn fit(
    image: &InverseImage,
    grid: &Grid,
    labels: &[u16],
    regions: &[Region],
    noise: &Noise,
) -> Vec<Option<Plane>> {
    let count = regions.len();
    let (area_noise, area_systematic) = correlation_areas(noise);
    let mut weighted = vec![Moments::default(); count];
    // The same pixels, weighted to give squares of distances along the normal: d (ŵ − w) / w.
    let mut metric = vec![Moments::default(); count];
    let mut number = vec![0.0; count];
    for_cells(image, grid, labels, |label, chunk| {
        let w = chunk.mean();
        let noise = CellNoise::at(noise, w);
        let variance =
            area_noise * noise.sigma.powi(2) + area_systematic * noise.systematic.powi(2);
        weighted[label].add(chunk, 1.0 / variance);
        metric[label].add(chunk, 1.0 / (w * w));
        number[label] += chunk.n;
    });
    for (label, region) in regions.iter().enumerate() {
        if number[label] < PIXELS_MIN {
            let w = region.moments.mean();
            (weighted[label], metric[label]) = (region.moments, Moments::default());
            metric[label].add(&region.moments, 1.0 / (w * w));
            number[label] = region.moments.n;
        }
    }
    let k = image.intrinsics;
    weighted
        .iter()
        .zip(&metric)
        .zip(&number)
        .map(|((moments, metric), &number)| {
            let inliers = number as usize;
            let inverse = moments.plane()?;
            let [a, b, c] = [inverse.0.x, inverse.0.y, inverse.0.z];
            // n/d on the ray (x, y, 1): u = fx x + cx − centre.
            let at_axis = c + a * (k.cx - image.centre.0) + b * (k.cy - image.centre.1);
            let scaled = Vector3::new(a * k.fx, b * k.fy, at_axis);
            let distance = 1.0 / scaled.norm();
            let normal = scaled * distance;
            let square = metric.mean_square(&inverse) * metric.n * distance * distance;
            let finite = distance.is_finite() && normal.iter().all(|x| x.is_finite());
            finite.then_some(Plane {
                normal,
                distance,
                inverse,
                inliers,
                rms_m: (square / number).sqrt(),
            })
        })
        .collect()
}

/// Calls `with` for the moments of every set of pixels of one cell that have one label.
fn for_cells(
    image: &InverseImage,
    grid: &Grid,
    labels: &[u16],
    mut with: impl FnMut(usize, &Moments),
) {
    let band = image.width * CELL_PX;
    let bands = (labels.chunks_exact(band.max(1))).zip(image.w.chunks_exact(band.max(1)));
    let rows = grid.cells.chunks_exact(grid.cols.max(1));
    let mut there = Vec::new();
    for ((labels, w), (cells, v0)) in bands.zip(rows.zip((0..).step_by(CELL_PX))) {
        let line = |k: usize| labels[k * image.width..][..image.width].as_chunks().0;
        let lines = line(0).iter().zip(line(1)).zip(line(2)).zip(line(3));
        for ((i, whole), (((a, b), c), d)) in cells.iter().enumerate().zip(lines) {
            let lines: [&[u16; CELL_PX]; CELL_PX] = [a, b, c, d];
            let first = a[0];
            if lines.iter().all(|line| **line == [first; CELL_PX]) {
                if first != NONE && whole.n > 0.0 {
                    with(usize::from(first), whole);
                }
                continue;
            }
            // The pixels of each label that is there, on their own.
            there.clear();
            for &label in lines.into_iter().flatten() {
                if label != NONE && there.last() != Some(&label) && !there.contains(&label) {
                    there.push(label);
                }
            }
            let (x0, y0) = (
                (i * CELL_PX) as f64 - image.centre.0,
                f64::from(v0) - image.centre.1,
            );
            for &label in &there {
                let mut parts = [[0.0; CELL_PX]; CELL_PX];
                for (k, (part, line)) in parts.iter_mut().zip(lines).enumerate() {
                    let w: &[f32; CELL_PX] = &w[k * image.width..].as_chunks().0[i];
                    for j in 0..CELL_PX {
                        part[j] = if line[j] == label { w[j] } else { 0.0 };
                    }
                }
                let part = holed(parts, x0, y0);
                if part.n > 0.0 {
                    with(usize::from(label), &part);
                }
            }
        }
    }
}

/// 4π s² of the pixel noise and of the slowly varying error, px².
fn correlation_areas(noise: &Noise) -> (f64, f64) {
    let area = |s: f64| (4.0 * std::f64::consts::PI * s * s).max(1.0);
    (area(noise.correlation_px), area(noise.systematic_scale_px))
}

/// Sums over a face's pixels that its plane's covariance is made of, in coordinates of the plane.
pub(super) struct Spread {
    /// Σ g gᵀ/σ_n² and Σ g gᵀ with g = (y, −x, 1).
    white: Matrix3<f64>,
    slow: Matrix3<f64>,
    /// Pixels a metre: how the pixel changes along x and y of the plane, in the mean.
    px_per_m: Matrix2<f64>,
    /// κ d: the systematic error along the normal, m.
    systematic_m: f64,
}

impl Spread {
    /// `support` are pixels of the face and how many each stands for; `at` is where the plane's
    /// coordinates have the point of a pixel, and its depth.
    pub fn new(
        support: &[(f64, f64, f64)],
        plane: &Plane,
        at: impl Fn(f64, f64) -> Option<(Point2<f64>, f64)>,
        noise: &Noise,
    ) -> Self {
        let mut white = Matrix3::zeros();
        let mut slow = Matrix3::zeros();
        // Moments of (x, y, 1) and of these with the pixel, for the regression of the latter.
        let mut places = Matrix3::zeros();
        let mut pixels = Matrix2x3::zeros();
        for &(u, v, n) in support {
            let Some((q, z)) = at(u, v) else { continue };
            let sigma = plane.distance * noise.sigma_inverse(z) * z;
            let g = Vector3::new(q.y, -q.x, 1.0);
            let square = g * g.transpose() * n;
            white += square / (sigma * sigma);
            slow += square;
            let p = Vector3::new(q.x, q.y, 1.0);
            places += p * p.transpose() * n;
            pixels += Vector2::new(u, v) * p.transpose() * n;
        }
        let slope = |inverse: Matrix3<f64>| (pixels * inverse).fixed_columns::<2>(0).into_owned();
        Self {
            white,
            slow,
            px_per_m: places.try_inverse().map_or(Matrix2::zeros(), slope),
            systematic_m: noise.systematic_ratio * plane.distance,
        }
    }

    /// Covariance of (rotation about x_S, rotation about y_S, offset along z_S) of the plane:
    /// rad, rad, m. S lies on the plane, its origin at `origin`, its x axis turned by `turn`.
    ///
    ///   Σ = A_σ (Σ g gᵀ/σ_n²)⁻¹ + κ² d² A_κ (Σ g gᵀ)⁻¹,  g = (y_S, −x_S, 1),  σ_n = d σ_w / w
    ///
    /// An error of depth κz moves the plane's point by κd along its normal. The second term is
    /// bounded for faces smaller than the error's waves: the offset by κ d, the tilts by the slope
    /// of such a wave, κ d/(√2 s). `None` when the pixels do not determine the plane.
    pub fn covariance(
        &self,
        origin: &Point2<f64>,
        turn: &Rotation2<f64>,
        noise: &Noise,
    ) -> Option<[[f64; 3]; 3]> {
        let (area_noise, area_systematic) = correlation_areas(noise);
        // g of S from that of the plane: q_S = R (q − o).
        let (c, s) = (turn.matrix()[(0, 0)], turn.matrix()[(1, 0)]);
        let x = Vector3::new(-s, -c, -(c * origin.x - s * origin.y));
        let y = Vector3::new(c, -s, -(s * origin.x + c * origin.y));
        let to_S = Matrix3::from_rows(&[y.transpose(), -x.transpose(), Vector3::z().transpose()]);
        let white = to_S * self.white * to_S.transpose();
        let slow = to_S * self.slow * to_S.transpose();
        let kd = self.systematic_m;
        let mut systematic = slow.cholesky()?.inverse() * (kd * kd * area_systematic);
        // Bounds, as a scaling of rows and columns that keeps the matrix positive.
        let wave = kd / (std::f64::consts::SQRT_2 * noise.systematic_scale_px);
        let px_per_m = self.px_per_m * turn.matrix().transpose();
        let along = |axis: usize| wave * px_per_m.column(axis).norm();
        let limits = [along(1), along(0), kd];
        for (i, limit) in limits.into_iter().enumerate() {
            let sigma = systematic[(i, i)].max(0.0).sqrt();
            if sigma > limit && sigma > 0.0 {
                let scale = limit / sigma;
                systematic.row_mut(i).scale_mut(scale);
                systematic.column_mut(i).scale_mut(scale);
            }
        }
        let sigma = white.cholesky()?.inverse() * area_noise + systematic;
        let symmetric = (sigma + sigma.transpose()) * 0.5;
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| symmetric[(i, j)]));
        rows.iter().flatten().all(|x| x.is_finite()).then_some(rows)
    }
}
