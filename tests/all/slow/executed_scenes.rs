//! The scenes that ship, scanned, planned, verified, held and executed in MuJoCo.
//!
//! Pass criteria: the motion is executed on the true world, of which the plan knows the scan alone,
//! within every criterion of the simulation's (its `criteria` name them with their bounds). Every
//! stance of the climbs is held on the world as it was planned with, where nothing but the plan's own
//! postures and forces can move the robot.
#![cfg(feature = "mujoco")]

use serde_json::Value;

use crate::support::program::{json, list, number, scandent};
use crate::support::shipped::shipped;

/// What a simulation of a scene's plan with those flags reports.
fn simulated(scene: &'static str, flags: &str) -> Value {
    let results = &shipped(scene).results;
    let report = results.join("simulation.json");
    let plan = results.join("plan.json");
    scandent(&format!("simulate @ -o @ {flags}"), &[&plan, &report]);
    json(report)
}

/// Executed on the true world: every criterion.
fn is_executed(scene: &'static str) {
    let report = simulated(scene, "--execute");
    assert_eq!(report["true_world"], true, "the world is the true one");
    assert_passes("execution", &report["execution"]);
}

/// Every stance, held without a push on the world as planned: every criterion.
fn is_held(scene: &'static str) {
    let report = simulated(scene, "--hold --world planned");
    let stances = list(&report["stances"]);
    assert_eq!(stances.len(), shipped(scene).plan.stances.len());
    for stance in stances {
        assert_passes(&format!("stance {}", stance["stance"]), &stance["plain"]);
    }
}

fn assert_passes(place: &str, result: &Value) {
    let criteria = list(&result["criteria"]);
    assert!(criteria.len() >= 10, "{place}: {}", criteria.len());
    for c in criteria {
        assert_eq!(c["pass"], true, "{place}: {c}");
        assert!(number(&c["value"]).is_finite(), "{place}: {c}");
    }
}

/// 0.71 m up, step by step.
#[test]
fn irregular_stairs_are_climbed_in_the_true_world() {
    // Five steps: another one, on the ground before the stairs, is not needed.
    assert!(shipped("irregular-stairs").plan.stances.len() <= 12);
    is_held("irregular-stairs");
    is_executed("irregular-stairs");
}

/// The board, the hand on the cabinet, the table, past a shelf whose upper part the scan cut off.
#[test]
fn the_slope_is_climbed_with_the_hand_in_the_true_world() {
    is_held("slope-and-hand");
    is_executed("slope-and-hand");
}

/// A ramp that a LiDAR saw, walked up in the true world; at the end all feet are on it, and it rises by
/// that angle.
fn climbs_ramp(scene: &'static str, angle_deg: f64) {
    is_executed(scene);
    let plan = &shipped(scene).plan;
    let last = plan.stances.last().expect("a stance");
    assert_eq!(last.contacts.len(), 4);
    for contact in &last.contacts {
        let on = plan.faces.iter().find(|s| s.id == contact.face);
        let tilt = on.expect("a surface").normal_W().z.acos().to_degrees();
        assert!((tilt - angle_deg).abs() < 0.3, "{}: {tilt}°", contact.patch);
    }
}

#[test]
fn ramps_are_climbed_in_the_true_world() {
    climbs_ramp("slope-10.5", 10.5);
    climbs_ramp("slope-23.8", 23.8);
}

#[test]
fn ramps_are_climbed_at_30_degrees_to_their_fall_line() {
    climbs_ramp("slope-10.5-at-30", 10.5);
    climbs_ramp("slope-23.8-at-30", 23.8);
}

/// Onto and between blocks, seen through a camera that was identified from the ground alone.
#[test]
fn the_hexapod_crosses_blocks_in_the_true_world() {
    is_executed("hexapod-obstacles");
}
