//! Scans as strangers bring them: clouds of better sensors than any that is named, clouds whose sensor stood elsewhere,
//! ground of which little is seen, faces with necks.
//!
//! Pass criteria: every tread is found as large as it is, less what its edges take; the ground is what the sensor
//! stands over; nothing that is seen is left out.

use nalgebra::{Isometry3, Vector3};
use perception::{Config, Method, PosedScan, Scan, Sensor, extract, ground_pose, perceive};

use crate::support::{
    Block, Random, against, block, camera, faces_of, floor, on_face, scan, top, touchable,
    unorganised,
};

/// Four treads 0.3 m deep that rise by 0.16 m, in the frame of the world, from `x` on.
fn treads(x: f64) -> Vec<Block> {
    let names = ["tread1", "tread2", "tread3", "tread4"];
    let treads = names.into_iter().zip(1..).map(|(name, i)| {
        let (i, z) = (f64::from(i), 0.16 * f64::from(i));
        block(name, [x + 0.3 * i, 0.0, z / 2.0], [0.3, 1.0, z], 0.0, 0.0)
    });
    [floor()].into_iter().chain(treads).collect()
}

/// A bare cloud in the frame of the world with `sigma` (m) along its rays, of a sensor that nobody names.
fn measured(world: &[Block], X_WV: &Isometry3<f64>, sigma: f64, seed: u64) -> Scan {
    let mut seen = unorganised(&scan(world, X_WV, false, 1));
    let mut random = Random(seed);
    for p in &mut seen.cloud.points {
        let p_V = Vector3::from(p.map(f64::from));
        let p_V = p_V + p_V.normalize() * sigma * random.normal();
        *p = (X_WV * nalgebra::Point3::from(p_V))
            .coords
            .map(|c| c as f32)
            .into();
    }
    Scan {
        X_WV: Isometry3::identity(),
        eye_V: X_WV.translation.vector,
        noise: Sensor::named("generic").unwrap().noise,
        ..seen
    }
}

/// Another sensor's noise, 2 cm at this distance, makes one slope of treads and what is between them.
#[test]
fn a_cloud_of_little_noise_keeps_its_treads() {
    let world = treads(2.9);
    for (sigma, seed) in [(0.001, 1), (0.002, 2), (0.003, 3)] {
        let seen = measured(&world, &camera(1.7, 0.5), sigma, seed);
        let found = faces_of(&seen, Method::Voxels);
        for name in ["tread1", "tread2", "tread3", "tread4"] {
            let face = top(&world, &[name]);
            let (off, _, area_m2) =
                against(&on_face(&found, &face, &world), touchable, &face, &world);
            // Of 0.3 m² a riser and the inset of every edge take some; half is there.
            assert!(
                area_m2 > 0.15 && off < 0.02,
                "{sigma} {name}: {area_m2} m², {off} off"
            );
        }
    }
}

/// Each seed in the floor's plane grew to the whole of it, and each time it was refused: it is seen under no angle.
#[test]
fn a_floor_in_whose_plane_the_sensor_is_said_to_be_costs_no_square_of_its_voxels() {
    let world = treads(1.0);
    let mut seen = measured(&world, &camera(1.7, 0.6), 0.002, 1);
    let side = 600;
    let mut random = Random(2);
    seen.cloud.points.extend((0..side * side).map(|i| {
        let at = |k: usize| 6.0 * (k as f32 / side as f32 - 0.5);
        [at(i % side), at(i / side), 0.002 * random.normal() as f32]
    }));
    seen.eye_V = Vector3::zeros();
    let config = Config::default();
    let name = "cloud";
    let X_WV = Isometry3::identity();
    let told = |scan: &Scan| -> Vec<String> {
        let found = perceive(&[PosedScan::Scan { name, scan, X_WV }], &config).unwrap();
        found.notices.iter().map(ToString::to_string).collect()
    };
    let hidden = |told: Vec<String>| told.iter().any(|said| said.contains("give the --eye"));
    assert!(hidden(told(&seen)));
    // Nothing is said of a cloud that is seen from where it was.
    assert!(!hidden(told(&measured(
        &world,
        &camera(1.7, 0.6),
        0.002,
        1
    ))));
}

#[test]
fn the_ground_is_what_the_sensor_stands_over_however_little_is_seen_of_it() {
    let down = block("down", [5.0, 0.0, -0.85], [20.0, 12.0, 0.1], 0.0, 0.0);
    let landing = block("landing", [-0.1, 0.0, -0.5], [2.0, 4.0, 1.0], 0.0, 0.0);
    let kerb = block("kerb", [6.0, 0.0, 0.06], [10.0, 12.0, 0.12], 0.0, 0.0);
    let stairs = || treads(0.55);
    for (what, world, pitch) in [
        ("kerb", vec![floor(), kerb], 0.61),
        ("landing", vec![down, landing], 0.8),
        // The view ends on the first tread, and on the floor on both sides of it.
        ("stairs", stairs(), 0.61),
    ] {
        for seed in [1, 2] {
            let seen = scan(&world, &camera(1.4, pitch), true, seed);
            let found = ground_pose(&seen, None, &Config::default()).unwrap();
            // The slow error of a small patch, far below the 0.12 m of the kerb.
            let off_m = found.height_m() - 1.4;
            assert!(off_m.abs() < 0.03, "{what}: {off_m} m");
        }
    }
}

/// From low down treads have necks between what stands on them and what is hidden.
#[test]
fn no_face_is_left_out_since_its_sides_pass_each_other() {
    for seed in [5, 28, 31] {
        let mut random = Random(20_100 + seed);
        let mut world = treads(0.8);
        world.extend((0..80).map(|_| {
            let [x, y, a] = [(); 3].map(|()| random.uniform());
            let size = [(); 3].map(|()| 0.03 + 0.06 * random.uniform());
            let at = [0.7 + 2.5 * x, 3.0 * y - 1.5, 0.05];
            block("pebble", at, size, 3.0 * a, 0.0)
        }));
        let seen = scan(&world, &camera(0.45, 0.25), true, seed);
        let found = extract(&seen, &seen.X_WV, &Config::default()).unwrap();
        assert!(found.refused.is_empty(), "{seed}: {:?}", found.refused);
    }
}
