//! Every number among the settings at both ends of its range: the program ends, with a plan, without
//! one or with a clear error, within 60 s where it usually takes a tenth of one. Just beyond, it
//! refuses.

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use rayon::prelude::*;
use scenes::simulator::lidar::{RangeNoise, Vlp16, pcap, sweep};
use scenes::worlds::slope::room;

use crate::calibrate_camera::{STANCES, write_set};
use crate::support::program::{FLOOR, command, ends_with, root, said, succeeds};

const PLAN: &str = "plan --robot builtin:quadruped --goal 0.2,0 --mesh @ -o @";

/// Key, least and greatest value of every number that `scandent config` lists.
fn ranges() -> Vec<(String, [f64; 2])> {
    let text = succeeds("config", &[]);
    let (mut table, mut range, mut found) = (String::new(), None, Vec::new());
    for line in text.lines() {
        if let Some(words) = line.strip_prefix("# From ") {
            let bounds = words.trim_end_matches('.').split_once(" to ");
            range = bounds.and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
        } else if let Some(header) = line.strip_prefix('[') {
            table = header.replace(']', ".");
        } else if let Some((key, _)) = line.trim_start_matches("# ").split_once(" = ")
            && let Some(range) = range.take()
        {
            found.push((format!("{table}{key}"), range));
        }
    }
    found
}

/// The value of a setting: a direction has three of them.
fn set(key: &str, value: f64) -> String {
    match key.ends_with("facing_W") {
        true => format!("--set {key}=[{value},{value},{value}]"),
        false => format!("--set {key}={value}"),
    }
}

#[test]
fn settings_at_their_limits_neither_panic_nor_hang() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("floor.obj");
    std::fs::write(&mesh, FLOOR).expect("writable");
    let scan = root("scenes/scenes/irregular-stairs_depth.png");
    let (frames, poses) = (
        folder.path().join("frames"),
        folder.path().join("frames/poses.csv"),
    );
    std::fs::create_dir(&frames).expect("a folder");
    write_set(&frames, "hexapod", &STANCES);
    // What is simulated, and what a LiDAR saw of flat ground.
    let (planned, flat) = (
        folder.path().join("planned"),
        folder.path().join("flat.pcap"),
    );
    let plan = planned.join("plan.json");
    succeeds(PLAN, &[&mesh, &planned]);
    let pose = Isometry3::translation(0.0, 0.0, 0.75);
    let (sensor, noise) = (Vlp16::default(), RangeNoise::default());
    let cloud = sweep(&room("room", &[]).world(), &sensor, &pose, &noise, 0, 1);
    std::fs::write(&flat, pcap(&sensor, &cloud)).expect("written");
    let ranges = ranges();
    assert!(ranges.len() > 70, "{ranges:?}");
    ranges.par_iter().for_each(|(key, [low, high])| {
        for (value, beyond) in [(low, low - 1e-4 - low.abs()), (high, high * 1.5 + 1e-4)] {
            let setting = set(key, beyond);
            // Of whole numbers it says so.
            let text = ends_with(&format!("config {setting}"), &[], 2, &[key]);
            assert!(
                text.contains("it goes from") || text.contains("invalid type"),
                "{text}"
            );
            let (setting, out) = (set(key, *value), folder.path().join(key));
            let line = match key.split('.').next() {
                Some("perception") if key.contains("lidar") => "run slope-22 -o @",
                Some("perception") => "surfaces --sensor kinect_v1 @",
                Some("simulation") if cfg!(feature = "mujoco") => {
                    "simulate --perturb all --runs 1 @ -o @"
                }
                Some("calibration") if key.contains("lidar") => {
                    "calibrate lidar @ -o @ --pole 2,1 --pole 2,-1"
                }
                Some("calibration") => {
                    "calibrate camera --robot builtin:hexapod --poses @ --frames @ -o @"
                }
                _ => PLAN,
            };
            let words: Vec<&str> = line.split(' ').take(2).collect();
            let files = match words[..] {
                ["run", _] => vec![out.as_path()],
                ["surfaces", _] => vec![scan.as_path()],
                ["simulate", _] => vec![plan.as_path(), out.as_path()],
                ["calibrate", "lidar"] => vec![flat.as_path(), out.as_path()],
                ["calibrate", _] => vec![poses.as_path(), frames.as_path(), out.as_path()],
                _ => vec![mesh.as_path(), out.as_path()],
            };
            let mut program = command(&format!("{line} {setting}"), &files);
            let program = program.stdout(Stdio::piped()).stderr(Stdio::piped());
            let text = ends_in_time(program.spawn().expect("the program starts"), &setting);
            assert!(!text.contains("panicked"), "{setting}: {text}");
        }
    });
}

/// What a run printed that ended by itself.
fn ends_in_time(mut child: Child, what: &str) -> String {
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().expect("killed");
            panic!("{what}: no end");
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let output = child.wait_with_output().expect("ended");
    let code = output.status.code();
    assert!(code.is_some_and(|code| code <= 4), "{what}: {code:?}");
    said(&output)
}
