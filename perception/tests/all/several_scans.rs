//! Several scans of one world as one terrain, against the boxes that they were taken of.
//!
//! Pass criteria: every face comes out once, on its physical face, larger than any single scan shows
//! it and under the name that the first scan gave it; what was moved between two scans is where the
//! later one saw it; poses that are a little off are found again.

use crate::support::{
    Block, against, block, camera, floor, on_face, on_threads, scan, top, unorganised, whole,
};
use nalgebra::{Isometry3, Point3, Vector3};
use perception::{
    Config, Notice, Perception, PosedScan, RegistrationConfig, Scan, extract, perceive, register,
};
use surfaces::Face;
use surfaces::fuse::Change;

/// Irregular steps, a table, a ramp, three walls, and a post that hides a part of each from each side.
fn world() -> Vec<Block> {
    vec![
        floor(),
        block("ahead", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        block("left", [3.0, 1.65, 1.5], [4.0, 0.1, 3.0], 0.0, 0.0),
        block("right", [3.0, -2.0, 1.5], [4.0, 0.1, 3.0], 0.0, 0.0),
        block("step1", [1.55, 0.05, 0.075], [0.34, 0.62, 0.15], 0.1, 0.0),
        block("step2", [1.90, -0.02, 0.15], [0.36, 0.70, 0.30], -0.07, 0.0),
        block("step3", [2.28, 0.06, 0.22], [0.38, 0.55, 0.44], 0.05, 0.0),
        block("table", [3.10, 0.0, 0.695], [0.80, 1.60, 0.03], 0.02, 0.0),
        block("ramp", [2.2, -1.35, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
        block("post", [1.2, -0.25, 0.5], [0.06, 0.06, 1.0], 0.3, 0.0),
    ]
}

const TOPS: [&str; 6] = ["floor", "step1", "step2", "step3", "table", "ramp"];

/// A camera at (x, y, 1.45) that looks down by 35°, `yaw` to the left.
fn pose(x: f64, y: f64, yaw: f64) -> Isometry3<f64> {
    Isometry3::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw) * camera(1.45, 0.61)
}

/// From the front, from the left and from the right.
fn scans(world: &[Block], seed: u64) -> Vec<Scan> {
    let poses = [
        pose(0.0, 0.0, 0.0),
        pose(0.5, 1.3, -0.7),
        pose(0.4, -1.5, 0.6),
    ];
    let numbered = poses.iter().zip(seed..);
    numbered
        .map(|(pose, seed)| scan(world, pose, true, seed))
        .collect()
}

/// Scans as one terrain, one after the other.
fn fused(scans: &[Scan]) -> Perception {
    let posed = |scan| PosedScan::Scan {
        name: "scan",
        scan,
        X_WV: scan.X_WV,
    };
    let posed: Vec<PosedScan> = scans.iter().map(posed).collect();
    let found = perceive(&posed, &Config::default()).unwrap();
    found.terrain.validate().unwrap();
    found
}

/// What became of faces as views were fused.
fn changes(found: &Perception) -> Vec<&Change> {
    let notices = found.notices.iter();
    let changes = notices.filter_map(|notice| match notice {
        Notice::Fused(change) => Some(change),
        _ => None,
    });
    changes.collect()
}

fn alone(scan: &Scan) -> Vec<Face> {
    extract(scan, &scan.X_WV, &Config::default()).unwrap().faces
}

/// Whether nothing is there twice, and the first has all but islands of what was seen.
fn one_face(found: &[&Face]) -> bool {
    let area: f64 = found.iter().map(|face| face.region.area()).sum();
    let apart = |a: &Face, b: &Face| {
        let X_AB = a.X_WF.inverse() * b.X_WF;
        whole(a).common(&whole(b).moved(&X_AB)).area() < 0.001
    };
    let mut others = (0..found.len()).flat_map(|i| found[..i].iter().map(move |b| (i, b)));
    found[0].region.area() > 0.9 * area && others.all(|(i, b)| apart(found[i], b))
}

#[test]
fn every_face_comes_out_once_and_larger_than_from_anywhere_alone() {
    let world = world();
    for seed in [1, 11] {
        let scans = scans(&world, seed);
        let singles: Vec<Vec<Face>> = scans.iter().map(alone).collect();
        let all = fused(&scans).terrain.faces;
        for name in TOPS {
            let face = top(&world, &[name]);
            let parts = on_face(&all, &face, &world);
            assert!(!parts.is_empty(), "seed {seed}: {name} is missing");
            let names: Vec<_> = parts.iter().map(|part| &part.id).collect();
            assert!(
                one_face(&parts),
                "seed {seed}: {name} is more than one face: {names:?}"
            );
            let (off, rms, area) = against(&parts, whole, &face, &world);
            let single: Vec<(f64, f64)> = (singles.iter())
                .map(|found| {
                    let parts = on_face(found, &face, &world);
                    let (off, _, area) = against(&parts, whole, &face, &world);
                    (area, off)
                })
                .collect();
            let most = single.iter().map(|s| s.0).fold(0.0, f64::max);
            eprintln!(
                "seed {seed}: {name}: {area:.3} m² of {single:.4?}, {:.2} % off, {:.1} mm, {} parts",
                100.0 * off,
                1e3 * rms,
                parts.len()
            );
            assert!(
                area >= 0.99 * most,
                "seed {seed}: {name}: {area} of {single:?} m²"
            );
            // What lies off the face is what single scans put there, and nothing new.
            let put = single.iter().map(|(area, off)| area * off).sum::<f64>();
            assert!(
                off * area <= put + 0.002 * area,
                "seed {seed}: {name}: {off} off, {put} m²"
            );
            // κ z of the nearest view is 0.4 % of 2 m; the farthest corner of the floor is at 5 m.
            assert!(rms < 0.012, "seed {seed}: {name}: {:.1} mm", 1e3 * rms);
        }
        // What three views show of the floor is much more than what one does.
        let face = top(&world, &["floor"]);
        let floor =
            |found: &[Face]| against(&on_face(found, &face, &world), whole, &face, &world).2;
        let most = singles.iter().map(|found| floor(found)).fold(0.0, f64::max);
        assert!(floor(&all) > 1.3 * most);
    }
}

#[test]
fn a_face_keeps_the_name_that_the_first_scan_gave_it() {
    let world = world();
    let scans = scans(&world, 3);
    let first = alone(&scans[0]);
    let all = fused(&scans).terrain.faces;
    for name in TOPS {
        let face = top(&world, &[name]);
        let before = on_face(&first, &face, &world);
        let after = on_face(&all, &face, &world);
        let largest = before[0];
        assert!(
            after.iter().any(|s| s.id == largest.id),
            "{name} was {} and is {:?}",
            largest.id,
            after.iter().map(|s| &s.id).collect::<Vec<_>>()
        );
        // No name of the first scan has gone over to another face.
        for old in &before {
            if let Some(now) = all.iter().find(|s| s.id == old.id) {
                assert!(
                    after.iter().any(|s| s.id == now.id),
                    "{} left {name}",
                    old.id
                );
            }
        }
    }
    // The same from the same scans, on any number of threads.
    let run = |threads: usize| on_threads(threads, || fused(&scans).terrain);
    assert_eq!(run(1), run(3));
}

#[test]
fn what_was_moved_between_two_scans_is_where_the_later_one_saw_it() {
    let at = |x: f64, y: f64| {
        let mut world = world();
        world.push(block("crate", [x, y, 0.2], [0.4, 0.4, 0.4], 0.2, 0.0));
        world
    };
    let (before, after) = (at(1.2, 0.9), at(1.5, -0.75));
    let first = scan(&before, &pose(0.0, 0.0, 0.0), true, 1);
    let second = scan(&after, &pose(0.1, -0.3, 0.2), true, 2);
    let (old, new) = (top(&before, &["crate"]), top(&after, &["crate"]));
    let there = on_face(&alone(&first), &old, &before)[0].id.clone();
    let all = fused(&[first.clone(), second]);
    assert!(on_face(&all.terrain.faces, &old, &before).is_empty());
    assert!(!on_face(&all.terrain.faces, &new, &after).is_empty());
    let told = |change: &&Change| matches!(change, Change::Dropped { id } if *id == there);
    assert!(changes(&all).iter().any(told), "{:?}", changes(&all));
    // Its walls are gone too: nothing upright is left where it stood.
    for face in &all.terrain.faces {
        let p = face.X_WF.translation.vector;
        let near = (p.xy() - Vector3::new(1.2, 0.9, 0.0).xy()).norm() < 0.3;
        assert!(!near || p.z < 0.05, "{} at {p:?}", face.id);
    }
    // Nothing else is taken for moved: the same scan twice refutes nothing.
    let again = scan(&before, &pose(0.1, 0.3, 0.0), true, 3);
    for change in changes(&fused(&[first, again])) {
        assert!(matches!(change, Change::Joined { .. }), "{change:?}");
    }
}

#[test]
fn poses_that_are_off_are_found_again_by_the_planes() {
    // A crate that stands cornerwise shows two sides to all of them.
    let mut world = world();
    world.push(block("crate", [2.0, 1.0, 0.3], [0.6, 0.6, 0.6], 0.8, 0.0));
    for seed in [5, 15, 25] {
        let poses = [
            pose(0.0, 0.0, 0.0),
            pose(0.2, 0.5, -0.3),
            pose(0.1, -0.5, 0.3),
        ];
        let scans = poses
            .iter()
            .zip(seed..)
            .map(|(pose, seed)| scan(&world, pose, true, seed));
        let scans: Vec<Scan> = scans.collect();
        let known = alone(&scans[0]);
        for scan in &scans[1..] {
            let off = Isometry3::new(
                Vector3::new(0.03, -0.02, 0.025),
                Vector3::new(0.01, -0.015, 0.02),
            );
            let X_WV = off * scan.X_WV;
            let (seen, eye_W) = (
                extract(scan, &X_WV, &Config::default()).unwrap(),
                X_WV * Point3::origin(),
            );
            let config = RegistrationConfig::default();
            let found = register(&known, &seen.faces, &eye_W, &config).unwrap();
            let left = found.X_W * off;
            let about = found.about_W;
            let shift = (left * about - about).norm();
            eprintln!(
                "seed {seed}: {} pairs, {:.1} mm and {:.2}° left, misfit {:.2}, {:.1} → {:.1} mm",
                found.pairs.len(),
                1e3 * shift,
                left.rotation.angle().to_degrees(),
                found.misfit,
                1e3 * found.offset_rms_m.0,
                1e3 * found.offset_rms_m.1
            );
            // The error that the covariance admits, χ²₆ at 99.9 %.
            let turn = left.rotation.scaled_axis();
            let moved = left * about - about;
            let error = nalgebra::Vector6::new(turn.x, turn.y, turn.z, moved.x, moved.y, moved.z);
            let square = error.dot(&(found.covariance.try_inverse().unwrap() * error));
            assert!(square < 22.5, "seed {seed}: {square}");
            // 45 mm and 1.5° were put in.
            assert!(shift < 0.015, "seed {seed}: {shift} m left");
            assert!(
                left.rotation.angle() < 0.009,
                "seed {seed}: {}",
                left.rotation.angle()
            );
            assert!(found.offset_rms_m.1 < 0.5 * found.offset_rms_m.0);
        }
    }
}

#[test]
fn clouds_are_fused_as_images_are() {
    let world = world();
    let clouds: Vec<Scan> = scans(&world, 7)[..2].iter().map(unorganised).collect();
    let face = top(&world, &["floor"]);
    for cloud in &clouds {
        assert!(!on_face(&alone(cloud), &face, &world).is_empty());
    }
    let all = fused(&clouds).terrain.faces;
    assert!(one_face(&on_face(&all, &face, &world)));
}
