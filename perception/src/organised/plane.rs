//! The final plane of one region: weighted fit, residuals, covariance.
#![allow(non_snake_case)]

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Rotation2, RowVector3, Vector3};

use super::bits::Bits;
use super::cell::CellNoise;
use super::chart::Chart;
use super::face::Face;
use super::image::{Grid, InverseImage};
use super::label_boundaries::LabelBoundaries;
use super::moments::Region;
use super::moments::{InversePlane, Moments};
use super::parts;
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

/// Weighted least squares over the sure pixels of every label.
///
///   min Σ (a u + b v + c − w)² / (A_σ σ_w² + A_κ (κ w)²)
///
/// A = 4π s² is the number of pixels over which an error of correlation length s repeats itself:
/// it says how much the pixel's white noise and how much the slowly varying error weigh.
/// Pixels are weighed alike with those of their label around them, in windows that the noise hardly
/// changes in. A label that keeps too few pixels has the plane that its region was grown with; `None`
/// where that is none.
pub(super) fn fit(
    image: &InverseImage,
    (small, large): (&Grid, &Grid),
    labels: &[u16],
    sure: &Bits,
    cuts: &LabelBoundaries,
    regions: &[Region],
    noise: &Noise,
) -> Vec<Option<Plane>> {
    let count = regions.len();
    let (area_noise, area_systematic) = correlation_areas(noise);
    let mut weighted = vec![Moments::default(); count];
    // The same pixels, weighted to give squares of distances along the normal: d (ŵ − w) / w.
    let mut metric = vec![Moments::default(); count];
    let mut number = vec![0.0; count];
    let add = |label: u16, chunk: &Moments| {
        // Gaps that were closed may be all there is.
        if chunk.n <= 0.0 {
            return;
        }
        let label = usize::from(label);
        let w = chunk.mean();
        let noise = CellNoise::at(noise, w);
        let variance =
            area_noise * noise.sigma.powi(2) + area_systematic * noise.systematic.powi(2);
        // 1/σ² and 1/w² by one division.
        let inverse = 1.0 / (variance * w * w);
        weighted[label].add(chunk, inverse * w * w);
        metric[label].add(chunk, inverse * variance);
        number[label] += chunk.n;
    };
    parts::for_parts(image, (small, large), labels, sure, cuts, add);
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

/// 4π s² of the pixel noise and of the slowly varying error, px².
fn correlation_areas(noise: &Noise) -> (f64, f64) {
    let area = |s: f64| (4.0 * std::f64::consts::PI * s * s).max(1.0);
    (area(noise.correlation_px), area(noise.systematic_scale_px))
}

/// A lattice of a face's pixels, about this many, is enough for its covariance.
const SUPPORT: f64 = 200.0;

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
    /// Of a face of so many pixels, over a lattice of them.
    pub fn new(face: &Face, pixels: f64, plane: &Plane, chart: &Chart, noise: &Noise) -> Self {
        let step = ((pixels / SUPPORT).sqrt().ceil() as usize).max(1);
        // Sums of 1, x, y, x², x y, y², the same over σ_n², and of u and v with 1, x, y.
        let mut sums = [0.0; 6];
        let mut white = [0.0; 6];
        let mut pixel = [[0.0; 3]; 2];
        let rows = face.runs.iter();
        for &(v, a, b) in rows.filter(|(v, ..)| (*v as usize).is_multiple_of(step)) {
            for u in (a.next_multiple_of(step as u32)..b).step_by(step) {
                let (u, v) = (f64::from(u), f64::from(v));
                let Some((q, w)) = chart.at(u, v) else {
                    continue;
                };
                // σ_n = d σ_w / w.
                let sigma = noise.sigma_at_inverse(w);
                let weight = w * w / (sigma * sigma);
                let products = [1.0, q.x, q.y, q.x * q.x, q.x * q.y, q.y * q.y];
                for k in 0..6 {
                    sums[k] += products[k];
                    white[k] += products[k] * weight;
                }
                for k in 0..3 {
                    pixel[0][k] += products[k] * u;
                    pixel[1][k] += products[k] * v;
                }
            }
        }
        // Each stands for as many pixels as there are to one of the lattice.
        let each = (step * step) as f64;
        // Of (y, −x, 1).
        let outer = |[n, x, y, xx, xy, yy]: [f64; 6], each: f64| {
            Matrix3::new(yy, -xy, y, -xy, xx, -x, y, -x, n) * each
        };
        let [n, x, y, xx, xy, yy] = sums;
        let places = Matrix3::new(xx, xy, x, xy, yy, y, x, y, n);
        let pixels = pixel.map(|[n, x, y]| RowVector3::new(x, y, n));
        let pixels = Matrix2x3::from_rows(&pixels);
        let slope = |inverse: Matrix3<f64>| (pixels * inverse).fixed_columns::<2>(0).into_owned();
        Self {
            white: outer(white, each / (plane.distance * plane.distance)),
            slow: outer(sums, each),
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
