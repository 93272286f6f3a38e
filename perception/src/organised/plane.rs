//! The final plane of one region: weighted fit, residuals, covariance.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::growth::CellNoise;
use super::image::InverseImage;
use super::labels::NONE;
use super::moments::{InversePlane, Moments};
use crate::sensor::Noise;

/// Pixels along a row that share one weight and stand for one point in the covariance.
const CHUNK_PX: usize = 16;

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

/// Weighted least squares over the pixels of every label.
///
///   min Σ (a u + b v + c − w)² / (A_σ σ_w² + A_κ (κ w)²)
///
/// A = 4π s² is the number of pixels over which an error of correlation length s repeats itself:
/// it says how much the pixel's white noise and how much the slowly varying error weigh.
/// `None` for labels that keep too few pixels.
pub(super) fn fit(
    image: &InverseImage,
    labels: &[u16],
    count: usize,
    noise: &Noise,
) -> Vec<Option<Plane>> {
    let (area_noise, area_systematic) = correlation_areas(noise);
    let mut weighted = vec![Moments::default(); count];
    let mut number = vec![0_usize; count];
    for_chunks(image, labels, |label, chunk| {
        let noise = CellNoise::at(noise, chunk.mean());
        let variance =
            area_noise * noise.sigma.powi(2) + area_systematic * noise.systematic.powi(2);
        weighted[label].add(chunk, 1.0 / variance);
        number[label] += chunk.n as usize;
    });
    let k = image.intrinsics;
    let mut planes: Vec<Option<Plane>> = weighted
        .iter()
        .zip(&number)
        .map(|(moments, &inliers)| {
            let inverse = moments.plane().filter(|_| inliers >= 16)?;
            let [a, b, c] = [inverse.0.x, inverse.0.y, inverse.0.z];
            // n/d on the ray (x, y, 1): u = fx x + cx − centre.
            let at_axis = c + a * (k.cx - image.centre.0) + b * (k.cy - image.centre.1);
            let scaled = Vector3::new(a * k.fx, b * k.fy, at_axis);
            let distance = 1.0 / scaled.norm();
            let normal = scaled * distance;
            let finite = distance.is_finite() && normal.iter().all(|x| x.is_finite());
            finite.then_some(Plane {
                normal,
                distance,
                inverse,
                inliers,
                rms_m: 0.0,
            })
        })
        .collect();

    // Residuals along the normal: d (ŵ − w) / w.
    let mut squares = vec![0.0; count];
    for_chunks(image, labels, |label, chunk| {
        if let Some(plane) = &planes[label] {
            let scale = plane.distance / chunk.mean();
            squares[label] += chunk.n * chunk.mean_square(&plane.inverse) * scale * scale;
        }
    });
    for ((plane, square), n) in planes.iter_mut().zip(squares).zip(number) {
        if let Some(plane) = plane {
            plane.rms_m = (square / n as f64).sqrt();
        }
    }
    planes
}

/// Calls `with` for the moments of every chunk of a row that has one label.
fn for_chunks(image: &InverseImage, labels: &[u16], mut with: impl FnMut(usize, &Moments)) {
    let width = image.width;
    for (v, line) in labels.chunks_exact(width.max(1)).enumerate() {
        let y = v as f64 - image.centre.1;
        let mut u = 0;
        while u < width {
            let label = line[u];
            let start = u;
            let mut chunk = Moments::default();
            while u < width && line[u] == label && u - start < CHUNK_PX {
                let w = f64::from(image.at(u, v));
                if w > 0.0 && label != NONE {
                    chunk.push(u as f64 - image.centre.0, y, w);
                }
                u += 1;
            }
            if chunk.n > 0.0 {
                with(usize::from(label), &chunk);
            }
        }
    }
}

/// 4π s² of the pixel noise and of the slowly varying error, px².
fn correlation_areas(noise: &Noise) -> (f64, f64) {
    let area = |s: f64| (4.0 * std::f64::consts::PI * s * s).max(1.0);
    (area(noise.correlation_px), area(noise.systematic_scale_px))
}

/// Covariance of (rotation about x_S, rotation about y_S, offset along z_S) of the plane, in a
/// frame S on it: rad, rad, m.
///
///   Σ = A_σ (Σ g gᵀ/σ_n²)⁻¹ + κ² d² A_κ (Σ g gᵀ)⁻¹,  g = (y_S, −x_S, 1),  σ_n = d σ_w / w
///
/// An error of depth κz moves the plane's point by κd along its normal. The second term is
/// bounded for faces smaller than the error's waves: the offset by κ d, the tilts by the slope
/// of such a wave, κ d/(√2 s).
/// `support` are pixels of the face and how many each stands for. `None` when they do not
/// determine the plane.
pub(super) fn covariance(
    image: &InverseImage,
    support: &[(f64, f64, f64)],
    plane: &Plane,
    origin: &Point3<f64>,
    frame: &Rotation3<f64>,
    noise: &Noise,
) -> Option<[[f64; 3]; 3]> {
    let (area_noise, area_systematic) = correlation_areas(noise);
    let mut white = Matrix3::zeros();
    let mut slow = Matrix3::zeros();
    let mut pixel = Moments::default();
    let (mut sx, mut sy, mut sxx, mut syy) = (0.0, 0.0, 0.0, 0.0);
    for &(u, v, n) in support {
        let Some(p) = plane.point(image, u, v) else {
            continue;
        };
        let q = frame.inverse() * (p - origin);
        let g = Vector3::new(q.y, -q.x, 1.0);
        let sigma = plane.distance * noise.sigma_inverse(p.z) * p.z;
        white += g * g.transpose() * (n / (sigma * sigma));
        slow += g * g.transpose() * n;
        let mut one = Moments::default();
        one.push(u - image.centre.0, v - image.centre.1, 0.0);
        pixel.add(&one, n);
        sx += n * q.x;
        sy += n * q.y;
        sxx += n * q.x * q.x;
        syy += n * q.y * q.y;
    }
    let kd = noise.systematic_ratio * plane.distance;
    let mut systematic = slow.cholesky()?.inverse() * (kd * kd * area_systematic);
    // Bounds, as a scaling of rows and columns that keeps the matrix positive.
    let n = pixel.n;
    let spread_px = (pixel.uu - pixel.u * pixel.u / n + pixel.vv - pixel.v * pixel.v / n).max(0.0);
    let wave = kd / (std::f64::consts::SQRT_2 * noise.systematic_scale_px);
    let per_m = |square: f64| (spread_px / square.max(1e-12)).sqrt();
    let limits = [
        wave * per_m(syy - sy * sy / n),
        wave * per_m(sxx - sx * sx / n),
        kd,
    ];
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
