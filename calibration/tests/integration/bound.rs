//! How well the mount can be known at all from the 52 poses of [chai2015] Table A1.
//!
//! Poses whose tilt is off by 0.17° about each level axis and whose height is off by 1 mm, each pose
//! for itself, bound the variance of every unbiased estimator by the inverse of the Fisher
//! information (Cramér–Rao),
//!
//!   cov ≥ (Σᵢ Jᵢᵀ (S + Aᵢ P Aᵢᵀ)⁻¹ Jᵢ)⁻¹,
//!
//! J the measured plane's derivative by the mount, A by the pose's error, P and S the covariances of
//! pose and sensor. The derivatives are difference quotients of the measurement itself here, and
//! share nothing with those of the estimator.

use crate::support::degrees_and_mm;
use calibration::GroundPlane;
use calibration::camera::{CameraConfig, PaperParameters, PlanePair, identify};
use nalgebra::{Isometry3, Matrix3, Matrix3x6, Matrix6, SMatrix, UnitQuaternion, Vector3, Vector6};
use scenes::camera_set::published_extrinsics;
use scenes::stances::{TABLE_A1, X_GR};

/// α, β, γ in rad, p in m → the mount.
fn mount(parameters: &Vector6<f64>) -> Isometry3<f64> {
    let [a, b, c, x, y, z] = (*parameters).into();
    PaperParameters {
        angles_rad: [a, b, c],
        position_m: [x, y, z],
    }
    .X_RV()
}

/// The ground in the sensor's frame, normal and distance, of a pose with an error (rad, rad, m).
fn measured(stance: [f64; 3], X_RV: &Isometry3<f64>, error: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(error.x, error.y, 0.0));
    let mut X_GR = X_GR(stance);
    X_GR.rotation = tilt * X_GR.rotation;
    X_GR.translation.z += error.z;
    let X_GV = X_GR * X_RV;
    (X_GV.rotation.inverse() * Vector3::z(), X_GV.translation.z)
}

/// The difference quotient of `f` at `x`.
fn quotient<const N: usize>(
    f: impl Fn(&SMatrix<f64, N, 1>) -> Vector3<f64>,
    x: &SMatrix<f64, N, 1>,
) -> SMatrix<f64, 3, N> {
    const H: f64 = 1e-6;
    let mut J = SMatrix::<f64, 3, N>::zeros();
    for k in 0..N {
        let mut step = SMatrix::<f64, N, 1>::zeros();
        step[k] = H;
        J.set_column(k, &((f(&(x + step)) - f(&(x - step))) / (2.0 * H)));
    }
    J
}

/// The bound on the standard deviations: degrees and mm, in the paper's parameters.
fn bound(tilt_rad: f64, height_m: f64, sensor: &Matrix3<f64>) -> [f64; 6] {
    let truth = PaperParameters::of_mount(&published_extrinsics());
    let [[a, b, c], [x, y, z]] = [truth.angles_rad, truth.position_m];
    let at = Vector6::new(a, b, c, x, y, z);
    let P = Matrix3::from_diagonal(&Vector3::new(tilt_rad, tilt_rad, height_m).map(|s| s * s));
    let mut information = Matrix6::zeros();
    for stance in TABLE_A1 {
        let (n, _) = measured(stance, &mount(&at), &Vector3::zeros());
        // Two tangents of the measured normal, and the distance.
        let first = n.cross(&Vector3::x()).normalize();
        let second = n.cross(&first);
        let rows = |(n, d): (Vector3<f64>, f64)| Vector3::new(first.dot(&n), second.dot(&n), d);
        let none = Vector3::zeros();
        let by_mount = |p: &Vector6<f64>| rows(measured(stance, &mount(p), &none));
        let by_error = |e: &Vector3<f64>| rows(measured(stance, &mount(&at), e));
        let J: Matrix3x6<f64> = quotient(by_mount, &at);
        let A: Matrix3<f64> = quotient(by_error, &none);
        let covariance = A * P * A.transpose() + sensor;
        let weight = covariance.try_inverse().expect("regular");
        information += J.transpose() * weight * J;
    }
    let covariance = information.try_inverse().expect("regular");
    degrees_and_mm([0, 1, 2, 3, 4, 5].map(|k| covariance[(k, k)].sqrt()))
}

/// Computed once more with numpy from the paper's table, not by this code.
const PERFECT_SENSOR: [f64; 6] = [0.0783, 0.0240, 0.0306, 0.7871, 0.2651, 1.2149];

#[test]
fn poses_known_to_017_degrees_leave_008_degrees_of_alpha_to_any_estimator() {
    let tilt = 0.17_f64.to_radians();
    let perfect = Matrix3::identity() * 1e-16;
    let best = bound(tilt, 0.001, &perfect);
    println!("0.17°, 1 mm, a perfect sensor: {best:.4?}");
    for (got, expected) in best.iter().zip(PERFECT_SENSOR) {
        assert!((got / expected - 1.0).abs() < 2e-3, "{best:?}");
    }
    // Six feet in the place of three halve the variance of a pose.
    let six = bound(tilt / 2.0_f64.sqrt(), 0.001 / 2.0_f64.sqrt(), &perfect);
    println!("a pose from twice as many feet: {six:.4?}");
    assert!(six[0] > 0.05);
}

/// The estimator's own covariance is the bound: it leaves nothing of the data unused.
#[test]
fn the_estimator_reaches_the_bound() {
    let config = CameraConfig::default();
    let (tilt, height) = (config.robot_tilt_sigma_rad, config.robot_height_sigma_m);
    let noise = |tilt: f64, height: f64| {
        Matrix3::from_diagonal(&Vector3::new(tilt * tilt, tilt * tilt, height * height))
    };
    let sensor = noise(0.02_f64.to_radians(), 0.0005);
    let X_RV = published_extrinsics();
    let pairs = TABLE_A1.map(|stance| {
        let robot = GroundPlane::ground(&X_GR(stance), noise(tilt, height));
        let mut seen = robot.seen_from(&X_RV);
        seen.covariance = sensor;
        PlanePair::new(robot, seen)
    });
    let found = identify(&pairs, &config).expect("the poses determine the mount");
    let sigma = PaperParameters::of_mount(&found.X_RV).deviations(&found.covariance);
    let own = degrees_and_mm(sigma.expect("β is not ±90°"));
    let best = bound(tilt, height, &sensor);
    println!("bound {best:.4?}");
    for (own, best) in own.iter().zip(&best) {
        assert!((own / best - 1.0).abs() < 0.01, "{own}, {best}");
    }
}
