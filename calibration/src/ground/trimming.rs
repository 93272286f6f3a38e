//! Trimming on signed distances in units of their noise.

use nalgebra::{Matrix3, Vector3};

use super::{Ground, GroundConfig, Samples, consensus, no_ground, pattern, plane_of, symmetric};
use crate::Error;

/// Most iterations; about ten are taken.
const ITERATIONS_MAX: usize = 50;
/// Standard deviations beyond which a sample is trimmed: trimming Gaussians at 3σ costs 4 % of variance,
/// at \[chai2015\]'s 2σ (which settles at 1.44σ) 126 %.
const TRIM_SIGMAS: f64 = 3.0;

/// Sums over the samples that are kept.
#[derive(Default)]
struct Sums {
    n: usize,
    /// Σ ω r rᵀ: xx, xy, xz, yy, yz, zz.
    rr: [f64; 6],
    /// Σ ω r w.
    rw: [f64; 3],
    /// Σ a ω r rᵀ, a the share that is drawn anew in each frame.
    anew: [f64; 6],
    /// Σ s and Σ s² of the residuals of the plane that chose the samples.
    s: f64,
    ss: f64,
}

impl Sums {
    /// Mean and standard deviation of the residuals.
    fn spread(&self) -> (f64, f64) {
        let n = self.n.max(1) as f64;
        let mean = self.s / n;
        (mean, (self.ss / n - mean * mean).max(0.0).sqrt())
    }
}

/// The weighted plane of the samples that lie within [`TRIM_SIGMAS`] of it.
///
/// Each round fits the kept samples, measures mean and spread of their residuals and keeps, of *all*
/// samples, those within the bound: what an early plane threw away comes back. It ends where a
/// round keeps as many as the one before and the plane stays.
pub(super) fn trim(samples: &Samples, config: &GroundConfig) -> Result<Ground, Error> {
    let start = consensus::plane(samples, config.draws, config.seed);
    let mut m = start.ok_or_else(|| no_ground(0, samples, config))?;
    let mut bounds = [-TRIM_SIGMAS, TRIM_SIGMAS];
    let mut kept = 0;
    for iteration in 1..=ITERATIONS_MAX {
        let chosen = sums(samples, &m, bounds);
        if chosen.n < config.inliers_min {
            return Err(no_ground(chosen.n, samples, config));
        }
        let information = matrix(&chosen.rr);
        let cholesky = information
            .cholesky()
            .ok_or_else(|| no_ground(chosen.n, samples, config))?;
        let next = cholesky.solve(&Vector3::from(chosen.rw));
        let (mean, sigma) = chosen.spread();
        let (by, [low, high]) = (m, bounds);
        bounds = [-1.0, 1.0].map(|side| mean + side * TRIM_SIGMAS * sigma);
        let still = chosen.n == kept && (next - m).norm() <= 1e-9 * m.norm();
        kept = chosen.n;
        m = next;
        if still || iteration == ITERATIONS_MAX {
            let (mut plane, to_plane) =
                plane_of(&m).ok_or_else(|| no_ground(kept, samples, config))?;
            // Cov m = H⁻¹ in two parts: H⁻¹ (Σ a ω r rᵀ) H⁻¹, and what the device's pattern does.
            let inverse = to_plane * cholesky.inverse();
            let anew = matrix(&chosen.anew);
            let is_fitted = |i: &usize| (low..=high).contains(&residual(samples, &by, *i));
            let pull = |i: usize| {
                Vector3::from(samples.rays[i].map(f64::from)) * f64::from(samples.weight[i])
            };
            let fitted = (0..samples.len()).filter(is_fitted);
            let common = pattern::effects(samples, fitted, pull, &inverse);
            // Rougher ground than the noise explains is known less well.
            let rougher = sigma.max(1.0).powi(2);
            plane.covariance = symmetric(&(inverse * anew * inverse.transpose())) * rougher;
            return Ok(Ground {
                plane,
                common,
                samples: samples.len(),
                inliers: kept,
                residual: sigma,
                iterations: iteration,
                converged: still,
            });
        }
    }
    Err(no_ground(kept, samples, config))
}

/// s of sample i.
fn residual(samples: &Samples, m: &Vector3<f64>, i: usize) -> f64 {
    let ray = Vector3::from(samples.rays[i].map(f64::from));
    (m.dot(&ray) - f64::from(samples.inverse[i])) * f64::from(samples.sharpness[i])
}

/// The symmetric matrix of xx, xy, xz, yy, yz, zz.
fn matrix([xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> Matrix3<f64> {
    Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
}

/// The sums over the samples with residuals s = (m·r − w)/σ within the bounds.
fn sums(samples: &Samples, m: &Vector3<f64>, [low, high]: [f64; 2]) -> Sums {
    let mut sums = Sums::default();
    let m = [m.x as f32, m.y as f32, m.z as f32];
    let (low, high) = (low as f32, high as f32);
    for ((((ray, w), sharpness), weight), anew) in samples
        .rays
        .iter()
        .zip(&samples.inverse)
        .zip(&samples.sharpness)
        .zip(&samples.weight)
        .zip(&samples.anew)
    {
        let s = (m[0] * ray[0] + m[1] * ray[1] + m[2] * ray[2] - w) * sharpness;
        if s < low || s > high {
            continue;
        }
        let [x, y, z] = ray.map(f64::from);
        let weight = f64::from(*weight);
        let (wx, wy, wz) = (weight * x, weight * y, weight * z);
        let w = f64::from(*w);
        sums.n += 1;
        let products = [wx * x, wx * y, wx * z, wy * y, wy * z, wz * z];
        let anew = f64::from(*anew);
        for (k, product) in products.iter().enumerate() {
            sums.rr[k] += product;
            sums.anew[k] += anew * product;
        }
        sums.rw[0] += wx * w;
        sums.rw[1] += wy * w;
        sums.rw[2] += wz * w;
        let s = f64::from(s);
        sums.s += s;
        sums.ss += s * s;
    }
    sums
}
