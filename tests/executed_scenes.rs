//! The scenes that ship, scanned, planned, verified and executed in MuJoCo. The world of the
//! simulation is the true one; the plan knows the scan alone.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used)]

use std::process::Command;

/// Criteria of one executed motion: name, value, bound, passed.
struct Criterion {
    name: String,
    value: f64,
    bound: f64,
    pass: bool,
}

/// Plans a scene and executes the plan on the true world.
fn execute(scene: &str) -> Vec<Criterion> {
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
    let file = folder.path().join(results).join("simulation.json");
    let text = std::fs::read_to_string(file)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&executed.stderr)));
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["true_world"], true, "the world is the true one");
    report["execution"]["criteria"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| Criterion {
            name: c["name"].as_str().unwrap().to_owned(),
            value: c["value"].as_f64().unwrap(),
            bound: c["bound"].as_f64().unwrap(),
            pass: c["pass"].as_bool().unwrap(),
        })
        .collect()
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
    assert_passes(&execute("irregular-stairs"));
}

/// The board, the hand on the cabinet, the table, past a shelf whose upper part the scan cut off.
#[test]
fn the_slope_is_climbed_with_the_hand_in_the_true_world() {
    assert_passes(&execute("slope-and-hand"));
}
