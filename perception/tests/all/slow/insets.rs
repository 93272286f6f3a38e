//! Where faces may be touched, after the inset: on the physical face, and how much of it.

use crate::support::{
    Block, block, concave, eroded, faces_of, lattice, on_face, pose, scan, stairs, top, touchable,
    unorganised, whole,
};
use nalgebra::Point3;
use perception::{Config, Method};
use surfaces::Face;
use surfaces::outline::Outline;

/// A world, and the names of the blocks whose common top is a face of it.
type Case = (Vec<Block>, Vec<&'static str>);

fn cases() -> Vec<Case> {
    let of_stairs = ["floor", "step1", "step2", "step3", "step4", "table", "ramp"];
    let of_concave: [&[&str]; 4] = [
        &["floor"],
        &["l_long", "l_short"],
        &["u_right", "u_far", "u_left"],
        &["table"],
    ];
    let stairs = of_stairs.iter().map(|name| (stairs(), vec![*name]));
    let concave = of_concave.iter().map(|names| (concave(), names.to_vec()));
    stairs.chain(concave).collect()
}

/// Parts of the area off the face, before and after the inset; and of the true face, eroded by three
/// pixels, in the region, before and after.
#[derive(Debug)]
struct Measured {
    name: &'static str,
    off: [f64; 2],
    cover: [f64; 2],
}

fn measured(
    cases: Vec<Case>,
    method: Method,
    seeds: std::ops::RangeInclusive<u64>,
) -> Vec<Measured> {
    let mut all = Vec::new();
    for (world, names) in cases {
        let face = top(&world, &names);
        let exact = scan(&world, &pose(), false, 0);
        let inner: Vec<_> = (eroded(&exact, &face, &world).into_iter())
            .filter(|(p, _)| {
                (p - Point3::from(pose().translation.vector)).norm() < Config::default().range_max_m
            })
            .collect();
        let inner_m2: f64 = inner.iter().map(|(_, area)| area).sum();
        for seed in seeds.clone() {
            let mut scan = scan(&world, &pose(), true, seed);
            if method != Method::Organised {
                scan = unorganised(&scan);
            }
            let found = faces_of(&scan, method);
            let faces = on_face(&found, &face, &world);
            let parts = [whole, touchable].map(|part| -> Vec<(&Face, Outline)> {
                faces.iter().map(|face| (*face, part(face))).collect()
            });
            let off = parts.each_ref().map(|parts| {
                let of_part = |(face, part): &(&Face, Outline)| lattice(face, part, 0.005);
                let points: Vec<_> = parts.iter().flat_map(of_part).collect();
                let off = points.iter().filter(|p| !face.holds(p, &world)).count();
                off as f64 / points.len().max(1) as f64
            });
            let cover = parts.each_ref().map(|parts| {
                let holds = |p: &Point3<f64>| {
                    let inside = |face: &Face| face.X_WF.inverse_transform_point(p).xy();
                    parts
                        .iter()
                        .any(|(face, part)| part.contains(&inside(face)))
                };
                let covered = inner.iter().filter(|(p, _)| holds(p)).map(|(_, a)| a);
                covered.sum::<f64>() / inner_m2
            });
            all.push(Measured {
                name: names[0],
                off,
                cover,
            });
        }
    }
    all
}

/// Mean and largest part off the face, and the mean coverage: before (0) or after the inset (1).
fn report(method: Method, which: usize, all: &[Measured]) -> ([f64; 2], f64) {
    let mean =
        |pick: &dyn Fn(&Measured) -> f64| all.iter().map(pick).sum::<f64>() / all.len() as f64;
    let (off, cover) = (mean(&|m| m.off[which]), mean(&|m| m.cover[which]));
    let most = all.iter().map(|m| m.off[which]).fold(0.0, f64::max);
    eprintln!(
        "{method:?}, {}: off the face {:.4} % mean, {:.3} % most; covered {cover:.3}",
        ["regions", "after the inset"][which],
        100.0 * off,
        100.0 * most,
    );
    ([off, most], cover)
}

#[test]
fn after_the_inset_nothing_of_an_image_is_off_its_face() {
    let all = measured(cases(), Method::Organised, 1..=8);
    let ([before, ..], _) = report(Method::Organised, 0, &all);
    let ([mean, most], cover) = report(Method::Organised, 1, &all);
    // A twentieth of a percent is asked for, and a percent of one face; and most of what is three pixels inside.
    assert!(mean < 5e-4 && most < 1e-2, "{mean}, {most} off");
    assert!(mean < 0.5 * before, "{mean} of {before}");
    assert!(cover >= 0.9, "{cover}");
    // No face is lost.
    for m in &all {
        let [before, after] = m.cover;
        assert!(
            after > 0.7 && after > before - 0.15,
            "{}: {before} to {after}",
            m.name
        );
    }
}

/// The last pixels of a post are within the noise of the floor's plane.
#[test]
fn where_posts_stand_on_a_floor_it_is_not_touched() {
    let mut world: Vec<Block> = (stairs().into_iter())
        .filter(|block| ["floor", "wall"].contains(&block.name))
        .collect();
    for (x, y) in [
        (2.4, 0.0),
        (2.8, -0.7),
        (2.8, 0.7),
        (3.2, -0.3),
        (3.2, 0.4),
        (3.6, 0.0),
    ] {
        world.push(block("post", [x, y, 0.25], [0.06, 0.06, 0.5], 0.1, 0.0));
    }
    let all = measured(vec![(world, vec!["floor"])], Method::Organised, 1..=8);
    let ([mean, most], cover) = report(Method::Organised, 1, &all);
    assert!(mean < 2e-5 && most < 1e-4, "{mean}, {most} off");
    assert!(cover >= 0.7, "{cover}");
}

#[test]
fn the_inset_of_a_cloud_takes_most_of_what_is_off_its_face() {
    let all = measured(cases(), Method::Voxels, 1..=2);
    let (before, _) = report(Method::Voxels, 0, &all);
    let (after, cover) = report(Method::Voxels, 1, &all);
    assert!(after[0] < 0.3 * before[0], "{after:?} of {before:?}");
    assert!(cover >= 0.8, "{cover}");
}
