//! Everything that is done to scans, in one call.

use nalgebra::{Isometry3, Vector3};
use perception::{Config, Notice, Perception, PosedScan, Scan, perceive};

use crate::support::{Block, pose, scan, stairs, unorganised};

fn posed(scan: &Scan) -> PosedScan<'_> {
    PosedScan::Scan {
        name: "stairs",
        scan,
        X_WV: scan.X_WV,
    }
}

/// Whether a face lies on the top of a block, which it sees half of at least.
fn is_top(face: &surfaces::Face, block: &Block) -> bool {
    let centre = face.point_W(&face.region.centroid());
    let X_BW = block.pose.inverse();
    let p_B = X_BW * centre;
    let level = (X_BW.rotation * face.normal_W()).z > 0.99;
    level
        && (p_B.z - block.half.z).abs() < 0.03
        && p_B.x.abs() < block.half.x
        && p_B.y.abs() < block.half.y
}

fn each_step_is_one_face(world: &[Block], found: &Perception) {
    for block in world.iter().filter(|b| b.name.starts_with("step")) {
        let faces = found.terrain.faces.iter();
        let on_top = faces.filter(|face| is_top(face, block));
        assert_eq!(on_top.count(), 1, "{}", block.name);
    }
}

#[test]
fn every_tread_is_one_face_by_image_and_by_voxels() {
    let world = stairs();
    let image = scan(&world, &pose(), true, 1);
    for scan in [unorganised(&image), image] {
        let found = perceive(&[posed(&scan)], &Config::default()).unwrap();
        found.terrain.validate().unwrap();
        each_step_is_one_face(&world, &found);
        let points = posed(&scan).points_W(&found.moved_W[0], 1).count();
        assert_eq!(points, scan.cloud.finite().count());
        assert!(matches!(&found.notices[..], [Notice::Extracted { .. }]));
        assert!(found.notices[0].to_string().starts_with("stairs: "));
    }
}

#[test]
fn a_second_scan_adds_nothing_to_what_it_shows_again() {
    let world = stairs();
    let first = scan(&world, &pose(), true, 1);
    let beside = Isometry3::new(Vector3::new(0.0, 0.15, 0.0), Vector3::z() * -0.05);
    let second = scan(&world, &(beside * pose()), true, 2);
    let scans = [posed(&first), posed(&second)];
    let found = perceive(&scans, &Config::default()).unwrap();
    found.terrain.validate().unwrap();
    let joined = |notice: &Notice| matches!(notice, Notice::Fused(_));
    assert!(found.notices.iter().any(joined));
    each_step_is_one_face(&world, &found);
}

/// Half of the pixels missing are no reason to leave the image; nine of ten are.
#[test]
fn an_image_full_of_holes_is_taken_as_a_cloud_and_said_to_be() {
    let world = stairs();
    for (missing, is_cloud) in [(0.5, false), (0.9, true)] {
        let mut image = scan(&world, &pose(), true, 1);
        let depth = image.depth.as_mut().unwrap();
        for (i, z) in depth.z_m.iter_mut().enumerate() {
            // A low-discrepancy sequence: as good as random to a grid of cells.
            if (i as f64 * 0.618_034).fract() < missing {
                *z = 0.0;
            }
        }
        image.cloud = depth.to_cloud();
        let found = perceive(&[posed(&image)], &Config::default()).unwrap();
        let sparse = |notice: &Notice| matches!(notice, Notice::Sparse { .. });
        assert_eq!(found.notices.iter().any(sparse), is_cloud);
        each_step_is_one_face(&world, &found);
    }
}
