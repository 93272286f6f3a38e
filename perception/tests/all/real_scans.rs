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
    let Some(path) = shared("rgbd/k2_stairs_0000_depth.png") else {
        return;
    };
    let scan = read_scan(&path, &options("kinect_v2", Some(K2))).unwrap();
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

/// A face of a real scan: pixels inside its outline, picked by hand, and the part of them that lies in what may be
/// stepped on of faces along a plane fitted to nothing but them.
struct Picked {
    name: &'static str,
    corners: &'static [(f64, f64)],
    least: f64,
}

/// The Kinect v2's two staircases. The treads of the second one are 33, 15 and 7 px high where they are farthest.
const PICKED: [(&str, &[Picked]); 2] = [
    (
        "rgbd/k2_stairs_0000_depth.png",
        &[
            Picked {
                name: "tread 1",
                corners: &[
                    (222.0, 166.0),
                    (390.0, 173.0),
                    (391.0, 280.0),
                    (232.0, 277.0),
                ],
                least: 0.9,
            },
            Picked {
                name: "tread 2",
                corners: &[(66.0, 49.0), (398.0, 48.0), (398.0, 152.0), (50.0, 146.0)],
                least: 0.9,
            },
        ],
    ),
    (
        "rgbd/k2_stairs_0001_depth.png",
        &[
            Picked {
                name: "floor",
                corners: &[
                    (0.0, 350.0),
                    (250.0, 352.0),
                    (372.0, 362.0),
                    (374.0, 423.0),
                    (0.0, 423.0),
                ],
                least: 0.85,
            },
            Picked {
                name: "tread 1",
                corners: &[
                    (52.0, 241.0),
                    (357.0, 245.0),
                    (378.0, 317.0),
                    (0.0, 301.0),
                    (0.0, 275.0),
                ],
                least: 0.9,
            },
            Picked {
                name: "tread 2",
                corners: &[(95.0, 171.0), (349.0, 171.0), (360.0, 203.0), (43.0, 203.0)],
                least: 0.75,
            },
            Picked {
                name: "tread 3",
                corners: &[
                    (127.0, 123.0),
                    (345.0, 119.0),
                    (350.0, 134.0),
                    (90.0, 139.0),
                ],
                least: 0.65,
            },
            Picked {
                name: "tread 4",
                corners: &[(151.0, 87.0), (336.0, 82.0), (342.0, 89.0), (124.0, 94.0)],
                least: 0.4,
            },
        ],
    ),
];

#[test]
fn treads_of_real_stairs_can_be_stood_on() {
    for (file, picked) in PICKED {
        let Some(path) = shared(file) else { return };
        let scan = read_scan(&path, &options("kinect_v2", Some(K2))).unwrap();
        let depth = scan.depth.as_ref().unwrap();
        let k = depth.intrinsics;
        let faces = faces_of(&scan, Method::Organised);
        for Picked {
            name,
            corners,
            least,
        } in picked
        {
            let inside = |u: f64, v: f64| {
                let next = corners.iter().cycle().skip(1);
                let crosses = corners.iter().zip(next).filter(|((x1, y1), (x2, y2))| {
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
    let Some(path) = shared("rgbd/k2_stairs_0000_depth.png") else {
        return;
    };
    let scan = read_scan(&path, &options("kinect_v2", Some(K2))).unwrap();
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
    let Some(path) = shared("rgbd/k2_stairs_0000.pcd") else {
        return;
    };
    let scan = read_scan(&path, &options("kinect_v2", None)).unwrap();
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
    let Some(path) = shared("rgbd/mrpt_kinect_depth.png") else {
        return;
    };
    let k = [572.9, 542.7, 314.6, 240.2];
    let found = faces_of(
        &read_scan(&path, &options("kinect_v1", Some(k))).unwrap(),
        Method::Auto,
    );
    // The wall is the largest, 2.3 m away, and upright; it was measured to 16 mm.
    let wall = &found[0];
    assert!(wall.normal_W().y.abs() < 0.2, "{:?}", wall.normal_W());
    assert!((2.0..2.6).contains(&wall.X_WF.translation.vector.z));
    assert!(wall.fit.unwrap().rms_m < 0.025, "{:?}", wall.fit);
}

#[test]
fn a_floor_is_one_plane_for_the_stereo_camera() {
    let Some(path) = shared("rgbd/rs_polylidar_00000002_depth.png") else {
        return;
    };
    let k = [
        307.8533935546875,
        307.8641357421875,
        204.47328186035156,
        121.65782165527344,
    ];
    let found = faces_of(
        &read_scan(&path, &options("realsense_d4xx", Some(k))).unwrap(),
        Method::Auto,
    );
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
    let Some(path) = shared("rgbd/cape_seq_example_depth.png") else {
        return;
    };
    let k = [575.9, 576.4, 315.15, 230.6];
    let scan = read_scan(&path, &options("kinect_v1", Some(k))).unwrap();
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
    for (name, eye_m, method, least) in [
        (
            "lidar/planeseg_tilted-steps.pcd",
            [0.248, 0.012, 1.806],
            Method::Brossette2013,
            3,
        ),
        (
            "lidar/planeseg_tilted-steps.pcd",
            [0.248, 0.012, 1.806],
            Method::Voxels,
            5,
        ),
        (
            "lidar/planeseg_terrain_close_rect.pcd",
            [-0.029, -0.006, 0.088],
            Method::Brossette2013,
            8,
        ),
        (
            "lidar/planeseg_terrain_close_rect.pcd",
            [-0.029, -0.006, 0.088],
            Method::Voxels,
            9,
        ),
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
    let Some(path) = shared("lidar/nebula_vlp16_1673400472138016708.pcd") else {
        return;
    };
    let scan = read_scan(&path, &options("generic", None)).unwrap();
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
