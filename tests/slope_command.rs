//! `calibrate lidar` and `slope` as a user meets them: a capture in, a calibration, a description.

use std::path::Path;
use std::process::{Command, Output};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, pcd, sweep};
use scenes::simulator::rng::Stream;
use scenes::worlds::slope::{PAPER, POLES_M, Ramp, room};

fn scandent(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scandent"))
        .args(args)
        .env_remove("RUST_LOG")
        .output()
        .expect("the program starts")
}

fn succeeds(args: &[&str]) -> String {
    let output = scandent(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {stderr}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn fails(args: &[&str], words: &[&str]) {
    let output = scandent(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{args:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{args:?}: no {word:?} in {stderr}");
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a plain path")
}

/// One device (its rings' errors) over flat ground and before a ramp, at a mount that leans and turns.
#[test]
fn a_calibration_makes_the_slope_right_in_the_world() {
    let folder = tempfile::tempdir().expect("a folder");
    let [roll, pitch, yaw] = [-4.0, 9.0, 12.0].map(f64::to_radians);
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.75), rotation);
    let (sensor, noise, row) = (Vlp16::default(), RangeNoise::default(), &PAPER[4]);
    let flat = sweep(&room("flat", &[]).world(), &sensor, &pose, &noise, 3, 1);
    let ramp = sweep(
        &room("ramp", &[row.ramp()]).world(),
        &sensor,
        &pose,
        &noise,
        3,
        2,
    );
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("flat.pcap"), pcap(&sensor, &flat)).expect("written");
    std::fs::write(path("ramp.pcd"), pcd(&ramp)).expect("written");
    let (flat, ramp) = (path("flat.pcap"), path("ramp.pcd"));
    let (toml, json) = (path("lidar.toml"), path("slope.json"));

    let poles: Vec<String> = POLES_M
        .iter()
        .map(|[x, y]| format!("--pole={x},{y}"))
        .collect();
    let mut args = vec!["calibrate", "lidar", text(&flat), "-o", text(&toml)];
    args.extend(poles.iter().map(String::as_str));
    let said = succeeds(&args);
    assert!(
        said.contains("heading") && said.contains("ring 15"),
        "{said}"
    );

    let said = succeeds(&[
        "slope",
        text(&ramp),
        "--calibration",
        text(&toml),
        "--heading",
        "0,90",
        "-o",
        text(&json),
    ]);
    assert!(said.contains("slope 0: 19.7"), "{said}");
    let file = std::fs::read(&json).expect("the description");
    let file: serde_json::Value = serde_json::from_slice(&file).expect("JSON");
    assert_eq!(file["calibrated"], true);
    let slope = &file["slopes"][0];
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    assert!(
        (number(&slope["delta_deg"]) - row.angle_deg).abs() < 0.1,
        "{slope}"
    );
    let [left, right] = row.ramp().ends_m();
    for (field, end) in [("p1", right), ("p2", left)] {
        let off: f64 = (0..3)
            .map(|i| (number(&slope[field][i]) - end[i]).powi(2))
            .sum();
        assert!(off.sqrt() < 0.02, "{field}: {} m", off.sqrt());
    }
    for field in ["l", "psi"] {
        let norm: f64 = (0..3).map(|i| number(&slope[field][i]).powi(2)).sum();
        assert!((norm - 1.0).abs() < 1e-9, "{field}");
    }
    assert_eq!(slope["lambda_l"].as_array().map(Vec::len), Some(9));
    assert_eq!(slope["lambda_ls"].as_array().map(Vec::len), Some(6));
    assert_eq!(slope["stepping"].as_array().map(Vec::len), Some(2));
    assert!(number(&slope["delta_sigma_deg"]) > 0.0);

    // The same, byte for byte; and its surfaces are a set that other commands read.
    let again = path("again.json");
    succeeds(&[
        "slope",
        text(&ramp),
        "--calibration",
        text(&toml),
        "--heading",
        "0,90",
        "-o",
        text(&again),
    ]);
    let same = std::fs::read(&again).expect("the description");
    assert_eq!(same, std::fs::read(&json).expect("the description"));
    let set = path("surfaces.json");
    let said = succeeds(&[
        "surfaces",
        text(&ramp),
        "--calibration",
        text(&toml),
        "-o",
        text(&set),
    ]);
    assert!(
        said.contains("slope0") && said.contains("ground0"),
        "{said}"
    );
    let set = std::fs::read_to_string(&set).expect("the surfaces");
    surfaces::SurfaceSet::from_json(&set).expect("a surface set");
}

/// Roll and pitch up to 20°, drift up to 30°; the first exactly level, the second looks up, whose
/// ground normal has A < 0. Each is another device.
fn mounts() -> Vec<Isometry3<f64>> {
    let draw = Stream::new(23, 0);
    (0..10_u64)
        .map(|number| {
            let within = |k: u64, most: f64| most * (2.0 * draw.uniform(3 * number + k) - 1.0);
            let angles = match number {
                0 => [0.0; 3],
                1 => [3.0, -6.0, 7.0],
                _ => [within(0, 20.0), within(1, 20.0), within(2, 30.0)],
            };
            let [roll, pitch, yaw] = angles.map(f64::to_radians);
            let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.75), rotation)
        })
        .collect()
}

