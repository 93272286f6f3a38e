//! Real scans, where the folder that holds them is present.

use nalgebra::{Isometry3, Point3, Vector3};
use perception::{
    Config, Intrinsics, Method, Scan, Segmentation, SensorOptions, extract, read_scan,
};

use crate::support::{by, faces_of, shared};
use surfaces::Face;

fn options(sensor: &str, k: Option<[f64; 4]>) -> SensorOptions {
    let intrinsics = k.map(|[fx, fy, cx, cy]| Intrinsics { fx, fy, cx, cy });
    SensorOptions {
        sensor: sensor.into(),
        intrinsics,
        ..SensorOptions::default()
    }
}

/// A scan where it is there, with the intrinsics of its sensor.
fn read(name: &str, sensor: &str, k: Option<[f64; 4]>) -> Option<Scan> {
    let path = shared(name)?;
    Some(read_scan(&path, &options(sensor, k)).unwrap())
}

fn angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.angle(b).to_degrees()
}

/// The Kinect v2's view down a real staircase.
const K2: [f64; 4] = [
    365.3177869756812,
    365.3172134080492,
    254.6860958294042,
    208.54985928324885,
];

/// Up, in V: the first axis of the scan's own levelling by its IMU looks down.
const K2_UP: Vector3<f64> = Vector3::new(-0.0683299, -0.2251696, -0.9719206);

#[test]
fn the_treads_of_real_stairs_are_parallel_and_a_step_apart() {
    let Some(scan) = read(STAIRS, "kinect_v2", Some(K2)) else {
        return;
    };
    let found = faces_of(&scan, Method::Auto);
    let level: Vec<&Face> = found
        .iter()
        .filter(|s| angle_deg(&s.normal_W(), &K2_UP) < 4.0 && s.region.area() > 0.05)
        .collect();
    let treads = level.len();
    assert!(treads >= 3, "{treads} level faces of {}", found.len());
    // The two treads and the floor before them.
    for (a, b) in level.iter().flat_map(|a| level.iter().map(move |b| (a, b))) {
        let angle = angle_deg(&a.normal_W(), &b.normal_W());
        assert!(angle < 1.0, "{} and {}: {angle}°", a.id, b.id);
    }
    // Levels of the treads along the common normal, without repeats: risers of 7 to 20 cm.
    let mut heights: Vec<f64> = level
        .iter()
        .map(|s| K2_UP.dot(&s.X_WF.translation.vector))
        .collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < 0.05);
    assert!(heights.len() >= 3, "{heights:?}");
    for pair in heights.windows(2).take(2) {
        assert!((0.06..0.21).contains(&(pair[1] - pair[0])), "{heights:?}");
    }
}

const STAIRS: &str = "rgbd/k2_stairs_0000_depth.png";
const OTHER_STAIRS: &str = "rgbd/k2_stairs_0001_depth.png";

