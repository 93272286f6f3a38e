//! The paper's trimming: distances in metres from the plane of total least squares.

use nalgebra::{Matrix3, Unit, Vector3};

use super::config::ITERATIONS_MAX;
use super::pattern::CellEffect;
use super::{Ground, GroundConfig, GroundForm, Samples, no_ground, pattern, symmetric};
use crate::plane::tangents;
use crate::{Error, GroundPlane};

/// The plane of total least squares of the points that were never trimmed.
///
/// Each round fits the points that are left (the eigenvector of the smallest eigenvalue of their
/// scatter, turned so that d > 0), and removes those of which the distance is beyond
/// `trim_sigmas` of its standard deviation. With signed distances this comes to rest; with absolute
/// ones, as printed, it goes on until `inliers_min` is reached, and says so.
///
/// Source: [chai2015] Eqs. 8–16 and Fig. 8; deviation: n·x̄ + d = 0, where the paper's signs differ
/// between its Eqs. 5 and 8.
pub(super) fn trim(samples: &Samples, config: &GroundConfig) -> Result<Ground, Error> {
    let mut left: Vec<usize> = (0..samples.len()).collect();
    let mut found = fit(samples, &left).ok_or_else(|| no_ground(0, samples, config))?;
    let mut iterations = 0;
    let mut converged = false;
    while iterations < ITERATIONS_MAX && left.len() >= config.inliers_min {
        iterations += 1;
        let value = |i: usize| {
            let d = found.normal.dot(&samples.point(i)) + found.distance_m;
            match config.form {
                GroundForm::Absolute => d.abs(),
                _ => d,
            }
        };
        let n = left.len() as f64;
        let mean = left.iter().map(|i| value(*i)).sum::<f64>() / n;
        let square: f64 = left.iter().map(|i| (value(*i) - mean).powi(2)).sum();
        let bound = config.trim_sigmas * (square / (n - 1.0)).sqrt();
        let near = left.iter().copied().filter(|i| value(*i).abs() <= bound);
        let next: Vec<usize> = near.collect();
        if next.len() == left.len() {
            converged = true;
            break;
        }
        if next.len() < config.inliers_min {
            break;
        }
        left = next;
        found = fit(samples, &left).ok_or_else(|| no_ground(left.len(), samples, config))?;
    }
    if left.len() < config.inliers_min {
        return Err(no_ground(left.len(), samples, config));
    }
    let off = |i: &usize| found.normal.dot(&samples.point(*i)) + found.distance_m;
    let square: f64 = left.iter().map(|i| off(i).powi(2)).sum();
    let (anew, common) = covariance(samples, &left, &found);
    Ok(Ground {
        plane: GroundPlane {
            covariance: symmetric(&anew),
            ..found
        },
        common,
        samples: samples.len(),
        inliers: left.len(),
        residual: (square / left.len() as f64).sqrt(),
        iterations,
        converged,
    })
}

/// The plane of total least squares, d > 0.
fn fit(samples: &Samples, left: &[usize]) -> Option<GroundPlane> {
    let found = perception::lidar::Plane::fitted(left.iter().map(|i| samples.point(*i)))?;
    let normal = Unit::new_normalize(found.normal);
    Some(GroundPlane::exact(normal, found.offset_m))
}

/// Covariance of the unweighted fit under the stated noise that is drawn anew in each frame,
/// correlation counted, and what the device's distortion does.
///
///   H⁻¹ (Σ g gᵀ v) H⁻¹,   H = Σ g gᵀ,   g = (e₁·p, e₂·p, 1)
///
/// v is the variance of a point's distance times the samples that share its error: a point on ray r
/// moves by d/w along the normal for an error of w, so v = (d/w)²/ω.
fn covariance(
    samples: &Samples,
    left: &[usize],
    plane: &GroundPlane,
) -> (Matrix3<f64>, Vec<CellEffect>) {
    let e = tangents(&plane.normal);
    let row = |i: usize| {
        let p = samples.point(i);
        Vector3::new(e.column(0).dot(&p), e.column(1).dot(&p), 1.0)
    };
    let lever = |i: usize| plane.distance_m / f64::from(samples.inverse[i]);
    let mut H = Matrix3::zeros();
    let mut noise = Matrix3::zeros();
    for &i in left {
        let g = row(i);
        let anew = f64::from(samples.anew[i]) / f64::from(samples.weight[i]);
        H += g * g.transpose();
        noise += g * g.transpose() * (lever(i) * lever(i) * anew);
    }
    let inverse = H.try_inverse().unwrap_or_else(Matrix3::zeros);
    // A point that is measured δw too near is (d/w) δw off the plane, which turns after it.
    let pull = |i: usize| -row(i) * lever(i);
    let common = pattern::effects(samples, left.iter().copied(), pull, &inverse);
    (inverse * noise * inverse, common)
}
