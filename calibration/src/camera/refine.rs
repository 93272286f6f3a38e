//! Levenberg–Marquardt on the joint weighted problem.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Matrix6, Vector3, Vector6};

use super::residual::{Residual, step};
use super::{CameraConfig, PlanePair};
use crate::Error;

/// Least standard deviation of any residual, so that exactly known planes have a weight; rad, m.
const SIGMA_MIN: f64 = 1e-6;
/// A step below this, in rad and m, ends the refinement.
const STEP_MIN: f64 = 1e-10;
/// The last iteration's step may be as large.
const LAST_STEP_MAX: f64 = 1e-6;
/// Damping relative to the diagonal: at first, and where nothing can be gained any more.
const DAMPING: [f64; 2] = [1e-4, 1e10];

/// Most iterations; ten are enough where the poses determine the mount.
const ITERATIONS_MAX: usize = 50;
/// Huber's threshold on √(eᵀΣ⁻¹e) of a pose; poses beyond it count less. Of three Gaussian
/// components 3 % exceed it.
const HUBER: f64 = 3.0;

/// The refined mount.
pub(super) struct Refined {
    pub X_RV: Isometry3<f64>,
    /// (Σ w Jᵀ Σᵢ⁻¹ J)⁻¹ with the distortion left out of it, and what a common error of height adds.
    pub covariance: Matrix6<f64>,
    /// Σ w (e − C c)ᵀ Σᵢ⁻¹ (e − C c) + cᵀ c.
    pub chi2: f64,
    /// Huber's weight of every pair, in (0, 1].
    pub weights: Vec<f64>,
    pub iterations: usize,
    /// Cell, standard deviations of distortion and what is not known of them.
    pub distortion: Vec<(u32, f64, f64)>,
}

/// A mount and the distortion c of the device's cells, in standard deviations.
#[derive(Clone)]
struct Estimate {
    X_RV: Isometry3<f64>,
    distortion: DVector<f64>,
}

impl Estimate {
    fn step(&self, delta: &DVector<f64>) -> Self {
        let head = Vector6::from_iterator(delta.iter().take(6).copied());
        let tail = delta.rows(6, self.distortion.len());
        Self {
            X_RV: step(&self.X_RV, &head),
            distortion: &self.distortion + tail,
        }
    }
}

/// Normal equations at one estimate.
struct System {
    cost: f64,
    chi2: f64,
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Σ w Jᵀ Σᵢ⁻¹ (0, 0, 1): what an error of height of all poses pulls at.
    height: DVector<f64>,
    weights: Vec<f64>,
}

/// The problem: pairs, and the columns of their distortions among the unknowns.
struct Problem<'a> {
    pairs: &'a [PlanePair],
    cells: Vec<u32>,
}

/// Minimises Σ ρ(√((e − C c)ᵀ Σᵢ⁻¹ (e − C c))) + ½ cᵀ c over mount and distortion from `start`.
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
    let not_converged = || Error::NotConverged {
        iterations: ITERATIONS_MAX,
    };
    let common = pairs.iter().flat_map(|pair| &pair.common);
    let cells: BTreeSet<u32> = common.map(|common| common.cell).collect();
    let problem = Problem {
        pairs,
        cells: cells.into_iter().collect(),
    };
    let mut at = Estimate {
        X_RV: *start,
        distortion: DVector::zeros(problem.cells.len()),
    };
    let mut damping = DAMPING[0];
    for iteration in 0..ITERATIONS_MAX {
        // 1. Weights at this mount, held while it is compared with the next one.
        let weights = problem.whitenings(&at.X_RV);
        let here = problem.system(&weights, &at);
        // 2. A damped step that gains, or the end.
        let done = loop {
            let mut damped = here.information.clone();
            for k in 0..damped.nrows() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let factor = damped.cholesky().ok_or_else(not_converged)?;
            let delta = factor.solve(&here.gradient);
            let next = at.step(&delta);
            // Huber's weights settle slowly where many poses disagree.
            let last = iteration + 1 == ITERATIONS_MAX && delta.amax() < LAST_STEP_MAX;
            let small = delta.amax() < STEP_MIN || last;
            if small || problem.system(&weights, &next).cost <= here.cost {
                at = next;
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
            let end = problem.system(&problem.whitenings(&at.X_RV), &at);
            let covariance = end.information.try_inverse().ok_or_else(not_converged)?;
            let height = &covariance * end.height * config.common_height_sigma_m;
            let all = covariance + &height * height.transpose();
            return Ok(Refined {
                X_RV: at.X_RV,
                covariance: all.fixed_view::<6, 6>(0, 0).into_owned(),
                chi2: end.chi2,
                weights: end.weights,
                iterations: iteration + 1,
                distortion: (problem.cells.iter().enumerate())
                    .map(|(k, cell)| (*cell, at.distortion[k], all[(6 + k, 6 + k)].sqrt()))
                    .collect(),
            });
        }
    }
    Err(not_converged())
}

