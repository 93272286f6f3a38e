//! The scenes that ship, scanned, planned, verified, held and executed in MuJoCo.
//!
//! Pass criteria: the motion is executed on the true world, of which the plan knows the scan alone,
//! within every criterion of the simulation's (its `criteria` name them with their bounds). Every
//! stance of the climbs is held on the world as it was planned with, where nothing but the plan's own
//! postures and forces can move the robot.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

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

/// A scene that was planned, in a folder of its own.
struct Planned {
    folder: tempfile::TempDir,
    results: String,
}

impl Planned {
    fn new(scene: &str) -> Self {
        let planned = Self {
            folder: tempfile::tempdir().unwrap(),
            results: format!("out/{scene}"),
        };
        let run = planned.scandent(&["run", scene, "--output", "out"]);
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        planned
    }

    fn scandent(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_scandent"))
            .args(arguments)
            .current_dir(self.folder.path())
            .env_remove("RUST_LOG")
            .output()
            .unwrap()
    }

    fn read(&self, name: &str) -> String {
        let file = self.folder.path().join(&self.results).join(name);
        std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    fn plan(&self) -> Plan {
        serde_json::from_str(&self.read("plan.json")).unwrap()
    }

    /// What a simulation with those flags reports.
    fn simulated(&self, flags: &[&str]) -> Value {
        let plan = format!("{}/plan.json", self.results);
        self.scandent(&[&["simulate", &plan], flags].concat());
        serde_json::from_str(&self.read("simulation.json")).unwrap()
    }

    /// Executed on the true world: every criterion.
    fn is_executed(&self) {
        let report = self.simulated(&["--execute"]);
        assert_eq!(report["true_world"], true, "the world is the true one");
        assert_passes(&criteria("execution", &report["execution"]));
    }

    /// Every stance, held without a push on the world as planned: every criterion.
    fn is_held(&self) {
        let report = self.simulated(&["--hold", "--world", "planned"]);
        let stances = report["stances"].as_array().unwrap();
        assert_eq!(stances.len(), self.plan().stances.len());
        for stance in stances {
            let place = format!("stance {}", stance["stance"]);
            assert_passes(&criteria(&place, &stance["plain"]));
        }
    }
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

/// 0.71 m up, step by step.
#[test]
fn irregular_stairs_are_climbed_in_the_true_world() {
    let planned = Planned::new("irregular-stairs");
    planned.is_held();
    planned.is_executed();
}

/// The board, the hand on the cabinet, the table, past a shelf whose upper part the scan cut off.
#[test]
fn the_slope_is_climbed_with_the_hand_in_the_true_world() {
    let planned = Planned::new("slope-and-hand");
    planned.is_held();
    planned.is_executed();
}

/// A ramp that a LiDAR saw, walked up in the true world; at the end all feet are on it, and it rises by
/// that angle.
fn climbs_ramp(scene: &str, angle_deg: f64) {
    let planned = Planned::new(scene);
    planned.is_executed();
    let plan = planned.plan();
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
    Planned::new("hexapod-obstacles").is_executed();
}
