//! Planes and the rings' constant range errors, fitted together.
//!
//! A beam along u that is measured too long by b_ring lies at p; the plane k of its point has
//!
//!   e = n_k·(p − b_ring u) + d_k,   Var e = (n·u)² σ_r² + (1 − (n·u)²)(r σ_a)²
//!
//! which is n·u times the error of its range, so that Σ e²/Var e is the likelihood of the ranges,
//! and b_ring ~ N(b⁰, s²). A ring is curved on a plane and flat at most in its own, so that its bias
//! and the plane's tilt tell themselves apart.

use nalgebra::{DMatrix, DVector, Vector3};

use super::plane::{Plane, RING_BIAS_SIGMA_M, variance};

/// What is known of the errors of ranges beforehand.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BiasPrior {
    /// Variance of single ranges, over what the sensor's model says.
    pub noise: f64,
    /// Mean of every ring's bias, m.
    pub mean_m: Vec<f64>,
    /// Its standard deviation, m.
    pub sigma_m: Vec<f64>,
}

impl BiasPrior {
    /// Nothing but the size of uncalibrated errors.
    pub fn unknown(rings: usize) -> Self {
        Self {
            noise: 1.0,
            mean_m: vec![0.0; rings],
            sigma_m: vec![RING_BIAS_SIGMA_M; rings],
        }
    }
}

/// A point that belongs to a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observation {
    /// Index of the plane.
    pub plane: usize,
    /// Its ring, if it has one.
    pub ring: Option<usize>,
    /// The measured point, m.
    pub p: Vector3<f64>,
}

/// Planes, biases, and the covariance of both.
#[derive(Debug, Clone)]
pub(super) struct JointFit {
    /// The planes.
    pub planes: Vec<Plane>,
    /// A point of every plane about which its rotations are meant: the mean of its observations.
    pub centres: Vec<Vector3<f64>>,
    /// Tangents of every plane, about which its rotations are counted.
    pub tangents: Vec<[Vector3<f64>; 2]>,
    /// Bias of every ring, m.
    pub bias_m: Vec<f64>,
    /// Covariance of (tilt along t₁, tilt along t₂, distance) of every plane in turn, then of the
    /// biases: n' = n + θ₁ t₁ + θ₂ t₂, and the plane at the centre moved by δ against the normal.
    pub covariance: DMatrix<f64>,
    /// Root mean square of every plane's residuals, m.
    pub rms_m: Vec<f64>,
    /// How much larger the residuals' variance is than the noise that was given.
    pub excess: f64,
}

/// A beam that would meet its plane farther away runs along it, m.
const RANGE_MAX_M: f64 = 1e3;
/// Gauss–Newton steps; the problem is nearly linear.
const STEPS: usize = 3;

/// The planes nearest to their observations, with the rings' biases; `None` when the normal equations
/// cannot be solved (a plane with points on one line).
///
/// The covariance is that of independent noise, enlarged where the residuals are larger than it says.
pub(super) fn joint_fit(
    observations: &[Observation],
    start: &[Plane],
    prior: &BiasPrior,
) -> Option<JointFit> {
    let (planes_count, rings) = (start.len(), prior.mean_m.len());
    let size = 3 * planes_count + rings;
    let mut planes = start.to_vec();
    let mut bias = prior.mean_m.clone();

    let mut centres = vec![Vector3::zeros(); planes_count];
    let mut counts = vec![0_usize; planes_count];
    for o in observations {
        centres[o.plane] += o.p;
        counts[o.plane] += 1;
    }
    for (centre, count) in centres.iter_mut().zip(&counts) {
        if *count < 3 {
            return None;
        }
        *centre /= *count as f64;
    }

    let mut normal_matrix = DMatrix::<f64>::zeros(size, size);
    let mut tangents: Vec<[Vector3<f64>; 2]> = Vec::new();
    let mut chi_squared = 0.0;
    for step in 0..=STEPS {
        tangents = planes.iter().map(Plane::tangents).collect();
        normal_matrix.fill(0.0);
        let mut right = DVector::<f64>::zeros(size);
        chi_squared = 0.0;
        for o in observations {
            let plane = &planes[o.plane];
            let u = o.p / o.p.norm();
            let n_u = plane.normal.dot(&u);
            let b = o.ring.map_or(0.0, |ring| bias[ring]);
            let e = plane.distance(&o.p) - b * n_u;
            // Where the beam meets the plane: derivatives at the measured point would go along with
            // its error and tilt the plane.
            let range = -plane.offset_m / n_u;
            if !(range > 0.0 && range < RANGE_MAX_M) {
                continue;
            }
            let weight = 1.0 / (prior.noise * variance(n_u, range));
            let from_centre = u * range - centres[o.plane];
            let [t1, t2] = &tangents[o.plane];
            let row = [t1.dot(&from_centre), t2.dot(&from_centre), 1.0];
            chi_squared += weight * e * e;
            let first = 3 * o.plane;
            for i in 0..3 {
                let w = weight * row[i];
                for j in i..3 {
                    normal_matrix[(first + j, first + i)] += w * row[j];
                }
                right[first + i] -= w * e;
            }
            if let Some(ring) = o.ring {
                let at = 3 * planes_count + ring;
                for (i, value) in row.iter().enumerate() {
                    normal_matrix[(at, first + i)] -= weight * n_u * value;
                }
                normal_matrix[(at, at)] += weight * n_u * n_u;
                right[at] += weight * n_u * e;
            }
        }
        for (ring, bias) in bias.iter().enumerate() {
            let at = 3 * planes_count + ring;
            let information = 1.0 / prior.sigma_m[ring].powi(2);
            normal_matrix[(at, at)] += information;
            right[at] += information * (prior.mean_m[ring] - bias);
        }
        if step == STEPS {
            break;
        }
        let update = normal_matrix.clone().cholesky()?.solve(&right);
        for (k, plane) in planes.iter_mut().enumerate() {
            let [t1, t2] = tangents[k];
            let normal = (plane.normal + t1 * update[3 * k] + t2 * update[3 * k + 1]).normalize();
            // The distance at the centre moves by the third part.
            let at_centre = plane.distance(&centres[k]) + update[3 * k + 2];
            let offset_m = at_centre - normal.dot(&centres[k]);
            *plane = Plane { normal, offset_m };
        }
        for ring in 0..rings {
            bias[ring] += update[3 * planes_count + ring];
        }
        if planes.iter().any(|p| !p.offset_m.is_finite()) {
            return None;
        }
    }

    // What the noise model leaves unexplained enlarges the covariance.
    let degrees = (observations.len() as f64 - 3.0 * planes_count as f64).max(1.0);
    let excess = (chi_squared / degrees).max(1.0);
    let covariance = normal_matrix.cholesky()?.inverse() * excess;
    let mut squares = vec![0.0; planes_count];
    for o in observations {
        let plane = &planes[o.plane];
        let n_u = plane.normal.dot(&o.p) / o.p.norm();
        let b = o.ring.map_or(0.0, |ring| bias[ring]);
        squares[o.plane] += (plane.distance(&o.p) - b * n_u).powi(2);
    }
    let rms_m = squares
        .iter()
        .zip(&counts)
        .map(|(s, n)| (s / *n as f64).sqrt())
        .collect();
    Some(JointFit {
        planes,
        centres,
        tangents,
        bias_m: bias,
        covariance,
        rms_m,
        excess,
    })
}
