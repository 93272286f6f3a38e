//! What ends a face at each edge of its outline, against the boxes that were seen.

use std::collections::BTreeMap;

use crate::support::{Block, Face, block, faces_of, floor, lies_on, pose, scan, unorganised};
use nalgebra::{Point3, Vector3};
use perception::{Config, Method, Scan};
use surfaces::EdgeKind;

/// Boxes that stand before each other, on a floor before a wall; some leave the image.
fn world() -> Vec<Block> {
    vec![
        floor(),
        block("wall", [4.35, 0.0, 1.5], [0.1, 12.0, 3.0], 0.0, 0.0),
        block("low", [1.35, 0.05, 0.075], [0.34, 0.9, 0.15], 0.1, 0.0),
        block("behind", [1.95, 0.2, 0.15], [0.36, 0.7, 0.30], -0.07, 0.0),
        block("table", [2.90, -0.1, 0.695], [0.80, 1.20, 0.03], 0.02, 0.0),
        block("on_table", [2.75, 0.1, 0.81], [0.2, 0.3, 0.2], 0.3, 0.0),
        block("ramp", [1.9, -1.0, 0.105], [1.2, 0.8, 0.04], 0.0, -0.21),
        block("cut", [2.2, 1.25, 0.25], [0.5, 0.9, 0.5], 0.2, 0.0),
    ]
}

/// The faces of all boxes; those in one plane are one.
fn faces(world: &[Block]) -> Vec<Face<'_>> {
    let mut faces: Vec<Face> = Vec::new();
    for block in world {
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let new = Face {
                blocks: vec![block],
                axis,
                sign,
            };
            let mut corner = block.half;
            corner[axis] *= sign;
            let at = block.pose * Point3::from(corner);
            let same = |f: &&mut Face| {
                f.normal_W().dot(&new.normal_W()) > 1.0 - 1e-9 && f.height(&at).abs() < 1e-6
            };
            match faces.iter_mut().find(same) {
                Some(face) => face.blocks.push(block),
                None => faces.push(new),
            }
        }
    }
    faces
}

/// What ends the true face beyond a point of its outline: the first of its own end, what stands on it, the border of
/// the image or of the range, and something nearer, in steps of 2 mm from 10 mm inside on. `None` where
/// it goes on for 0.4 m: a notch of the outline, whose sides look at the face itself.
fn truth(
    from: &Point3<f64>,
    out: &Vector3<f64>,
    face: &Face,
    world: &[Block],
    exact: &Scan,
) -> Option<EdgeKind> {
    let depth = exact.depth.as_ref().unwrap();
    let k = depth.intrinsics;
    (-5..200).find_map(|i| {
        let q = from + out * (0.002 * f64::from(i));
        let q = q - face.normal_W() * face.height(&q);
        if face.is_covered(&q, world) {
            return Some(EdgeKind::Fold);
        }
        if !face.holds(&q, world) {
            return Some(EdgeKind::Real);
        }
        let q_V = exact.X_WV.inverse_transform_point(&q);
        let u = (k.fx * q_V.x / q_V.z + k.cx).round();
        let v = (k.fy * q_V.y / q_V.z + k.cy).round();
        if q_V.coords.norm() > Config::default().range_max_m {
            return Some(EdgeKind::FieldOfView);
        }
        let inside =
            (0.0..depth.width as f64).contains(&u) && (0.0..depth.height as f64).contains(&v);
        if !inside {
            return Some(EdgeKind::FieldOfView);
        }
        let z = f64::from(depth.z_m[v as usize * depth.width + u as usize]);
        (z > 0.0 && z < 0.985 * q_V.z - 0.005).then_some(EdgeKind::Occluded)
    })
}

/// Length of outline by true kind (`none` in notches) and found one, m.
type Lengths = BTreeMap<(String, String), f64>;

fn compare(found: &[surfaces::Face], world: &[Block], exact: &Scan) -> Lengths {
    let faces = faces(world);
    let mut lengths = Lengths::new();
    for of in found {
        let Some(face) = faces.iter().find(|face| lies_on(of, face, world)) else {
            continue;
        };
        // The face is on the left of all its edges.
        for (edge, [a, b]) in of.region.segments() {
            let along = b - a;
            let out = of.X_WF * Vector3::new(along.y, -along.x, 0.0).normalize();
            let places = (along.norm() / 0.02).ceil().max(1.0);
            for i in 0..places as usize {
                let p = of.point_W(&(a + along * ((i as f64 + 0.5) / places)));
                let is = truth(&p, &out, face, world, exact);
                let is = is.map_or("none".to_owned(), |kind| format!("{kind:?}"));
                let length = lengths.entry((is, format!("{:?}", edge.kind)));
                *length.or_default() += along.norm() / places;
            }
        }
    }
    lengths
}

/// The part of the length that is rightly labelled, of all whose truth is known and of each kind.
fn right(lengths: &Lengths) -> (f64, BTreeMap<String, (f64, f64)>) {
    let mut of_kind: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for ((is, named), length) in lengths.iter().filter(|((is, _), _)| is != "none") {
        let entry = of_kind.entry(is.clone()).or_default();
        entry.1 += length;
        // Where something rises the face ends, too; the other way round nothing falls.
        let same = is == named || (is == "Fold" && named == "Real");
        entry.0 += if same { *length } else { 0.0 };
    }
    let sum = |pick: fn(&(f64, f64)) -> f64| of_kind.values().map(pick).sum::<f64>();
    (sum(|l| l.0) / sum(|l| l.1), of_kind)
}

/// The same over three frames; `notches_max` bounds the part of the length in notches.
fn measured(method: Method, cloud: bool, notches_max: f64) -> (f64, BTreeMap<String, (f64, f64)>) {
    let world = world();
    let exact = scan(&world, &pose(), false, 0);
    let mut all = Lengths::new();
    for seed in 1..=3 {
        let mut scan = scan(&world, &pose(), true, seed);
        if cloud {
            scan = unorganised(&scan);
        }
        for (key, length) in compare(&faces_of(&scan, method), &world, &exact) {
            *all.entry(key).or_default() += length;
        }
    }
    let (share, of_kind) = right(&all);
    eprintln!("{method:?}: {share:.3} of the length; m by (truth, found): {all:.1?}");
    let none: f64 = (all.iter().filter(|((is, _), _)| is == "none"))
        .map(|(_, length)| length)
        .sum();
    assert!(
        none < notches_max * all.values().sum::<f64>(),
        "{none} m of notches"
    );
    (share, of_kind)
}

#[test]
fn edges_of_images_are_real_occluded_or_cut_by_the_view_where_they_are_so() {
    let (share, of_kind) = measured(Method::Organised, false, 0.05);
    assert!(share > 0.95, "{share}");
    for kind in ["Real", "Fold", "Occluded", "FieldOfView"] {
        let (right, whole) = of_kind[kind];
        assert!(right > 0.9 * whole, "{kind}: {right} of {whole} m");
    }
}

#[test]
fn edges_of_bare_clouds_are_told_by_the_directions_of_the_points() {
    // Outlines of cells have jags.
    let (share, of_kind) = measured(Method::Voxels, true, 0.15);
    assert!(share > 0.9, "{share}");
    for kind in ["Real", "Occluded", "FieldOfView"] {
        let (right, whole) = of_kind[kind];
        assert!(right > 0.8 * whole, "{kind}: {right} of {whole} m");
    }
    let (share, _) = measured(Method::Brossette2013, true, 0.15);
    assert!(share > 0.8, "{share}");
}
