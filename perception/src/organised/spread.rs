//! The covariance of a plane, from where its pixels lie.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Rotation2, RowVector3, Vector3};

use super::chart::Chart;
use super::face::Face;
use super::plane::{Plane, correlation_areas};
use crate::plane_covariance;
use crate::sensor::Noise;

/// A lattice of a plane's pixels, about this many, is enough for its covariance.
const SUPPORT: f64 = 200.0;

/// Sums over a plane's pixels that its covariance is made of, in coordinates of the plane.
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
    /// Of all faces of a plane, over a lattice of their pixels.
    pub fn new(faces: &[&Face], plane: &Plane, chart: &Chart, noise: &Noise) -> Self {
        let runs = || faces.iter().flat_map(|face| &face.runs);
        let pixels: f64 = runs().map(|(_, a, b)| f64::from(b - a)).sum();
        let step = ((pixels / SUPPORT).sqrt().ceil() as usize).max(1);
        // Sums of 1, x, y, x², x y, y², the same over σ_n², and of u and v with 1, x, y.
        let mut sums = [0.0; 6];
        let mut white = [0.0; 6];
        let mut pixel = [[0.0; 3]; 2];
        for &(v, a, b) in runs().filter(|(v, ..)| (*v as usize).is_multiple_of(step)) {
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
    ///   σ_n² = A_σ (d σ_w / w)²,  s² = A_κ κ² d²,  tilts of the slow error up to κ d/(√2 s)
    ///
    /// An error of depth κz moves the plane's point by κd along its normal, and a wave of it, s pixels long, tilts it.
    /// `None` when the pixels do not determine the plane.
    pub fn covariance(
        &self,
        origin: &Point2<f64>,
        turn: &Rotation2<f64>,
        noise: &Noise,
    ) -> Option<[[f64; 3]; 3]> {
        let (area_noise, area_systematic) = correlation_areas(noise);
        // The middle of the pixels, and g of S there from that of the plane: q_S = R (q − o).
        let middle = Point2::new(-self.slow[(1, 2)], self.slow[(0, 2)]) / self.slow[(2, 2)];
        let (c, s) = (turn.matrix()[(0, 0)], turn.matrix()[(1, 0)]);
        let x = Vector3::new(-s, -c, -(c * middle.x - s * middle.y));
        let y = Vector3::new(c, -s, -(s * middle.x + c * middle.y));
        let to_S = Matrix3::from_rows(&[y.transpose(), -x.transpose(), Vector3::z().transpose()]);
        let of_S = |sums: &Matrix3<f64>| to_S * sums * to_S.transpose();
        let kd = self.systematic_m;
        let wave = kd / (std::f64::consts::SQRT_2 * noise.systematic_scale_px);
        let px_per_m = self.px_per_m * turn.matrix().transpose();
        let along = |axis: usize| wave * px_per_m.column(axis).norm();
        plane_covariance::covariance(
            &(of_S(&self.white) / area_noise),
            &(of_S(&self.slow) / (kd * kd * area_systematic)),
            [along(1), along(0), kd],
            &(turn * (origin - middle)),
        )
    }
}
