//! `calibrate lidar` and `slope` as a user meets them: a capture in, a calibration, a description.

use std::path::Path;
use std::process::{Command, Output};

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, pcd, sweep};
use scenes::worlds::slope::{PAPER, POLES_M, room};

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
    fails(&["slope", text(&three)], &["three.pcd", "ground"]);
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
