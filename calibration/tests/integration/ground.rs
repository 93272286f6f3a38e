//! The ground's plane in simulated frames: the forms of the trimming, clutter, clouds, covariance.

use crate::support::Device;
use calibration::GroundPlane;
use calibration::ground::{Ground, GroundConfig, ground};
use nalgebra::{Matrix3, Rotation3, Vector3};
use perception::Scan;
use scenes::OrientedBox;
use scenes::camera_set::published_extrinsics;
use scenes::simulator::{DepthNoise, World};
use scenes::stances;

const STANCE: [f64; 3] = [5.0, -4.0, 0.68];

fn undistorted() -> DepthNoise {
    DepthNoise {
        distortion: 0.0,
        ..DepthNoise::default()
    }
}

fn world(clutter: &[OrientedBox]) -> World {
    let mut truth = scenes::worlds::ground::truth(None, 0);
    truth.boxes.extend(clutter.iter().cloned());
    truth.world()
}

fn shoot(world: &World, noise: &DepthNoise, seed: u64) -> Scan {
    let device = Device::kinect(4, noise);
    let X_GR = stances::X_GR(STANCE);
    let field = device.distortion(seed);
    device.shoot(world, &X_GR, &published_extrinsics(), &field, seed)
}

fn truth() -> GroundPlane {
    GroundPlane::ground(&stances::X_GR(STANCE), Matrix3::zeros()).seen_from(&published_extrinsics())
}

/// Angle (rad) and distance (m) from the true plane.
fn error(found: &Ground) -> (f64, f64) {
    let truth = truth();
    (
        found.plane.angle_to(&truth),
        (found.plane.distance_m - truth.distance_m).abs(),
    )
}

#[test]
fn trimming_settles_on_nearly_all_of_bare_ground() {
    let scan = shoot(&world(&[]), &undistorted(), 1);
    let found = ground(&scan, &GroundConfig::default()).expect("there is ground");
    // Noise that grows with depth has longer tails than a Gaussian, of which 3σ leave 99.7 %.
    let left = found.inliers as f64 / found.samples as f64;
    assert!(found.converged && (0.95..1.0).contains(&left), "{left}");
    let (angle, distance) = error(&found);
    assert!(angle < 0.1_f64.to_radians() && distance < 0.003);
}

#[test]
fn ground_is_found_beside_walls_and_boxes() {
    let at = |name, x: f64, y: f64, size: [f64; 3]| {
        let centre = Vector3::new(x, y, size[2] / 2.0);
        OrientedBox::new(name, centre, size, Rotation3::identity())
    };
    let clutter = [
        at("wall", 3.0, 0.0, [0.2, 4.0, 2.0]),
        at("crate", 1.9, 0.5, [0.5, 0.5, 0.3]),
        at("pole", 2.0, -0.6, [0.1, 0.1, 1.5]),
    ];
    let scan = shoot(&world(&clutter), &undistorted(), 2);
    let found = ground(&scan, &GroundConfig::default()).expect("there is ground");
    let obstructed = found.inliers < found.samples * 9 / 10;
    assert!(obstructed, "nothing was in the way");
    let (angle, distance) = error(&found);
    let near = angle < 0.1_f64.to_radians() && distance < 0.003;
    assert!(near, "{angle} rad, {distance} m");
}

#[test]
fn a_cloud_gives_the_plane_of_its_image() {
    let mut scan = shoot(&world(&[]), &undistorted(), 3);
    let config = GroundConfig::default();
    let of_image = ground(&scan, &config).expect("there is ground");
    scan.cloud = scan.depth.take().expect("an image").to_cloud();
    let of_cloud = ground(&scan, &config).expect("there is ground");
    // The same points, weighed by range in the place of depth.
    let angle = of_image.plane.angle_to(&of_cloud.plane);
    let distance = (of_image.plane.distance_m - of_cloud.plane.distance_m).abs();
    assert!(angle < 2e-4 && distance < 5e-4, "{angle} rad, {distance} m");
}

#[test]
fn too_little_ground_is_an_error_that_says_how_much() {
    let mut scan = shoot(&world(&[]), &undistorted(), 4);
    let depth = scan.depth.as_mut().expect("an image");
    depth.z_m.iter_mut().skip(300).for_each(|z| *z = 0.0);
    let error = ground(&scan, &GroundConfig::default()).expect_err("a row or two");
    assert!(error.to_string().contains("500 are needed"), "{error}");
    scan.depth = None;
    assert!(ground(&scan, &GroundConfig::default()).is_err());
}

/// The covariance of the plane against the truth, the distortion drawn anew in each frame: mean of
/// eᵀ Σ⁻¹ e / 3 over 40 frames within 0.5–2.
#[test]
fn planes_are_as_uncertain_as_they_say() {
    let config = GroundConfig {
        distortion_shared: 0.0,
        ..GroundConfig::default()
    };
    let truth = truth();
    for (name, noise) in [
        ("undistorted", undistorted()),
        ("distorted", DepthNoise::default()),
    ] {
        let world = world(&[]);
        let frames = 40;
        let of_frame = |seed: u64| {
            let found = ground(&shoot(&world, &noise, 100 + seed), &config).expect("ground");
            let tilt = found.plane.tangents().transpose() * truth.normal.into_inner();
            let distance = truth.distance_m - found.plane.distance_m;
            let e = Vector3::new(tilt.x, tilt.y, distance);
            let inverse = found.plane.covariance.try_inverse().expect("regular");
            e.dot(&(inverse * e)) / 3.0
        };
        let nees = (0..frames).map(of_frame).sum::<f64>() / frames as f64;
        println!("{name}: NEES/3 {nees:.2}");
        assert!((0.5..2.0).contains(&nees), "{name}: {nees}");
    }
}
