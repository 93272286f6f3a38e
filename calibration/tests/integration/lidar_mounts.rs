//! The mount of a LiDAR from simulated sweeps: roll, pitch, drift angle, height, and ring errors.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use calibration::lidar::{Calibrated, LidarExtrinsicsConfig, calibrate};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use perception::lidar::{LidarCloud, LidarConfig};
use perception::parse_lidar;
use scenes::simulator::lidar::{RangeNoise, Sweep, Vlp16, pcd, sweep};
use scenes::simulator::rng::Stream;
use scenes::worlds::slope::{POLES_M, room};

fn mount(roll: f64, pitch: f64, yaw: f64) -> Isometry3<f64> {
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_radians);
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.75), rotation)
}

fn take(X_WV: &Isometry3<f64>, device: u64, seed: u64) -> (LidarCloud, Sweep) {
    let world = room("flat", &[]).world();
    let noise = RangeNoise::default();
    let taken = sweep(&world, &Vlp16::default(), X_WV, &noise, device, seed);
    let read = parse_lidar(Path::new("flat.pcd"), &pcd(&taken), None).unwrap();
    (read.cloud, taken)
}

fn calibrated(clouds: &[LidarCloud], poles: &[[f64; 2]]) -> Calibrated {
    let (mount, lidar) = (LidarExtrinsicsConfig::default(), LidarConfig::default());
    calibrate(clouds, poles, &mount, &lidar).unwrap()
}

/// Roll and pitch up to 20°, drift up to 30°; the first exactly level, half with A < 0.
#[test]
fn ten_mounts_come_out_to_a_tenth_of_a_degree() {
    let draw = Stream::new(11, 0);
    let mut negative = 0;
    let mut errors_in_sigmas = Vec::new();
    for number in 0..10_u64 {
        let within = |k: u64, most: f64| most * (2.0 * draw.uniform(3 * number + k) - 1.0);
        let angles = match number {
            0 => [0.0; 3],
            // A sensor that looks up has a normal with A < 0, whatever was drawn.
            1 => [4.0, -12.0, 7.0],
            _ => [within(0, 20.0), within(1, 20.0), within(2, 30.0)],
        };
        let X_WV = mount(angles[0], angles[1], angles[2]);
        negative += usize::from((X_WV.rotation.inverse() * Vector3::z()).x < 0.0);
        let (cloud, _) = take(&X_WV, number, number);
        let found = calibrated(&[cloud], &POLES_M);
        let off = found.calibration.X_WV().rotation.angle_to(&X_WV.rotation);
        let height_m = found.calibration.position_m[2] - 0.75;
        println!(
            "{angles:?}: {:.3}° off, {:.1} mm, {} poles",
            off.to_degrees(),
            1e3 * height_m,
            found.drift.as_ref().unwrap().matches.len()
        );
        assert!(off.to_degrees() < 0.1, "{angles:?}: {}°", off.to_degrees());
        assert!(height_m.abs() < 0.01, "{angles:?}: {height_m} m");
        // What is left over is the drift's error, mostly; it is known what it may be.
        let sigma = found.calibration.covariance;
        let spread = (sigma[0][0] + sigma[1][1] + sigma[2][2]).sqrt();
        errors_in_sigmas.push(off / spread);
    }
    assert!(negative >= 3, "{negative} mounts with A < 0");
    let rms = (errors_in_sigmas.iter().map(|e| e * e).sum::<f64>() / 10.0).sqrt();
    println!("errors in their own standard deviations: {rms:.2}");
    assert!((0.3..2.0).contains(&rms), "{rms}");
}

#[test]
fn the_rings_errors_come_out_of_ground_and_walls() {
    let device = 0;
    let mut clouds = Vec::new();
    let mut truth = [0.0; 16];
    for (seed, yaw) in [-40.0, 0.0, 40.0].into_iter().enumerate() {
        let (cloud, taken) = take(&mount(1.5, 8.0, yaw), device, seed as u64);
        truth = taken.ring_bias_m;
        clouds.push(cloud);
    }
    let found = calibrated(&clouds, &[]);
    assert!(found.drift.is_none() && !found.calibration.heading_known);
    let rms = |values: &[f64]| {
        let square: f64 = values.iter().map(|v| v * v).sum();
        (square / values.len() as f64).sqrt()
    };
    let (biases, fit) = (&found.calibration, found.adjustment.rms_m);
    let left = biases.ring_bias_m.iter().zip(&truth).map(|(a, b)| a - b);
    let left: Vec<f64> = left.collect();
    let in_sigmas = left.iter().zip(&biases.ring_bias_sigma_m);
    let in_sigmas: Vec<f64> = in_sigmas.map(|(e, s)| e / s).collect();
    let [was, is, sigmas] = [&truth[..], &left, &in_sigmas].map(rms);
    println!("rms of the errors {was:.5} m, {is:.5} m left, {sigmas:.2} σ; fit {fit:?}");
    assert_eq!(left.len(), 16);
    assert!(was > 0.005);
    // A third of what they were, at least.
    assert!(is < was / 3.0, "{left:?}");
    assert!(sigmas < 2.5, "{in_sigmas:?}");
    assert!(fit[1] < fit[0]);
}

#[test]
fn without_ground_or_with_other_poles_the_cause_is_named() {
    let config = (LidarExtrinsicsConfig::default(), LidarConfig::default());
    let wall = LidarCloud::from_points((0..4000).map(|i| {
        let (a, b) = (i % 80, i / 80);
        [3.0, 0.05 * a as f32 - 2.0, 0.05 * b as f32 - 1.2]
    }));
    let error = calibrate(&[wall], &[], &config.0, &config.1).unwrap_err();
    assert!(error.to_string().contains("ground"), "{error}");
    let (cloud, _) = take(&mount(0.0, 8.0, 0.0), 1, 1);
    let (clouds, elsewhere) = ([cloud], [[9.0, 9.0], [1.0, -7.0]]);
    for (poles, word) in [(&elsewhere[..], "poles"), (&POLES_M[..1], "two")] {
        let error = calibrate(&clouds, poles, &config.0, &config.1).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let three = LidarCloud::from_points([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [2.0, 0.0, 0.1]]);
    assert!(calibrate(&[three], &[], &config.0, &config.1).is_err());
}
