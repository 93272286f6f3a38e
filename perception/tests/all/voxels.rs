//! Clouds without an image against the boxes that they were taken of, by voxels and by the chain.
//!
//! Pass criteria: every upward face of stairs and of concave shapes comes out once, on its physical
//! face, where the chain's hulls cover air; several clouds in one as well as one.

use crate::support::{
    self, Block, against, block, by, concave, every, faces_of, on_face, pose, scan, top, touchable,
    unorganised,
};
use nalgebra::{Isometry3, Point3, Vector3};
use perception::{Method, PointCloud, Scan, extract};
use surfaces::Face;

fn stairs() -> Vec<Block> {
    // Small ones, 0.2 m square; of 0.14 m not every one is found.
    let stones = [
        block("stone1", [1.2, 0.75, 0.06], [0.2, 0.2, 0.12], 0.4, 0.0),
        block("stone2", [1.6, 0.80, 0.10], [0.2, 0.2, 0.20], -0.3, 0.0),
    ];
    let stairs = support::stairs().into_iter();
    let stairs = stairs.filter(|block| block.name != "step4");
    stairs.chain(stones).collect()
}

fn voxels(scan: &Scan) -> Vec<Face> {
    let found = faces_of(scan, Method::Voxels);
    assert!(found.iter().all(|face| face.plane_covariance.is_some()));
    found
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
        let found = voxels(&every(step, &scan(&world, &pose(), true, seed)));
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
    let bare = unorganised(&scan(&world, &pose(), true, 5));
    let found = voxels(&bare);
    let hulls = faces_of(&bare, Method::Brossette2013);
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
fn a_labelled_point_lies_on_the_plane_of_its_label() {
    let bare = every(3, &scan(&concave(), &pose(), true, 1));
    let found = extract(&bare, &bare.X_WV, &by(Method::Voxels)).unwrap();
    let labels = found.segmentation.unwrap();
    assert_eq!(labels.labels.len(), bare.cloud.points.len());
    for (p, &label) in bare.cloud.points.iter().zip(&labels.labels) {
        if label != perception::Segmentation::NONE {
            let (n, d) = labels.planes_V[usize::from(label)].unwrap();
            let height = n.dot(&Vector3::from(p.map(f64::from))) + d;
            assert!(height.abs() < 0.06 + 1e-6, "{height}");
        }
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
    let found = voxels(&both);
    for name in ["floor", "step1", "step2", "step3", "table"] {
        let face = top(&world, &[name]);
        let pieces = on_face(&found, &face, &world);
        assert!(!pieces.is_empty() && one_face(&pieces), "{name}");
        let (off, rms, _) = against(&pieces, touchable, &face, &world);
        assert!(off < 0.01 && rms < 0.012, "{name}: {off}, {rms} m");
    }
}
