//! How much of faces of all shapes is covered, and how little else: an L, a U, a ring and a ramp.

use crate::support::{Block, block, eroded, floor, lattice, on_face, pose, scan, top, touchable};
use nalgebra::Point3;
use perception::{Config, extract};

/// The floor and the wall of every scene.
fn room() -> Vec<Block> {
    vec![
        floor(),
        block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
    ]
}

/// A scene and the names of the blocks whose common top is the face.
fn scenes() -> Vec<(&'static str, Vec<Block>, Vec<&'static str>)> {
    let with = |blocks: Vec<Block>| [room(), blocks].concat();
    vec![
        (
            "L",
            with(vec![
                block("long", [1.6, 0.3, 0.1], [0.9, 0.35, 0.2], 0.0, 0.0),
                block("short", [1.875, -0.075, 0.1], [0.35, 0.4, 0.2], 0.0, 0.0),
            ]),
            vec!["long", "short"],
        ),
        (
            "U",
            with(vec![
                block("right", [1.6, -0.45, 0.15], [0.9, 0.3, 0.3], 0.0, 0.0),
                block("far", [1.9, -0.05, 0.15], [0.3, 0.5, 0.3], 0.0, 0.0),
                block("left", [1.6, 0.35, 0.15], [0.9, 0.3, 0.3], 0.0, 0.0),
            ]),
            vec!["right", "far", "left"],
        ),
        (
            "ring",
            with(vec![
                block("near", [1.3, 0.0, 0.1], [0.3, 1.1, 0.2], 0.0, 0.0),
                block("far", [2.1, 0.0, 0.1], [0.3, 1.1, 0.2], 0.0, 0.0),
                block("left", [1.7, 0.4, 0.1], [0.5, 0.3, 0.2], 0.0, 0.0),
                block("right", [1.7, -0.4, 0.1], [0.5, 0.3, 0.2], 0.0, 0.0),
            ]),
            vec!["near", "far", "left", "right"],
        ),
        (
            "ramp",
            with(vec![block(
                "ramp",
                [1.9, 0.1, 0.105],
                [1.2, 0.8, 0.04],
                0.1,
                -0.21,
            )]),
            vec!["ramp"],
        ),
    ]
}

#[test]
fn l_u_ring_and_ramp_are_covered_and_air_is_not() {
    for (name, world, blocks) in scenes() {
        let face = top(&world, &blocks);
        let inner = eroded(&scan(&world, &pose(), false, 0), &face, &world);
        let whole: f64 = inner.iter().map(|(_, area)| area).sum();
        let mut ratios = Vec::new();
        for seed in 1..=3 {
            let scan = scan(&world, &pose(), true, seed);
            let found = extract(&scan, &scan.X_WV, &Config::default())
                .unwrap()
                .faces;
            let on_face = on_face(&found, &face, &world);
            let parts: Vec<_> = on_face
                .iter()
                .map(|face| (*face, touchable(face)))
                .collect();
            let holds = |p: &Point3<f64>| {
                let inside = |face: &surfaces::Face| face.X_WF.inverse_transform_point(p).xy();
                parts
                    .iter()
                    .any(|(face, part)| part.contains(&inside(face)))
            };
            let covered: f64 = inner.iter().filter(|(p, _)| holds(p)).map(|(_, a)| a).sum();
            let points = parts
                .iter()
                .flat_map(|(face, part)| lattice(face, part, 0.005));
            let points: Vec<_> = points.collect();
            let off = points.iter().filter(|p| !face.holds(p, &world)).count();
            let off = off as f64 / points.len().max(1) as f64;
            let ratio = covered / whole;
            assert!(ratio > 0.8, "{name}, seed {seed}: {ratio} covered");
            assert!(off < 0.01, "{name}, seed {seed}: {off} off the face");
            ratios.push(ratio);
        }
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!(mean > 0.85, "{name}: {ratios:?} covered");
    }
}
