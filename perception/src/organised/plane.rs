//! The final plane of one region: weighted fit, residuals.

use nalgebra::Vector3;

use super::bits::Bits;
use super::cell::CellNoise;
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
        let noise = CellNoise::at(noise, w, 0.0);
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
    let lens = image.lens();
    weighted
        .iter()
        .zip(&metric)
        .zip(&number)
        .map(|((moments, metric), &number)| {
            let inliers = number as usize;
            let inverse = moments.plane()?;
            let scaled = lens.normal(&inverse);
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
pub(super) fn correlation_areas(noise: &Noise) -> (f64, f64) {
    let area = |s: f64| (4.0 * std::f64::consts::PI * s * s).max(1.0);
    (area(noise.correlation_px), area(noise.systematic_scale_px))
}