/// From a capture to a plan, by the files that the commands leave, for ten mounts: the rotation within
/// 0.1°; the ramp, where it is in view, within 0.15° and 30 mm; and a plan that is verified.
#[test]
fn ten_mounts_go_from_packets_to_a_plan() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: String| folder.path().join(name);
    let (sensor, noise, row) = (Vlp16::default(), RangeNoise::default(), &PAPER[2]);
    let poles: Vec<String> = POLES_M
        .iter()
        .map(|[x, y]| format!("--pole={x},{y}"))
        .collect();
    let (mut negative, mut found) = (0, Vec::new());
    for (number, pose) in mounts().iter().enumerate() {
        let take = |ramps: &[Ramp], seed: u64| {
            let world = room("room", ramps).world();
            sweep(&world, &sensor, pose, &noise, number as u64, seed)
        };
        let (flat, ramp) = (
            path(format!("flat{number}.pcap")),
            path(format!("ramp{number}.pcap")),
        );
        std::fs::write(&flat, pcap(&sensor, &take(&[], 1))).expect("written");
        std::fs::write(&ramp, pcap(&sensor, &take(&[row.ramp()], 2))).expect("written");
        let (toml, json) = (
            path(format!("lidar{number}.toml")),
            path(format!("slope{number}.json")),
        );

        // 1. The mount.
        let mut args = vec!["calibrate", "lidar", text(&flat), "-o", text(&toml)];
        args.extend(poles.iter().map(String::as_str));
        succeeds(&args);
        let written = std::fs::read_to_string(&toml).expect("the calibration");
        let calibration: perception::lidar::LidarCalibration =
            toml::from_str(&written).expect("a calibration");
        let off = calibration.X_WV().rotation.angle_to(&pose.rotation);
        negative += usize::from((pose.rotation.inverse() * Vector3::z()).x < 0.0);
        assert!(off.to_degrees() < 0.1, "{number}: {}°", off.to_degrees());

        // 2. The ramp.
        succeeds(&[
            "slope",
            text(&ramp),
            "--calibration",
            text(&toml),
            "-o",
            text(&json),
        ]);
        let file = std::fs::read(&json).expect("the description");
        let file: serde_json::Value = serde_json::from_slice(&file).expect("JSON");
        let slopes = file["slopes"].as_array().expect("a list");
        println!(
            "{number}: {:.3}° off, {} slopes",
            off.to_degrees(),
            slopes.len()
        );
        assert!(slopes.len() <= 1, "{number}: {slopes:?}");
        let Some(slope) = slopes.first() else {
            continue;
        };
        let number_of = |value: &serde_json::Value| value.as_f64().expect("a number");
        let error = number_of(&slope["delta_deg"]) - row.angle_deg;
        assert!(error.abs() < 0.15, "{number}: {error}°");
        let [left, right] = row.ramp().ends_m();
        for (field, end) in [("p1", right), ("p2", left)] {
            let off: f64 = (0..3)
                .map(|i| (number_of(&slope[field][i]) - end[i]).powi(2))
                .sum();
            assert!(off.sqrt() < 0.03, "{number}: {field}: {} m", off.sqrt());
        }
        found.push(number);

        // 3. A plan up it, the sensor over the robot's front.
        let out = path(format!("plan{number}"));
        let said = succeeds(&[
            "plan",
            "--scan",
            text(&ramp),
            "--calibration",
            text(&toml),
            "--pose",
            "0.36,0,0",
            "--robot",
            "builtin:quadruped",
            "--goal",
            "2.9,0",
            "--set",
            "surfaces.roles.foot.tilt_max_rad=0.45",
            "-o",
            text(&out),
        ]);
        assert!(said.contains("verified"), "{said}");
    }
    assert!(negative >= 3, "{negative} mounts with A < 0");
    assert!(found.len() >= 5 && found.starts_with(&[0, 1]), "{found:?}");
}

