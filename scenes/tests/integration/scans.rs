//! The embedded scans: made by this simulator, from the robot's head, and showing what they should.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use robot_model::{Configuration, Kinematics, Robot};
use scenes::simulator::{DepthNoise, Scan, XTION};
use scenes::{Builtin, SceneFile};

use crate::robots::shipped;

/// The scenes that a depth camera shows.
fn all() -> impl Iterator<Item = &'static Builtin> {
    scenes::names()
        .filter_map(scenes::builtin)
        .filter(|scene| scene.sweep.is_none())
}

fn only_scan(scene: &Builtin) -> scenes::scene_file::ScanSource {
    let scans = SceneFile::parse(scene.toml).unwrap().scan;
    assert_eq!(scans.len(), 1, "{}: one shot", scene.name);
    scans.into_iter().next().unwrap()
}

fn simulate(scene: &Builtin, noise: &DepthNoise) -> Scan {
    scene.picture(noise, scene.seed).unwrap()
}

fn embedded(scene: &Builtin) -> Vec<u16> {
    let bytes = scene.file(&only_scan(scene).depth.unwrap()).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(&bytes[..]));
    let mut reader = reader.read_info().unwrap();
    let mut raw = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut raw).unwrap();
    assert_eq!((info.width, info.height), (640, 480));
    let depths = (png::ColorType::Grayscale, png::BitDepth::Sixteen);
    assert_eq!((info.color_type, info.bit_depth), depths);
    let pixels = raw.chunks_exact(2);
    pixels.map(|b| u16::from_be_bytes([b[0], b[1]])).collect()
}

/// Whoever changes geometry, noise or pose must run `make_scans` again.
#[test]
fn embedded_scans_are_what_the_simulator_makes_now() {
    for scene in all() {
        let now = simulate(scene, &DepthNoise::default()).depth_mm;
        let then = embedded(scene);
        let differing = now.iter().zip(&then).filter(|(a, b)| a != b).count();
        let name = scene.name;
        assert!(
            now == then,
            "{name}: {differing} pixels differ; run make_scans"
        );
    }
}

/// X_WV is the pose of the robot's frame `head_depth` at the start, head turned within its limits.
#[test]
fn scans_are_taken_from_the_robots_head() {
    let robot = shipped("hrp2");
    for scene in all() {
        let file = SceneFile::parse(scene.toml).unwrap();
        if file.robot.urdf != "builtin:hrp2" {
            continue;
        }
        let X_WV = only_scan(scene).X_WV();
        let start = &file.start;
        let [roll, pitch, yaw] = start.base_rpy_rad;
        let X_WB = Isometry3::from_parts(
            Translation3::from(Vector3::from(start.base_position_m.unwrap())),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        );
        // The yaw and pitch at which the optical axis of the head looks along that of the scan:
        // the mount is pitched 10° down, and yaw comes first.
        let z_B = X_WB.rotation.inverse() * (X_WV * Vector3::z());
        let head_yaw = z_B.y.atan2(z_B.x);
        let head_pitch = (-z_B.z).asin() - 10f64.to_radians();
        assert!(head_yaw.abs() <= 45f64.to_radians() && head_pitch <= 45f64.to_radians());
        let expected = X_WB * head_depth(&robot, head_yaw, head_pitch);
        let error = expected.inverse() * X_WV;
        let (shift, turn) = (error.translation.vector.norm(), error.rotation.angle());
        assert!(shift < 1e-6 && turn < 1e-6, "{}: {error}", scene.name);
    }
}

/// Pose of `head_depth` in BODY, every joint but the head's at zero as in half_sitting.
fn head_depth(robot: &Robot, yaw: f64, pitch: f64) -> Isometry3<f64> {
    let mut q = Configuration::zero(robot.nj());
    for (joint, angle) in [("HEAD_JOINT0", yaw), ("HEAD_JOINT1", pitch)] {
        q.joints[robot.joint_index(joint).unwrap()] = angle;
    }
    let kinematics = Kinematics::new(robot, &q);
    kinematics.X_WL(robot, "head_depth").unwrap()
}

