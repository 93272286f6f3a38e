//! The scenes that ship, scanned, planned, verified, held and executed in MuJoCo. The world of the
//! simulation is the true one; the plan knows the scan alone.
//!
//! Pass criteria: the motion is executed within every criterion of the simulation's (its `criteria`
//! name them with their bounds); of the climbs every stance is held for its time, too.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used)]

use std::process::Command;

use planner::plan::Plan;
use serde_json::Value;

/// One criterion: where, name, value, bound, passed.
struct Criterion {
    place: String,
    name: String,
    value: f64,
    bound: f64,
    pass: bool,
}

/// Plans a scene and simulates the plan on the true world as the flags say: the plan, and the criteria.
fn simulate(scene: &str, flags: &[&str]) -> (Plan, Vec<Criterion>) {
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
    let plan = format!("{results}/plan.json");
    let simulated = scandent(&[&["simulate", &plan], flags].concat());
    let file = folder.path().join(&results).join("simulation.json");
    let text = std::fs::read_to_string(file)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&simulated.stderr)));
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["true_world"], true, "the world is the true one");
    let plan = std::fs::read_to_string(folder.path().join(plan)).unwrap();
    let stances = report["stances"].as_array().into_iter().flatten();
    let criteria = stances
        .map(|s| (format!("stance {}", s["stance"]), &s["plain"]))
        .chain([("execution".to_owned(), &report["execution"])])
        .flat_map(|(place, result)| criteria(&place, result))
        .collect();
    (serde_json::from_str(&plan).unwrap(), criteria)
}

fn criteria(place: &str, result: &Value) -> Vec<Criterion> {
    let list = result["criteria"].as_array().unwrap();
    assert!(list.len() >= 10, "{place}: {} criteria", list.len());
    list.iter()
        .map(|c| Criterion {
            place: place.to_owned(),
            name: c["name"].as_str().unwrap().to_owned(),
            value: c["value"].as_f64().unwrap(),
            bound: c["bound"].as_f64().unwrap(),
            pass: c["pass"].as_bool().unwrap(),
        })
        .collect()
}

fn assert_passes(criteria: &[Criterion]) {
    for c in criteria {
        let Criterion {
            place, name, value, ..
        } = c;
        assert!(c.pass, "{place}: {name}: {value} against {}", c.bound);
    }
}

fn is_held_and_climbed(scene: &str) {
    let (plan, criteria) = simulate(scene, &[]);
    assert!(criteria.len() > 10 * plan.stances.len());
    assert_passes(&criteria);
}

/// 0.71 m up, step by step.
#[test]
fn irregular_stairs_are_climbed_in_the_true_world() {
    is_held_and_climbed("irregular-stairs");
}

/// The board, the hand on the cabinet, the table, past a shelf whose upper part the scan cut off.
#[test]
fn the_slope_is_climbed_with_the_hand_in_the_true_world() {
    is_held_and_climbed("slope-and-hand");
}

/// A ramp that a LiDAR saw, walked up in the true world; at the end all feet are on it, and it rises by
/// that angle.
fn climbs_ramp(scene: &str, angle_deg: f64) {
    let (plan, criteria) = simulate(scene, &["--execute"]);
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
    assert_passes(&simulate("hexapod-obstacles", &["--execute"]).1);
}
