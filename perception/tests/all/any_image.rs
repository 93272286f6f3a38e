//! Depth images of any size and content: faces that hold what faces promise, or none.

use crate::support::Random;
use nalgebra::Isometry3;
use perception::{Config, DepthImage, Intrinsics, Method, Scan, Segmentation, Sensor, extract};
use proptest::prelude::*;

/// Rectangles of planes over one another, with noise, holes and a ragged border.
fn image(width: usize, height: usize, planes: usize, sigma: f64, seed: u64) -> DepthImage {
    let mut random = Random(seed);
    let mut z_m = vec![0.0_f32; width * height];
    let missing = 0.3 * random.uniform();
    let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
    for _ in 0..planes {
        let w = [
            between(-2e-3, 2e-3),
            between(-2e-3, 2e-3),
            between(0.1, 1.5),
        ];
        let [left, right] = [-0.3, 0.3].map(|low| between(low, low + 1.0) * width as f64);
        let [top, bottom] = [-0.3, 0.3].map(|low| between(low, low + 1.0) * height as f64);
        for (i, z) in z_m.iter_mut().enumerate() {
            let (u, v) = ((i % width) as f64, (i / width) as f64);
            if (left..right).contains(&u) && (top..bottom).contains(&v) {
                *z = (1.0 / (w[0] * u + w[1] * v + w[2])) as f32;
            }
        }
    }
    for z in &mut z_m {
        let noise = sigma * random.normal() * f64::from(*z);
        *z = if random.uniform() < missing {
            [0.0, f32::NAN, -1.0, f32::INFINITY][(4.0 * random.uniform()) as usize]
        } else {
            *z + noise as f32
        };
    }
    DepthImage {
        width,
        height,
        z_m,
        intrinsics: Intrinsics {
            fx: 120.0,
            fy: 110.0,
            cx: 0.5 * width as f64,
            cy: 0.4 * height as f64,
        },
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_image_gives_faces_that_hold_or_none(
        (width, height) in (1_usize..200, 1_usize..160),
        planes in 0_usize..6,
        sigma in prop_oneof![Just(0.0), Just(0.002), Just(0.05)],
        seed: u64,
    ) {
        let depth = image(width, height, planes, sigma, seed);
        let scan = Scan {
            cloud: depth.to_cloud(),
            ..Scan::of_image(depth, Sensor::named("xtion").unwrap().noise)
        };
        let config = Config { method: Method::Organised, ..Config::default() };
        let found = extract(&scan, &Isometry3::identity(), &config).unwrap();
        let pixels = found.segmentation.unwrap();
        prop_assert_eq!(pixels.labels.len(), width * height);
        let known = |label: &u16| *label == Segmentation::NONE || usize::from(*label) < pixels.planes_V.len();
        prop_assert!(pixels.labels.iter().all(known));
        prop_assert_eq!(pixels.plane_of_face.len(), found.faces.len());
        for face in &found.faces {
            prop_assert!(face.validate().is_ok(), "{:?}", face.validate());
        }
    }
}