/// The depth errors that remain after the dropouts have the RMS of the noise model.
#[test]
fn depth_errors_have_the_modelled_size() {
    for scene in all() {
        let scan = simulate(scene, &DepthNoise::default());
        let noise = DepthNoise::default();
        let mut ratio = Vec::new();
        for i in 0..scan.depth_mm.len() {
            let (z, measured) = (scan.true_depth_m[i], f64::from(scan.depth_mm[i]) / 1000.0);
            // Away from edges: the neighbours lie on the same face.
            let inner = i % 640 > 2 && i % 640 < 637 && i / 640 > 2 && i / 640 < 477;
            let same = |j: usize| scan.face[j] == scan.face[i];
            let neighbours = |i: usize| [i - 2, i + 2, i - 1280, i + 1280];
            if !inner || measured == 0.0 || !neighbours(i).into_iter().all(same) {
                continue;
            }
            let quantum =
                z * z * noise.disparity_step_px / (scene.camera().unwrap().fx * noise.baseline_m);
            let variance = noise.sigma_m(z).powi(2)
                + (noise.distortion * z).powi(2)
                + (quantum * quantum + 1e-6) / 12.0;
            ratio.push((measured - z).powi(2) / variance);
        }
        let (name, pixels) = (scene.name, ratio.len());
        let mean = ratio.iter().sum::<f64>() / pixels as f64;
        assert!(pixels > 150_000, "{name}: {pixels} pixels");
        // The distortion has some (640·480)/(4π·40²) ≈ 15 independent spots: its variance alone is
        // uncertain by a third.
        assert!((0.6..1.5).contains(&mean), "{name}: variance ratio {mean}");
    }
}

/// Without noise every pixel has a value, and it is the true depth to half a millimetre.
#[test]
fn a_perfect_sensor_measures_the_truth() {
    for scene in all() {
        let scan = simulate(scene, &DepthNoise::none());
        for (mm, z) in scan.depth_mm.iter().zip(&scan.true_depth_m) {
            let expected = if z.is_nan() { 0.0 } else { *z };
            assert!((f64::from(*mm) / 1000.0 - expected).abs() <= 0.0005 + 1e-9);
        }
    }
}

/// A body, and x, y in W of a sole's centre on its top.
type Foothold = (&'static str, [f64; 2]);

/// Centres of the soles (x, y in W) that the scenes' documentation proposes, by body.
const FOOTHOLDS: [(&str, &[Foothold]); 2] = [
    (
        "irregular-stairs",
        &[
            ("step 2", [0.455, -0.13]),
            ("step 3", [0.87, 0.12]),
            ("step 4", [1.26, -0.11]),
            ("table", [1.635, 0.11]),
            ("table", [1.96, -0.11]),
        ],
    ),
    (
        "slope-and-hand",
        &[
            ("board", [0.48, -0.12]),
            ("board", [0.48, 0.12]),
            ("board", [0.86, -0.12]),
            ("board", [0.86, 0.12]),
            ("step", [1.29, -0.1]),
            ("step", [1.29, 0.1]),
            ("table", [1.66, 0.1]),
            ("table", [1.95, -0.12]),
        ],
    ),
];

/// Every proposed foothold is seen whole, with 15 mm around the sole (0.23 × 0.131 m).
#[test]
fn the_sensor_sees_every_foothold() {
    for (name, footholds) in FOOTHOLDS {
        let scene = scenes::builtin(name).unwrap();
        let truth = (scene.truth)();
        let scan = simulate(scene, &DepthNoise::default());
        let X_VW = only_scan(scene).X_WV().inverse();
        for (body, [x, y]) in footholds {
            let top = truth.body(body).unwrap().top();
            let face = truth.faces().iter().position(|f| f.name == top.name);
            let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            for (sx, sy) in corners.into_iter().chain([(0.0, 0.0)]) {
                let (px, py) = (x + sx * 0.130, y + sy * 0.0805);
                let n = top.normal_W;
                let p_W = nalgebra::Point3::new(px, py, (top.offset_m - n.x * px - n.y * py) / n.z);
                let p_V = X_VW * p_W;
                let u = (XTION.fx * p_V.x / p_V.z + XTION.cx).round();
                let v = (XTION.fy * p_V.y / p_V.z + XTION.cy).round();
                let inside = (0.0..640.0).contains(&u) && (0.0..480.0).contains(&v);
                assert!(inside, "{body} {x} {y}");
                let pixel = v as usize * 640 + u as usize;
                assert_eq!(scan.face[pixel], face, "{name}: {body} at {x}, {y}");
            }
        }
    }
}

/// As many faces as the paper's scans have surfaces show enough pixels to be found: tops in the
/// first scene, all faces in the second (whose twelfth is the table's slab, 3 cm high).
#[test]
fn scans_show_as_many_faces_as_the_paper_has_surfaces() {
    let count = |name: &str, only_tops: bool| {
        let scene = scenes::builtin(name).unwrap();
        let scan = simulate(scene, &DepthNoise::default());
        let mut pixels = vec![0; (scene.truth)().faces().len()];
        for (face, mm) in scan.face.iter().zip(&scan.depth_mm) {
            if let Some(face) = face.filter(|_| *mm > 0) {
                pixels[face] += 1;
            }
        }
        let faces = (scene.truth)().faces();
        let seen = faces
            .iter()
            .zip(&pixels)
            .filter(|(face, pixels)| **pixels >= 2000 && (!only_tops || face.normal_W.z > 0.99));
        seen.count()
    };
    assert_eq!(count("irregular-stairs", true), 6);
    assert_eq!(count("slope-and-hand", false), 12);
}