/// A face of a real scan: the scan, the face, the part of the pixels inside its outline, picked by hand, that lies in
/// what may be stepped on of faces along a plane fitted to nothing but them, and that outline, px.
type Picked = (&'static str, &'static str, f64, &'static [[u16; 2]]);

/// The Kinect v2's two staircases. The treads of the second one are 33, 15 and 7 px high where they are farthest.
#[rustfmt::skip]
const PICKED: [Picked; 7] = [
    (STAIRS, "tread 1", 0.9, &[[222, 166], [390, 173], [391, 280], [232, 277]]),
    (STAIRS, "tread 2", 0.9, &[[66, 49], [398, 48], [398, 152], [50, 146]]),
    (OTHER_STAIRS, "floor", 0.85, &[[0, 350], [250, 352], [372, 362], [374, 423], [0, 423]]),
    (OTHER_STAIRS, "tread 1", 0.9, &[[52, 241], [357, 245], [378, 317], [0, 301], [0, 275]]),
    (OTHER_STAIRS, "tread 2", 0.75, &[[95, 171], [349, 171], [360, 203], [43, 203]]),
    (OTHER_STAIRS, "tread 3", 0.65, &[[127, 123], [345, 119], [350, 134], [90, 139]]),
    (OTHER_STAIRS, "tread 4", 0.4, &[[151, 87], [336, 82], [342, 89], [124, 94]]),
];

#[test]
fn treads_of_real_stairs_can_be_stood_on() {
    for file in [STAIRS, OTHER_STAIRS] {
        let Some(scan) = read(file, "kinect_v2", Some(K2)) else {
            return;
        };
        let depth = scan.depth.as_ref().unwrap();
        let k = depth.intrinsics;
        let faces = faces_of(&scan, Method::Organised);
        for (_, name, least, corners) in PICKED.iter().filter(|picked| picked.0 == file) {
            let corners: Vec<[f64; 2]> = corners.iter().map(|c| c.map(f64::from)).collect();
            let inside = |u: f64, v: f64| {
                let next = corners.iter().cycle().skip(1);
                let crosses = corners.iter().zip(next).filter(|([x1, y1], [x2, y2])| {
                    (*y1 > v) != (*y2 > v) && u < (x2 - x1) * (v - y1) / (y2 - y1) + x1
                });
                crosses.count() % 2 == 1
            };
            let rays = depth.z_m.iter().enumerate().filter_map(|(i, z)| {
                let (u, v) = ((i % depth.width) as f64, (i / depth.width) as f64);
                let ray = Vector3::new((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
                (*z > 0.0 && inside(u, v)).then_some((ray, f64::from(*z)))
            });
            let rays: Vec<_> = rays.collect();
            let count = rays.len() as f64;
            let points = || rays.iter().map(|(ray, z)| ray * *z);
            let middle = points().sum::<Vector3<f64>>() / count;
            let spread: nalgebra::Matrix3<f64> = points()
                .map(|p| (p - middle) * (p - middle).transpose())
                .sum();
            let fit = spread.symmetric_eigen();
            let normal: Vector3<f64> = fit.eigenvectors.column(fit.eigenvalues.imin()).into();
            let along = |face: &&Face| {
                let (n, at) = (face.normal_W(), face.X_WF.translation.vector);
                let off = points().map(|p| n.dot(&(p - at)).abs()).sum::<f64>() / count;
                n.dot(&normal).abs() > 4_f64.to_radians().cos() && off < 0.012
            };
            let parts: Vec<_> = faces
                .iter()
                .filter(along)
                .map(|face| (face, face.inset_region(2.0, 0.0).regions()))
                .collect();
            let is_covered = |(ray, _): &&(Vector3<f64>, f64)| {
                parts.iter().any(|(face, parts)| {
                    let n = face.normal_W();
                    let on = ray * (n.dot(&face.X_WF.translation.vector) / n.dot(ray));
                    let p = face.X_WF.inverse_transform_point(&Point3::from(on)).xy();
                    parts.iter().any(|part| part.contains(&p))
                })
            };
            let share = rays.iter().filter(is_covered).count() as f64 / count;
            let rms_mm = 1e3 * (fit.eigenvalues.min() / count).sqrt();
            eprintln!("{file} {name}: {rms_mm:.1} mm off its own plane, {share:.2} to step on");
            assert!(share >= *least, "{file} {name}: {share}");
        }
    }
}

/// Heights, m, of the planes on both sides of every riser down one column of the image: where the
/// level faces that the column passes end and begin.
fn rises(scan: &Scan, found: &Segmentation, up: &Vector3<f64>, column: usize) -> Vec<f64> {
    let depth = scan.depth.as_ref().unwrap();
    let k = depth.intrinsics;
    let plane = |label: u16| found.planes_V.get(usize::from(label)).copied().flatten();
    // The third tread is cut by the image to 17 rows, and leans by more than the others.
    let level = |label: u16| {
        plane(label).is_some_and(|(n, _)| angle_deg(&n, up) < 7.0)
            && found.labels.iter().filter(|l| **l == label).count() > 4000
    };
    let height = |label: u16, row: usize| {
        let (n, d) = plane(label).unwrap();
        let ray = Vector3::new(
            (column as f64 - k.cx) / k.fx,
            (row as f64 - k.cy) / k.fy,
            1.0,
        );
        up.dot(&(ray * (-d / n.dot(&ray))))
    };
    let mut faces: Vec<(u16, usize, usize)> = Vec::new();
    for row in 0..found.height {
        let label = found.labels[row * found.width + column];
        match faces.last_mut() {
            Some((last, _, end)) if *last == label => *end = row,
            _ if level(label) => faces.push((label, row, row)),
            _ => {}
        }
    }
    let pairs = faces.windows(2);
    pairs
        .map(|p| height(p[0].0, p[0].2) - height(p[1].0, p[1].1))
        .collect()
}

#[test]
fn the_risers_of_real_stairs_are_as_high_as_the_depth_says() {
    let Some(scan) = read(STAIRS, "kinect_v2", Some(K2)) else {
        return;
    };
    let found = extract(&scan, &scan.X_WV, &Config::default()).unwrap();
    let treads = found.faces.iter().filter(|s| s.region.area() > 0.05);
    let level = treads.filter(|s| angle_deg(&s.normal_W(), &K2_UP) < 4.0);
    let up: Vector3<f64> = level.map(Face::normal_W).sum::<Vector3<f64>>().normalize();
    let segmentation = found.segmentation.as_ref().unwrap();
    // Without any plane: medians of 40 × 20 pixels above and below each riser, of the depths along
    // the treads' normal, give 0.105, 0.101 and 0.080 m. The lowest step is lower, in the stairs.
    for column in [200, 230, 260, 290, 320] {
        let rises = rises(&scan, segmentation, &up, column);
        eprintln!("column {column}: {rises:.4?}");
        for (rise, measured) in rises.iter().zip([0.105, 0.101, 0.080]) {
            assert!(
                (rise - measured).abs() < 0.005,
                "column {column}: {rises:?}"
            );
        }
        assert_eq!(rises.len(), 3);
        assert!((rises[0] - rises[1]).abs() < 0.005, "{rises:?}");
    }
}

#[test]
fn the_levelled_cloud_of_the_same_stairs_takes_voxels_and_agrees() {
    let Some(scan) = read("rgbd/k2_stairs_0000.pcd", "kinect_v2", None) else {
        return;
    };
    // Organised, but turned to level after the scan: no pinhole explains it.
    assert_eq!(scan.cloud.organised, Some((512, 424)));
    assert!(scan.depth.is_none());
    let found = faces_of(&scan, Method::Auto);
    let level = found
        .iter()
        .filter(|s| s.normal_W().x.abs() > 4.0_f64.to_radians().cos());
    let area: f64 = level.map(|s| s.region.area()).sum();
    assert!(area > 0.3, "{area} m² level");
}

#[test]
fn a_wall_and_shelves_come_out_as_such() {
    let k = [572.9, 542.7, 314.6, 240.2];
    let Some(scan) = read("rgbd/mrpt_kinect_depth.png", "kinect_v1", Some(k)) else {
        return;
    };
    let found = faces_of(&scan, Method::Auto);
    // The wall is the largest, 2.3 m away, and upright; it was measured to 16 mm.
    let wall = &found[0];
    assert!(wall.normal_W().y.abs() < 0.2, "{:?}", wall.normal_W());
    assert!((2.0..2.6).contains(&wall.X_WF.translation.vector.z));
    assert!(wall.fit.unwrap().rms_m < 0.025, "{:?}", wall.fit);
}

#[test]
fn a_floor_is_one_plane_for_the_stereo_camera() {
    let k = [
        307.8533935546875,
        307.8641357421875,
        204.47328186035156,
        121.65782165527344,
    ];
    let Some(scan) = read(
        "rgbd/rs_polylidar_00000002_depth.png",
        "realsense_d4xx",
        Some(k),
    ) else {
        return;
    };
    let found = faces_of(&scan, Method::Auto);
    // Level with the camera but for its tilt: the normal is mostly −y.
    let floor: f64 = found
        .iter()
        .filter(|s| s.normal_W().y < -0.75)
        .map(|s| s.region.area())
        .fold(0.0, f64::max);
    assert!(floor > 0.3, "{floor} m²");
}

#[test]
fn no_face_of_a_curved_tunnel_strays_far_from_its_plane() {
    let k = Some([575.9, 576.4, 315.15, 230.6]);
    let Some(scan) = read("rgbd/cape_seq_example_depth.png", "kinect_v1", k) else {
        return;
    };
    let found = faces_of(&scan, Method::Auto);
    assert!(!found.is_empty());
    let depth = scan.depth.as_ref().unwrap();
    let k = depth.intrinsics;
    for face in &found {
        // Mean heights of the points over blocks of 8 × 8 px, which average the noise; by block.
        let mut blocks = std::collections::BTreeMap::<(usize, usize), (f64, f64, f64)>::new();
        for (i, &z) in depth.z_m.iter().enumerate().filter(|(_, z)| **z > 0.0) {
            let (u, v) = (i % depth.width, i / depth.width);
            let ray = Vector3::new((u as f64 - k.cx) / k.fx, (v as f64 - k.cy) / k.fy, 1.0);
            let n = face.normal_W();
            let on_plane = n.dot(&face.X_WF.translation.vector) / n.dot(&ray);
            let foot = face
                .X_WF
                .inverse_transform_point(&Point3::from(ray * on_plane));
            if on_plane > 0.0 && face.region.contains(&foot.xy()) {
                let (sum, deep, count) = blocks.entry((u / 8, v / 8)).or_default();
                *sum += f64::from(z) - on_plane;
                *deep += on_plane;
                *count += 1.0;
            }
        }
        // What the noise model lets an error of the sensor be: four times its slow part, and three
        // times what is left of the fast part over the 64 px of a block.
        let alike = 4.0 * std::f64::consts::PI * scan.noise.correlation_px.powi(2);
        for ((u, v), (sum, deep, count)) in blocks.into_iter().filter(|(_, b)| b.2 >= 32.0) {
            let (off, z) = (sum / count, deep / count);
            let slow = 4.0 * scan.noise.systematic_ratio * z;
            let fast = 3.0 * scan.noise.sigma_z_m(z) * (alike / count).min(1.0).sqrt();
            let most = slow.hypot(fast);
            assert!(
                off.abs() < most,
                "{}: {off} m off at block ({u}, {v}), {z} m",
                face.id
            );
        }
    }
}

#[test]
fn lidar_clouds_of_tilted_blocks_show_the_blocks() {
    let steps = "lidar/planeseg_tilted-steps.pcd";
    let terrain = "lidar/planeseg_terrain_close_rect.pcd";
    let (over_steps, over_terrain) = ([0.248, 0.012, 1.806], [-0.029, -0.006, 0.088]);
    for (name, eye_m, method, least) in [
        (steps, over_steps, Method::Brossette2013, 3),
        (steps, over_steps, Method::Voxels, 5),
        (terrain, over_terrain, Method::Brossette2013, 8),
        (terrain, over_terrain, Method::Voxels, 9),
    ] {
        let Some(path) = shared(name) else { return };
        let options = SensorOptions {
            eye_m: Some(eye_m),
            ..options("generic", None)
        };
        let scan = read_scan(&path, &options).unwrap();
        assert_eq!(scan.X_WV, Isometry3::identity());
        let found = faces_of(&scan, method);
        // Blocks of 40 × 40 cm in all directions: tilted, yet walkable. Far ones are too sparse,
        // and some grow into one region with a neighbour.
        let tilts = found.iter().filter(|s| {
            let tilt = angle_deg(&s.normal_W(), &Vector3::z());
            (5.0..30.0).contains(&tilt) && (0.03..0.4).contains(&s.region.area())
        });
        let (count, all) = (tilts.count(), found.len());
        assert!(
            count >= least,
            "{name}, {method:?}: {count} tilted blocks of {all} faces"
        );
    }
}

#[test]
fn a_sparse_lidar_turn_is_read_and_its_walls_are_found() {
    let Some(scan) = read(
        "lidar/nebula_vlp16_1673400472138016708.pcd",
        "generic",
        None,
    ) else {
        return;
    };
    assert_eq!(scan.cloud.points.len() + scan.cloud.invalid, 14831);
    faces_of(&scan, Method::Brossette2013);
    // Rings on the walls around, decimetres apart; on the floor they are too far apart for voxels.
    let config = Config {
        range_max_m: 15.0,
        ..by(Method::Voxels)
    };
    let found = extract(&scan, &scan.X_WV, &config).unwrap().faces;
    let walls = found.iter().filter(|s| s.normal_W().z.abs() < 0.2);
    let area: f64 = walls.map(|s| s.region.area()).sum();
    assert!(area > 2.0, "{area} m² of walls");
}
