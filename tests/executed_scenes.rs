//! The scenes that ship, scanned, planned, verified and executed in MuJoCo. The world of the
//! simulation is the true one; the plan knows the scan alone.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used)]

use std::process::Command;

use planner::plan::Plan;

/// Criteria of one executed motion: name, value, bound, passed.
struct Criterion {
    name: String,
    value: f64,
    bound: f64,
    pass: bool,
}

/// Plans a scene and executes the plan on the true world: the plan, and the criteria.
fn execute(scene: &str) -> (Plan, Vec<Criterion>) {
    let folder = tempfile::tempdir().unwrap();
    let scandent = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_scandent"))
            .args(arguments)
            .current_dir(folder.path())
            .env_remove("RUST_LOG")
            .output()
            .unwrap()
    };
    let planned = scandent(&["run", scene, "--output", "out"]);
    assert!(
        planned.status.success(),
        "{}",
        String::from_utf8_lossy(&planned.stderr)
    );
    let results = format!("out/{scene}");
    let executed = scandent(&["simulate", &format!("{results}/plan.json"), "--execute"]);
    let file = folder.path().join(&results).join("simulation.json");
    let text = std::fs::read_to_string(file)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&executed.stderr)));
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["true_world"], true, "the world is the true one");
    let plan = std::fs::read_to_string(folder.path().join(&results).join("plan.json")).unwrap();
    let criteria = report["execution"]["criteria"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| Criterion {
            name: c["name"].as_str().unwrap().to_owned(),
            value: c["value"].as_f64().unwrap(),
            bound: c["bound"].as_f64().unwrap(),
            pass: c["pass"].as_bool().unwrap(),
        })
        .collect();
    (serde_json::from_str(&plan).unwrap(), criteria)
}

fn assert_passes(criteria: &[Criterion]) {
    assert!(criteria.len() >= 10, "{} criteria", criteria.len());
    for c in criteria {
        assert!(c.pass, "{}: {} against {}", c.name, c.value, c.bound);
    }
}

/// 0.71 m up, step by step; every criterion of a plain execution.
#[test]
fn irregular_stairs_are_climbed_in_the_true_world() {
    assert_passes(&execute("irregular-stairs").1);
}

/// The board, the hand on the cabinet, the table, past a shelf whose upper part the scan cut off.
#[test]
fn the_slope_is_climbed_with_the_hand_in_the_true_world() {
    assert_passes(&execute("slope-and-hand").1);
}

/// A ramp that a LiDAR saw, walked up in the true world; at the end all feet are on it, and it rises by
/// that angle.
fn climbs_ramp(scene: &str, angle_deg: f64) {
    let (plan, criteria) = execute(scene);
    assert_passes(&criteria);
    let last = plan.stances.last().unwrap();
    assert_eq!(last.contacts.len(), 4);
    for contact in &last.contacts {
        let on = plan.surfaces.iter().find(|s| s.id == contact.surface);
        let tilt = on.unwrap().normal_W().z.acos().to_degrees();
        assert!((tilt - angle_deg).abs() < 0.3, "{}: {tilt}°", contact.patch);
    }
}

#[test]
fn a_gentle_ramp_is_climbed_in_the_true_world() {
    climbs_ramp("slope-10.5", 10.5);
}

#[test]
fn a_steep_ramp_is_climbed_in_the_true_world() {
    climbs_ramp("slope-23.8", 23.8);
}

#[test]
fn a_gentle_ramp_is_climbed_at_30_degrees_to_its_fall_line() {
    climbs_ramp("slope-10.5-at-30", 10.5);
}

#[test]
fn a_steep_ramp_is_climbed_at_30_degrees_to_its_fall_line() {
    climbs_ramp("slope-23.8-at-30", 23.8);
}

/// Onto and between blocks, seen through a camera that was identified from the ground alone.
#[test]
fn the_hexapod_crosses_blocks_in_the_true_world() {
    assert_passes(&execute("hexapod-obstacles").1);
}
