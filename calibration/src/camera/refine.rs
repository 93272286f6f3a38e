//! Levenberg–Marquardt on the joint weighted problem.

use nalgebra::{Isometry3, Matrix3, Matrix6, Vector3, Vector6};

use super::residual::{Residual, step};
use super::{CameraConfig, PlanePair};
use crate::Error;

/// Least standard deviation of any residual, so that exactly known planes have a weight; rad, m.
const SIGMA_MIN: f64 = 1e-6;
/// A step below this, in rad and m, ends the refinement.
const STEP_MIN: f64 = 1e-10;
/// Damping relative to the diagonal: at first, and where nothing can be gained any more.
const DAMPING: [f64; 2] = [1e-4, 1e10];

/// The refined mount.
pub(super) struct Refined {
    pub X_RV: Isometry3<f64>,
    /// (Σ w Jᵀ Σᵢ⁻¹ J)⁻¹, with what a common error of height adds.
    pub covariance: Matrix6<f64>,
    /// Σ w eᵀ Σᵢ⁻¹ e.
    pub chi2: f64,
    /// Huber's weight of every pair, in (0, 1].
    pub weights: Vec<f64>,
    pub iterations: usize,
}

/// Normal equations at one mount.
struct System {
    cost: f64,
    chi2: f64,
    information: Matrix6<f64>,
    gradient: Vector6<f64>,
    /// Σ w Jᵀ Σᵢ⁻¹ e_d: what an error of height of all poses pulls at.
    height: Vector6<f64>,
    weights: Vec<f64>,
}

/// Minimises Σ ρ(√(eᵀ Σᵢ⁻¹ e)) from `start`.
///
/// Σᵢ depends on the mount through its lever only; it is taken at the last accepted mount. ρ is
/// Huber's: ½s² up to the threshold k, k s − ½k² beyond, the weight min(1, k/s).
///
/// # Errors
/// [`Error::NotConverged`].
/// Source: [nocedal2006] Section 10.3 for the damping.
pub(super) fn refine(
    pairs: &[PlanePair],
    start: &Isometry3<f64>,
    config: &CameraConfig,
) -> Result<Refined, Error> {
    let not_converged = Error::NotConverged {
        iterations: config.iterations_max,
    };
    let mut X_RV = *start;
    let mut damping = DAMPING[0];
    for iteration in 0..config.iterations_max {
        // 1. Weights at this mount, held while it is compared with the next one.
        let weights = whitenings(pairs, &X_RV);
        let here = system(pairs, &weights, &X_RV, config.huber);
        // 2. A damped step that gains, or the end.
        let done = loop {
            let mut damped = here.information;
            for k in 0..6 {
                damped[(k, k)] *= 1.0 + damping;
            }
            let Some(cholesky) = damped.cholesky() else {
                return Err(not_converged);
            };
            let delta = cholesky.solve(&here.gradient);
            let next = step(&X_RV, &delta);
            let small = delta.amax() < STEP_MIN;
            if small || system(pairs, &weights, &next, config.huber).cost <= here.cost {
                X_RV = next;
                damping = (damping * 0.1).max(1e-12);
                break small;
            }
            damping *= 10.0;
            if damping > DAMPING[1] {
                break true;
            }
        };
        // 3. The covariance where it ended.
        if done {
            let at = system(pairs, &whitenings(pairs, &X_RV), &X_RV, config.huber);
            let covariance = at.information.try_inverse().ok_or(not_converged)?;
            let common = covariance * at.height * config.common_height_sigma_m;
            return Ok(Refined {
                X_RV,
                covariance: covariance + common * common.transpose(),
                chi2: at.chi2,
                weights: at.weights,
                iterations: iteration + 1,
            });
        }
    }
    Err(not_converged)
}

/// W with Wᵀ W = Σᵢ⁻¹ for every pair.
fn whitenings(pairs: &[PlanePair], X_RV: &Isometry3<f64>) -> Vec<Matrix3<f64>> {
    pairs
        .iter()
        .map(|pair| whitening(&Residual::of(pair, X_RV).covariance))
        .collect()
}

/// W with Wᵀ W = Σ⁻¹.
pub(super) fn whitening(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let floored = covariance + Matrix3::identity() * (SIGMA_MIN * SIGMA_MIN);
    // A positive semi-definite matrix plus a positive one; should rounding spoil it, its diagonal
    // is still right.
    let diagonal =
        || Matrix3::from_diagonal(&floored.diagonal().map(|v| 1.0 / v.max(1e-12).sqrt()));
    floored
        .cholesky()
        .and_then(|cholesky| cholesky.l().try_inverse())
        .unwrap_or_else(diagonal)
}

fn system(
    pairs: &[PlanePair],
    whitenings: &[Matrix3<f64>],
    X_RV: &Isometry3<f64>,
    huber: f64,
) -> System {
    let mut system = System {
        cost: 0.0,
        chi2: 0.0,
        information: Matrix6::zeros(),
        gradient: Vector6::zeros(),
        height: Vector6::zeros(),
        weights: Vec::with_capacity(pairs.len()),
    };
    for (pair, W) in pairs.iter().zip(whitenings) {
        let residual = Residual::of(pair, X_RV);
        let e = W * residual.value;
        let J = W * residual.jacobian;
        let s = e.norm();
        let (weight, cost) = if s <= huber {
            (1.0, 0.5 * s * s)
        } else {
            (huber / s, huber * s - 0.5 * huber * huber)
        };
        system.cost += cost;
        system.chi2 += weight * s * s;
        system.information += J.transpose() * J * weight;
        system.gradient += J.transpose() * e * weight;
        system.height += J.transpose() * (W * Vector3::z()) * weight;
        system.weights.push(weight);
    }
    system
}
