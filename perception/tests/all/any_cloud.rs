//! Clouds of any size and content: faces that hold what faces promise, or none.

use crate::support::Random;
use nalgebra::{Isometry3, Vector3};
use perception::{Config, Method, PointCloud, Scan, Sensor, extract};
use proptest::prelude::*;

/// Points of rectangles, of lines and of single places, with noise; some are not finite.
fn points(parts: usize, count: usize, scale: f64, sigma: f64, seed: u64) -> Vec<[f32; 3]> {
    let mut random = Random(seed);
    let mut points = Vec::new();
    for _ in 0..parts {
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * (2.0 * random.uniform() - 1.0));
        let (middle, mut a, mut b) = (vector(scale), vector(1.0), vector(1.0));
        match (4.0 * random.uniform()) as usize {
            0 => b = a,
            1 => (a, b) = (Vector3::zeros(), Vector3::zeros()),
            _ => {}
        }
        for _ in 0..count {
            let (s, t) = (random.uniform(), random.uniform());
            let noise = Vector3::from_fn(|_, _| sigma * random.normal());
            let p = (middle + a * s + b * t + noise).map(|x| x as f32);
            let lost = random.uniform() < 0.01;
            points.push(if lost {
                [f32::NAN, p.y, f32::INFINITY]
            } else {
                p.into()
            });
        }
    }
    points
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn any_cloud_gives_faces_that_hold_or_none(
        parts in 0_usize..5,
        count in prop_oneof![0_usize..20, 500_usize..4000],
        scale in prop_oneof![Just(0.0), Just(2.0), Just(1e6)],
        sigma in prop_oneof![Just(0.0), Just(0.003), Just(0.1)],
        method in prop_oneof![Just(Method::Voxels), Just(Method::Brossette2013), Just(Method::Auto)],
        seed: u64,
    ) {
        let points = points(parts, count, scale, sigma, seed);
        let scan = Scan {
            cloud: PointCloud { points, organised: None, invalid: 0 },
            depth: None,
            X_WV: Isometry3::identity(),
            eye_V: Vector3::zeros(),
            noise: Sensor::named("generic").unwrap().noise,
            notes: Vec::new(),
        };
        let config = Config { method, ..Config::default() };
        let Ok(found) = extract(&scan, &Isometry3::identity(), &config) else { return Ok(()) };
        for face in &found.faces {
            prop_assert!(face.validate().is_ok(), "{:?}", face.validate());
        }
    }
}
