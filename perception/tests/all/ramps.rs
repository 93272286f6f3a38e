//! Simulated sweeps of ramps, read back from their files.
// Benches share this with the tests, and use only some of it.
#![allow(dead_code, clippy::unwrap_used)]

use std::path::Path;

use nalgebra::{Isometry3, Matrix4, Point3, Translation3, UnitQuaternion};
use perception::lidar::{LidarCalibration, LidarCloud, Slope};
use perception::parse_lidar;
use scenes::Truth;
use scenes::simulator::lidar::{RangeNoise, Sweep, Vlp16, pcd, sweep};
use scenes::worlds::slope::Ramp;

/// A mount: roll, pitch, yaw in degrees, height in m.
pub fn mount(roll: f64, pitch: f64, yaw: f64, height_m: f64) -> Isometry3<f64> {
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_radians);
    Isometry3::from_parts(
        Translation3::new(0.0, 0.0, height_m),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// The mount that the figures are given for.
pub fn usual_mount() -> Isometry3<f64> {
    mount(1.5, 8.0, 3.0, 0.75)
}

/// A sweep of a world; ring biases and noise belong to the seed.
pub fn take(truth: &Truth, X_WV: &Isometry3<f64>, seed: u64) -> Sweep {
    let noise = RangeNoise::default();
    sweep(&truth.world(), &Vlp16::default(), X_WV, &noise, seed, seed)
}

/// What the reader makes of the sweep's PCD.
pub fn cloud(sweep: &Sweep) -> LidarCloud {
    parse_lidar(Path::new("sweep.pcd"), &pcd(sweep), None)
        .unwrap()
        .cloud
}

/// The calibration that a perfect one would be, known to 0.02° and 1 mm; with the rings' errors to
/// 1 mm, or without them.
pub fn calibration(X_WV: &Isometry3<f64>, rings: Option<&Sweep>) -> LidarCalibration {
    let tilt = 0.02_f64.to_radians().powi(2);
    let covariance = Matrix4::from_diagonal(&nalgebra::Vector4::new(tilt, tilt, tilt, 1e-6));
    let mut calibration = LidarCalibration::from_pose(X_WV, &covariance);
    calibration.heading_known = true;
    if let Some(sweep) = rings {
        calibration.ring_bias_m = sweep.ring_bias_m.to_vec();
        calibration.ring_bias_sigma_m = vec![0.001; 16];
    }
    calibration
}

/// How far the ends of a slope's start line are from a ramp's, m: p₁'s, p₂'s.
pub fn end_errors_m(slope: &Slope, ramp: &Ramp) -> [f64; 2] {
    // The left end is p₂: l points to the left of who goes up.
    let [left, right] = ramp.ends_m().map(Point3::from);
    let d = &slope.description;
    [(d.p1_W - right).norm(), (d.p2_W - left).norm()]
}