/// W with Wᵀ W = Σ⁻¹.
pub(super) fn whitening(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let floored = covariance + Matrix3::identity() * (SIGMA_MIN * SIGMA_MIN);
    // A positive semi-definite matrix plus a positive one; should rounding spoil it, its diagonal
    // is still right.
    let factor = floored.cholesky().map(|cholesky| cholesky.l());
    factor.and_then(|l| l.try_inverse()).unwrap_or_else(|| {
        Matrix3::from_diagonal(&floored.diagonal().map(|v| 1.0 / v.max(1e-12).sqrt()))
    })
}

impl Problem<'_> {
    /// W with Wᵀ W = Σᵢ⁻¹ for every pair.
    fn whitenings(&self, X_RV: &Isometry3<f64>) -> Vec<Matrix3<f64>> {
        let whitening = |pair| whitening(&Residual::of(pair, X_RV).covariance);
        self.pairs.iter().map(whitening).collect()
    }

    fn system(&self, whitenings: &[Matrix3<f64>], at: &Estimate) -> System {
        let n = 6 + self.cells.len();
        let prior = at.distortion.norm_squared();
        let mut system = System {
            cost: 0.5 * prior,
            chi2: prior,
            information: DMatrix::zeros(n, n),
            gradient: DVector::zeros(n),
            height: DVector::zeros(n),
            weights: Vec::with_capacity(self.pairs.len()),
        };
        for k in 6..n {
            system.information[(k, k)] = 1.0;
            system.gradient[k] = -at.distortion[k - 6];
        }
        let mut J = DMatrix::zeros(3, n);
        for (pair, W) in self.pairs.iter().zip(whitenings) {
            // 1. The residual, the distortion taken off, and its derivatives; white.
            let residual = Residual::of(pair, &at.X_RV);
            J.fill(0.0);
            J.columns_mut(0, 6).copy_from(&(W * residual.jacobian));
            let mut e = residual.value;
            for common in &pair.common {
                if let Ok(k) = self.cells.binary_search(&common.cell) {
                    e -= common.effect * at.distortion[k];
                    J.column_mut(6 + k).copy_from(&(W * common.effect));
                }
            }
            let e = W * e;
            // 2. Huber's weight, and the sums.
            let s = e.norm();
            let (weight, cost) = if s <= HUBER {
                (1.0, 0.5 * s * s)
            } else {
                (HUBER / s, HUBER * s - 0.5 * HUBER * HUBER)
            };
            system.cost += cost;
            system.chi2 += weight * s * s;
            system.information.gemm_tr(weight, &J, &J, 1.0);
            system.gradient.gemv_tr(weight, &J, &e, 1.0);
            system.height.gemv_tr(weight, &J, &(W * Vector3::z()), 1.0);
            system.weights.push(weight);
        }
        system
    }
}
