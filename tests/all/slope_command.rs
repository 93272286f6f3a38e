//! `calibrate lidar` and `slope` as a user meets them: a capture in, a calibration, a description.

use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, pcd, sweep};
use scenes::worlds::slope::{PAPER, POLES_M, Ramp, room};

use crate::support::program::{self, ends_with, list, number, succeeds};

/// Calibrates by a capture of flat ground with the poles; what the program said.
pub fn calibrated(flat: &Path, toml: &Path) -> String {
    let poles = POLES_M.map(|[x, y]| format!("--pole={x},{y}")).join(" ");
    succeeds(&format!("calibrate lidar @ -o @ {poles}"), &[flat, toml])
}

/// Greatest distance of the ends of a described slope from the true ones, m.
pub fn ends_off_m(slope: &serde_json::Value, ramp: &Ramp) -> f64 {
    let [left, right] = ramp.ends_m();
    let off = [("p1", right), ("p2", left)].map(|(field, end)| {
        let of = |i: usize| (number(&slope[field][i]) - end[i]).powi(2);
        (0..3).map(of).sum::<f64>().sqrt()
    });
    off[0].max(off[1])
}

/// One device (its rings' errors) over flat ground and before a ramp, at a mount that leans and turns.
#[test]
fn a_calibration_makes_the_slope_right_in_the_world() {
    let folder = tempfile::tempdir().expect("a folder");
    let [roll, pitch, yaw] = [-4.0, 9.0, 12.0].map(f64::to_radians);
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, 0.75), rotation);
    let (sensor, noise, row) = (Vlp16::default(), RangeNoise::default(), &PAPER[4]);
    let taken = |ramps: &[Ramp], seed| {
        let world = room("room", ramps).world();
        sweep(&world, &sensor, &pose, &noise, 3, seed)
    };
    let path = |name: &str| folder.path().join(name);
    let (flat, ramp) = (path("flat.pcap"), path("ramp.pcd"));
    std::fs::write(&flat, pcap(&sensor, &taken(&[], 1))).expect("written");
    std::fs::write(&ramp, pcd(&taken(&[row.ramp()], 2))).expect("written");
    let (toml, json) = (path("lidar.toml"), path("slope.json"));

    let said = calibrated(&flat, &toml);
    assert!(said.contains("heading"), "{said}");
    assert!(said.contains("ring 15"), "{said}");

    let describe = "slope @ --calibration @ --heading 0,90 -o @";
    let said = succeeds(describe, &[&ramp, &toml, &json]);
    assert!(said.contains("slope 0: 19.7"), "{said}");
    let file = program::json(&json);
    assert_eq!(file["calibrated"], true);
    let slope = &file["slopes"][0];
    let off = number(&slope["delta_deg"]) - row.angle_deg;
    assert!(off.abs() < 0.1, "{slope}");
    let off = ends_off_m(slope, &row.ramp());
    assert!(off < 0.02, "{off} m");
    for field in ["l", "psi"] {
        let norm: f64 = (0..3).map(|i| number(&slope[field][i]).powi(2)).sum();
        assert!((norm - 1.0).abs() < 1e-9, "{field}");
    }
    let lengths = ["lambda_l", "lambda_ls", "stepping"].map(|field| list(&slope[field]).len());
    assert_eq!(lengths, [9, 6, 2]);
    assert!(number(&slope["delta_sigma_deg"]) > 0.0);

    // The same, byte for byte; and its surfaces are a set that other commands read.
    let again = path("again.json");
    succeeds(describe, &[&ramp, &toml, &again]);
    assert_eq!(program::read(&again), program::read(&json));
    let set = path("surfaces.json");
    let said = succeeds("surfaces @ --calibration @ -o @", &[&ramp, &toml, &set]);
    assert!(said.contains("slope0"), "{said}");
    assert!(said.contains("ground0"), "{said}");
    surfaces::Terrain::from_json(&program::read(&set)).expect("a terrain");
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
    let read = perception::parse_lidar(&plain, &taken, None);
    let cloud = read.expect("a cloud").cloud;
    let moved_by = |p: &[f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) + eye[k]);
    let points: Vec<[f64; 3]> = cloud.points_V.iter().map(moved_by).collect();
    let moved = path("moved.ply");
    std::fs::write(&moved, program::ply(&points)).expect("written");

    let describe = |cloud: &Path, more: &str, words: &[&str]| {
        let json = path("slope.json");
        ends_with(&format!("slope @ -o @ {more}"), &[cloud, &json], 0, words);
        program::json(&json)
    };
    let still = describe(&plain, "", &["wall 0: ", "thing 0: ", "slope 0: 19."]);
    let seen = describe(&moved, "--eye 4,-2.5,1.25", &[]);
    let [a, b] = [&still, &seen].map(|file| number(&file["slopes"][0]["delta_deg"]));
    assert!((a - b).abs() < 0.1, "{a} {b}");
    assert_eq!(seen["eye_m"], serde_json::json!(eye));
    // The wall ahead, 6 m away, and the one beside, 4.5 m away, in both.
    for file in [&still, &seen] {
        let walls = list(&file["walls"]);
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
    let three = path("three.pcd");
    std::fs::write(
        &three,
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 0 -0.5\n1.5 0.2 -0.5\n1.2 -0.4 -0.5\n",
    )
    .expect("written");
    // That nothing is ground is a result.
    ends_with("slope @", &[&three], 0, &["no ground"]);
    ends_with("calibrate lidar @", &[&three], 1, &["three.pcd", "ground"]);
    let format = "format = \"scandent-lidar-calibration/1\"\n";
    for (name, content, word) in [
        ("a.toml", format, "position_m"),
        ("b.toml", "not toml at all", "a LiDAR's calibration"),
    ] {
        let file = path(name);
        std::fs::write(&file, content).expect("written");
        let line = "slope @ --calibration @";
        ends_with(line, &[&three, &file], 1, &[name, word]);
    }
    let empty = path("empty.pcap");
    std::fs::write(&empty, [0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0]).expect("written");
    ends_with("slope @", &[&empty], 1, &["empty.pcap"]);
}
