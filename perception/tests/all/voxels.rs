//! Clouds without an image against the boxes that they were taken of, by voxels and by the chain.
//!
//! Pass criteria: every upward face of stairs and of concave shapes comes out once, on its physical
//! face, where the chain's hulls cover air; more faces than the chain finds; the same on any number of
//! threads and whatever the order of hashing; several clouds in one as well as one.

use crate::support::{
    Block, against, block, camera, concave, on_face, scan, top, touchable, unorganised,
};
use nalgebra::{Isometry3, Point3, Vector3};
use perception::{Config, Extraction, Method, PointCloud, Scan, extract};
use surfaces::Face;

fn stairs() -> Vec<Block> {
    vec![
        block("floor", [4.0, 0.0, -0.05], [12.0, 12.0, 0.1], 0.0, 0.0),
        block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        block("step1", [1.15, 0.05, 0.075], [0.34, 0.62, 0.15], 0.1, 0.0),
        block("step2", [1.50, -0.02, 0.15], [0.36, 0.70, 0.30], -0.07, 0.0),
        block("step3", [1.88, 0.06, 0.22], [0.38, 0.55, 0.44], 0.05, 0.0),
        block("table", [2.90, 0.0, 0.695], [0.80, 1.60, 0.03], 0.02, 0.0),
        block("ramp", [1.9, -1.15, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
        // Small ones, 0.2 m square; of 0.14 m not every one is found.
        block("stone1", [1.2, 0.75, 0.06], [0.2, 0.2, 0.12], 0.4, 0.0),
        block("stone2", [1.6, 0.80, 0.10], [0.2, 0.2, 0.20], -0.3, 0.0),
    ]
}

fn pose() -> Isometry3<f64> {
    camera(1.45, 0.61)
}

/// Every `step`-th point of a scan as a bare cloud.
fn cloud(scan: &Scan, step: usize) -> Scan {
    let mut bare = unorganised(scan);
    bare.cloud.points = bare.cloud.points.into_iter().step_by(step).collect();
    bare
}

fn run(scan: &Scan, method: Method) -> Extraction {
    let config = Config {
        method,
        ..Config::default()
    };
    extract(scan, &scan.X_WV, &config).unwrap()
}

fn faces_of(scan: &Scan) -> Vec<Face> {
    let found = run(scan, Method::Voxels);
    let eye = scan.X_WV * Point3::from(scan.eye_V);
    for (i, face) in found.faces.iter().enumerate() {
        face.validate().unwrap();
        assert_eq!(face.id, format!("f{i}").into());
        assert!(face.height_of(&eye) > 0.0, "{} looks away", face.id);
        assert!(face.plane_covariance.is_some());
    }
    found.faces
}

/// Whether the faces are one but for islands: the largest has nearly all of the area.
fn one_face(found: &[&Face]) -> bool {
    let whole: f64 = found.iter().map(|face| face.region.area()).sum();
    found[0].region.area() > 0.9 * whole
}

#[test]
fn every_tread_of_a_bare_cloud_is_found_once_and_on_its_face() {
    let world = stairs();
    for (seed, step) in [(1, 1), (2, 5), (3, 1), (4, 5)] {
        // All 290 000 points, and 58 000 of them.
        let found = faces_of(&cloud(&scan(&world, &pose(), true, seed), step));
        for (name, least_m2) in [
            ("floor", 2.5),
            ("step1", 0.13),
            ("step2", 0.13),
            ("step3", 0.10),
            ("table", 0.8),
            ("ramp", 0.45),
            // 0.2 m less, on every side, up to two cells of 2 cm and the inset of 1 cm.
            ("stone1", 0.01),
            ("stone2", 0.01),
        ] {
            let face = top(&world, &[name]);
            let pieces = on_face(&found, &face, &world);
            assert!(!pieces.is_empty(), "seed {seed}: {name} is missing");
            let (off, rms, area) = against(&pieces, touchable, &face, &world);
            eprintln!(
                "seed {seed}: {name}: {area:.3} m², {:.2} % off, {:.1} mm, {} pieces",
                100.0 * off,
                1e3 * rms,
                pieces.len()
            );
            assert!(one_face(&pieces), "seed {seed}: {name} is more than one");
            assert!(area > least_m2, "seed {seed}: {name}: {area} m²");
            // 1 % of a step's area is 1.5 mm of its border.
            assert!(off < 0.01, "seed {seed}: {name}: {:.1} % off", 100.0 * off);
            // 0.4 % of z, 4 to 12 mm, vary slowly: a small face cannot tell that from its place.
            assert!(rms < 0.016, "seed {seed}: {name}: {:.1} mm", 1e3 * rms);
        }
    }
}

#[test]
fn concave_faces_hold_no_air_where_hulls_do() {
    let world = concave();
    let bare = cloud(&scan(&world, &pose(), true, 5), 1);
    let found = faces_of(&bare);
    let hulls = run(&bare, Method::Brossette2013).faces;
    for (names, least_m2) in [
        (&["l_long", "l_short"][..], 0.30),
        (&["u_right", "u_far", "u_left"], 0.30),
        (&["table"], 0.8),
    ] {
        let face = top(&world, names);
        let pieces = on_face(&found, &face, &world);
        let (off, _, area) = against(&pieces, touchable, &face, &world);
        eprintln!("{names:?}: {area:.3} m², {:.2} % off", 100.0 * off);
        assert!(one_face(&pieces), "{names:?}");
        assert!(pieces[0].region.as_convex().is_none(), "{names:?}");
        assert!(off < 0.01, "{names:?}: {:.1} % air", 100.0 * off);
        assert!(area > least_m2, "{names:?}: {area} m²");
    }
    // What the chain covers of them is off by far more; the U's barycentre may be in the air.
    let face = top(&world, &["l_long", "l_short"]);
    let (air, _, _) = against(&on_face(&hulls, &face, &world), touchable, &face, &world);
    assert!(air > 0.05, "the chain's hull of the L: {air}");
}

#[test]
fn a_leg_beside_the_floor_is_no_part_of_it() {
    let mut world = vec![block(
        "floor",
        [4.0, 0.0, -0.05],
        [12.0, 12.0, 0.1],
        0.0,
        0.0,
    )];
    world.push(block("leg", [1.8, 0.1, 0.3], [0.08, 0.08, 0.6], 0.3, 0.0));
    let found = faces_of(&cloud(&scan(&world, &pose(), true, 4), 2));
    let face = top(&world, &["floor"]);
    let (_, rms, area) = against(&on_face(&found, &face, &world), touchable, &face, &world);
    assert!(rms < 0.012 && area > 3.5, "{rms} m, {area} m²");
}

#[test]
fn the_result_depends_on_the_points_only() {
    let world = concave();
    let bare = cloud(&scan(&world, &pose(), true, 1), 3);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run(&bare, Method::Voxels))
    };
    let one = on(1);
    assert!(!one.faces.is_empty());
    assert_eq!(one, on(2));
    assert_eq!(one, on(4));
    // Each labelled point lies on the plane that its label names.
    let labels = one.segmentation.as_ref().unwrap();
    assert_eq!(labels.labels.len(), bare.cloud.points.len());
    for (p, &label) in bare.cloud.points.iter().zip(&labels.labels) {
        if label != perception::Segmentation::NONE {
            let (n, d) = labels.planes_V[usize::from(label)].unwrap();
            let height = n.dot(&Vector3::from(p.map(f64::from))) + d;
            assert!(height.abs() < 0.06 + 1e-6, "{height}");
        }
    }
    // The sensor's pose moves the faces and changes nothing else.
    let X = Isometry3::new(Vector3::new(0.3, -0.2, 0.7), Vector3::new(0.0, 0.0, 0.8));
    let config = Config {
        method: Method::Voxels,
        ..Config::default()
    };
    let there = extract(&bare, &(X * bare.X_WV), &config).unwrap().faces;
    assert_eq!(there.len(), one.faces.len());
    for (a, b) in one.faces.iter().zip(&there) {
        assert!((X.rotation * a.normal_W() - b.normal_W()).norm() < 1e-9);
        assert!((a.region.area() - b.region.area()).abs() < 1e-6);
    }
}