/// A cloud that was moved into another frame is described as before, once it is said where the sensor
/// stood; and what else stands around is listed.
#[test]
fn a_moved_cloud_is_seen_from_where_the_sensor_stood() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let pose = Isometry3::translation(0.0, 0.0, 0.75);
    let (sensor, noise, row) = (Vlp16::default(), RangeNoise::default(), &PAPER[4]);
    let world = room("ramp", &[row.ramp()]).world();
    let taken = pcd(&sweep(&world, &sensor, &pose, &noise, 3, 2));
    let plain = path("plain.pcd");
    std::fs::write(&plain, &taken).expect("written");
    // Points alone, moved, as a PLY.
    let eye = [4.0, -2.5, 1.25];
    let cloud = perception::parse_lidar(&plain, &taken, None)
        .expect("a cloud")
        .cloud;
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nend_header\n",
        cloud.len()
    );
    for p in &cloud.points_V {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(p[k]) + eye[k]);
        ply.push_str(&format!("{x:.6} {y:.6} {z:.6}\n"));
    }
    let moved = path("moved.ply");
    std::fs::write(&moved, ply).expect("written");

    let describe = |cloud: &Path, more: &[&str], name: &str| -> (serde_json::Value, String) {
        let json = path(name);
        let mut args = vec!["slope", text(cloud), "-o", text(&json)];
        args.extend(more);
        let said = succeeds(&args);
        let file = std::fs::read(&json).expect("the description");
        (serde_json::from_slice(&file).expect("JSON"), said)
    };
    let (still, said) = describe(&plain, &[], "plain.json");
    assert!(
        said.contains("wall 0: ") && said.contains("thing 0: "),
        "{said}"
    );
    assert!(said.contains("slope 0: 19."), "{said}");
    let (seen, _) = describe(&moved, &["--eye", "4,-2.5,1.25"], "moved.json");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let delta = |file: &serde_json::Value| number(&file["slopes"][0]["delta_deg"]);
    assert!(
        (delta(&still) - delta(&seen)).abs() < 0.1,
        "{} {}",
        delta(&still),
        delta(&seen)
    );
    assert_eq!(seen["eye_m"], serde_json::json!([4.0, -2.5, 1.25]));
    // The wall ahead, 6 m away, and the one beside, 4.5 m away, in both.
    for file in [&still, &seen] {
        let walls = file["walls"].as_array().expect("a list");
        for (axis, at) in [(0, 6.0), (1, 4.5)] {
            let is = |wall: &&serde_json::Value| {
                number(&wall["normal"][axis]) < -0.99
                    && (number(&wall["distance_m"]) - at).abs() < 0.05
            };
            assert!(walls.iter().find(is).is_some(), "{axis}: {walls:?}");
        }
    }
}

#[test]
fn what_cannot_be_used_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    fails(&["slope", "no/such.pcap"], &["no/such.pcap"]);
    fails(&["calibrate", "lidar", "no/such.pcap"], &["no/such.pcap"]);
    let three = path("three.pcd");
    std::fs::write(
        &three,
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 0 -0.5\n1.5 0.2 -0.5\n1.2 -0.4 -0.5\n",
    )
    .expect("written");
    // That nothing is ground is a result.
    assert!(succeeds(&["slope", text(&three)]).contains("no ground"));
    fails(
        &["calibrate", "lidar", text(&three)],
        &["three.pcd", "ground"],
    );
    for (name, content, words) in [
        (
            "a.toml",
            "format = \"scandent-lidar-calibration/1\"\n",
            &["position_m"][..],
        ),
        ("b.toml", "not toml at all", &["a LiDAR's calibration"][..]),
    ] {
        let file = path(name);
        std::fs::write(&file, content).expect("written");
        let mut named = vec![name];
        named.extend(words);
        fails(
            &["slope", text(&three), "--calibration", text(&file)],
            &named,
        );
    }
    let empty = path("empty.pcap");
    std::fs::write(&empty, [0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0]).expect("written");
    fails(&["slope", text(&empty)], &["empty.pcap"]);
}