#[test]
fn clouds_that_were_merged_into_one_are_a_cloud_as_any_other() {
    // Two scans from either side, moved into one frame: the eye is that of the first.
    let world = stairs();
    let beside = Isometry3::new(Vector3::new(0.2, 1.0, 0.0), Vector3::z() * -0.5) * pose();
    let (a, b) = (
        scan(&world, &pose(), true, 1),
        scan(&world, &beside, true, 2),
    );
    let X_AB = a.X_WV.inverse() * b.X_WV;
    let moved = b.cloud.finite().map(|p| {
        let p = X_AB * Point3::from(p.map(f64::from));
        [p.x as f32, p.y as f32, p.z as f32]
    });
    let points = a.cloud.finite().copied().chain(moved).collect();
    let both = Scan {
        cloud: PointCloud {
            points,
            ..PointCloud::default()
        },
        depth: None,
        ..a.clone()
    };
    let found = faces_of(&both);
    for name in ["floor", "step1", "step2", "step3", "table"] {
        let face = top(&world, &[name]);
        let pieces = on_face(&found, &face, &world);
        assert!(!pieces.is_empty() && one_face(&pieces), "{name}");
        let (off, rms, _) = against(&pieces, touchable, &face, &world);
        assert!(off < 0.01 && rms < 0.012, "{name}: {off}, {rms} m");
    }
}

#[test]
fn plane_covariances_are_the_size_of_the_errors() {
    let world = stairs();
    let mut nees = Vec::new();
    for seed in 1..=6 {
        let found = faces_of(&cloud(&scan(&world, &pose(), true, seed), 5));
        for name in ["floor", "step1", "step2", "step3", "table", "ramp"] {
            let face = top(&world, &[name]);
            let Some(found) = on_face(&found, &face, &world).first().copied() else {
                continue;
            };
            nees.push(crate::support::nees(found, &face) / 3.0);
        }
    }
    let mean = nees.iter().sum::<f64>() / nees.len() as f64;
    eprintln!("NEES/3: mean {mean:.2} of {}: {nees:.2?}", nees.len());
    // 36 faces of six frames; the errors of one frame's faces are not independent.
    assert!((0.5..2.0).contains(&mean), "{mean}: {nees:.2?}");
}

#[test]
fn thin_input_gives_few_faces_and_never_a_panic() {
    let full = scan(&stairs(), &pose(), true, 3);
    let with = |points: Vec<[f32; 3]>| Scan {
        cloud: PointCloud {
            points,
            ..PointCloud::default()
        },
        depth: None,
        ..full.clone()
    };
    let line = (0..4000).map(|i| [0.0, 0.0005 * i as f32, 1.0]).collect();
    let same = vec![[0.3, 0.2, 1.0]; 5000];
    let odd = (0..5000)
        .map(|i| [f32::NAN, f32::INFINITY, 1e30, -1e30, 1e-30, 2.0][i % 6])
        .map(|c| [c, 0.0, c])
        .collect();
    for points in [Vec::new(), vec![[0.0, 0.0, 1.0]], line, same, odd] {
        assert!(faces_of(&with(points)).is_empty());
    }
}
