//! Scan to verified plan through the program, for the scenes that ship and for a known mesh.
//!
//! Pass criteria, for every scene: exit code 0; all result files; a report with the stages' times
//! and the search's size; the plan passes `verify`; the same `plan.json`, byte for byte, on 1, 2
//! and 4 threads.

use std::path::Path;

use serde_json::Value;

use crate::support::boxes::boxes_obj;
use crate::support::program::{
    assert_ended, ends_with, json, list, number, read, scandent, succeeds,
};
use crate::support::shipped::shipped;

/// Judges what a scene that ships leaves.
fn judge(scene: &'static str) {
    let results = &shipped(scene).results;
    let plan = results.join("plan.json");
    // On two threads as it was made, and on another number of them: `plan.json` is the same.
    let folder = tempfile::tempdir().expect("a temporary folder");
    for threads in [1, 4] {
        let line = format!("run {scene} --threads {threads} -o @");
        succeeds(&line, &[folder.path()]);
        for name in ["plan.json", "search.json"] {
            let same = read(folder.path().join(scene).join(name)) == read(results.join(name));
            assert!(same, "{scene}: {threads} threads change {name}");
        }
    }
    let files = "surfaces.json contacts.yaml plan.csv certificate.json";
    for name in files.split(' ') {
        let text = read(results.join(name));
        assert!(!text.is_empty(), "{scene}: {name} is empty");
    }
    judge_trace(results);
    let page = read(results.join("view.html"));
    assert!(page.contains("</html>") && page.contains(scene));
    let report = json(results.join("report.json"));
    for stage in ["perception", "planning"] {
        assert!(number(&report["stages_ms"][stage]) > 0.0, "{report}");
    }
    assert_eq!(report["threads"], 2);
    let size = |field: &str| number(&report[field]);
    let (generated, expanded) = (size("nodes_generated"), size("nodes_expanded"));
    assert!(size("surfaces") > 0.0 && generated >= expanded, "{report}");
    assert!(expanded + 1.0 >= size("path_stances"), "{report}");
    succeeds("verify @", &[&plan]);
    judge_times(results, &succeeds("export @ --format json", &[&plan]));
    succeeds("view @", &[&plan]);
}

/// Every change of the plan is told with its price and what else there was, from the tree that was counted.
fn judge_trace(results: &Path) {
    let (plan, search) = (
        json(results.join("plan.json")),
        json(results.join("search.json")),
    );
    let (nodes, stances) = (list(&search["nodes"]), list(&plan["stances"]));
    assert_eq!(
        number(&plan["search"]["nodes_generated"]),
        nodes.len() as f64
    );
    let index = |value: &Value| value.as_u64().expect("a position") as usize;
    for (k, node) in nodes.iter().enumerate().skip(1) {
        assert!(index(&node["parent"]) < k);
    }
    let choices = list(&search["choices"]);
    // The goal's posture changes no contact.
    assert_eq!(choices.len() + 2, stances.len());
    let base = list(&nodes[0]["base_W"]);
    let off = |axis: usize| number(&base[axis]) - number(&stances[0]["q"][axis]);
    assert!((0..3).all(|axis| off(axis).abs() < 1e-3));
    let mut before = 0;
    for (k, choice) in choices.iter().enumerate() {
        assert_eq!(index(&choice["stance"]), k + 1);
        // On one way of the tree, of which the plan may leave something out.
        let node = index(&choice["node"]);
        let mut up = node;
        while up != before {
            up = index(&nodes[up]["parent"]);
        }
        before = node;
        assert!(number(&choice["price"]) > 0.0);
        let others = list(&choice["alternatives"]).iter();
        let prices: Vec<f64> = others.map(|other| number(&other["price"])).collect();
        assert!(prices.is_sorted());
    }
}

/// What is exported lands when the motion lands: 1 s later, as long as `export.start_s` is by default.
fn judge_times(results: &Path, exported: &str) {
    let document: Value = serde_json::from_str(exported).expect("JSON");
    let motion = json(results.join("motion.json"));
    let ends = |phases: &Value, patch: &str, end: &str, later: f64| -> Vec<(String, i64)> {
        (list(phases).iter())
            .filter_map(|p| Some((p[patch].as_str()?.to_owned(), p[end].as_f64()? + later)))
            .map(|(patch, t)| (patch, (1e3 * t).round() as i64))
            .collect()
    };
    let moved = ends(&motion["phases"], "swing", "t_end_s", 1.0);
    assert!(!moved.is_empty());
    assert_eq!(ends(&document["phases"], "patch", "end_s", 0.0), moved);
}

#[test]
fn irregular_stairs_are_climbed() {
    judge("irregular-stairs");
}

#[test]
fn the_slope_is_climbed_with_the_hand() {
    judge("slope-and-hand");
}

#[test]
fn a_changed_plan_fails_verification_with_exit_code_1() {
    let results = &shipped("irregular-stairs").results;
    let mut plan = json(results.join("plan.json"));
    // Half a metre to the side: every foot off its surface.
    let y = number(&plan["stances"][2]["q"][1]);
    plan["stances"][2]["q"][1] = Value::from(y + 0.5);
    // Beside its motion.
    let broken = results.join("broken.json");
    std::fs::write(&broken, plan.to_string()).expect("writable");
    ends_with("verify @", &[&broken], 1, &["stance 2"]);
}

/// Two steps of 0.15 m on a floor, as a mesh of boxes.
fn steps_obj() -> String {
    boxes_obj(&[
        [-1.0, 3.0, -1.0, 1.0, -0.1, 0.0],
        [0.3, 0.7, -0.4, 0.4, 0.0, 0.15],
        [0.7, 2.2, -0.5, 0.5, 0.0, 0.30],
    ])
}

#[test]
fn a_known_mesh_is_climbed_without_any_scan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("steps.obj");
    std::fs::write(&mesh, steps_obj()).expect("writable");
    let out = folder.path().join("out");
    let plan = |goal: &str| scandent(&format!("plan --mesh @ -o @ --goal {goal}"), &[&mesh, &out]);
    assert_ended(&plan("1.4,0"), 0, &[]);
    let written = json(out.join("plan.json"));
    let last = list(&written["stances"]).last().expect("a last stance");
    let [x, y] = [0, 1].map(|i| number(&last["q"][i]));
    // The goal's tolerance, and the solver's.
    assert!((x - 1.4).abs() < 0.1001 && y.abs() < 0.1001, "{x} {y}");

    // The route that the search followed leads from the start to the goal.
    let route = list(&written["search"]["route"]);
    let ends = [&route[0], &route[route.len() - 1]].map(|pose| number(&pose[0]));
    assert!(
        ends[0].abs() < 0.1 && (ends[1] - 1.4).abs() < 0.1,
        "{ends:?}"
    );

    // A goal where the robot stands needs no step.
    assert_ended(&plan("0,0"), 0, &[]);
    // In a wall, a metre under the floor, is no place for a base: the reason is said, no plan is
    // left over from before.
    let blocked = plan("1.4,0,-1.0 --set planner.nodes_max=30");
    let code = blocked.status.code().expect("a code");
    assert!(matches!(code, 3 | 4));
    assert_ended(&blocked, code, &["what blocks the way"]);
    assert!(out.join("partial_plan.json").exists() && !out.join("plan.json").exists());
    // The files and the page say the same.
    let report = json(out.join("report.json"));
    let unsolved = &report["unsolved"];
    assert_eq!(unsolved["status"], report["status"]);
    assert!(!list(&unsolved["reasons"]).is_empty() && !list(&unsolved["to_try"]).is_empty());
    let partial = json(out.join("partial_plan.json"));
    assert_eq!(&partial["search"]["unsolved"], unsolved);
    let page = std::fs::read_to_string(out.join("view.html")).expect("a page");
    assert!(page.contains("<title>No plan"));
}

/// A sensor on a head sees the floor from some way ahead of the feet on.
#[test]
fn a_robot_starts_before_the_floor_that_is_seen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("floor.obj");
    std::fs::write(&mesh, boxes_obj(&[[0.9, 3.0, -1.0, 1.0, -0.1, 0.0]])).expect("writable");
    let out = folder.path().join("out");
    let plan = |flags: &str| {
        let line = format!("plan --mesh @ -o @ --goal 1.5,0 --goal-tolerance-m 0.2 {flags}");
        scandent(&line, &[&mesh, &out])
    };
    assert_ended(&plan(""), 4, &["ground to m1: 0.74 m apart"]);
    assert_ended(&plan("--before-floor"), 0, &[]);
    let written = json(out.join("plan.json"));
    let first = list(&written["stances"]).first().expect("a stance");
    let x = number(&first["q"][0]);
    assert!((0.6..0.9).contains(&x), "{x}");
    let placed = plan("--before-floor --start half_sitting@0.5,0,0.7");
    assert_ended(&placed, 2, &["--before-floor does not go with a place"]);
}

#[test]
fn a_start_that_is_no_stance_is_an_error_with_the_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("steps.obj");
    std::fs::write(&mesh, steps_obj()).expect("writable");
    let out = folder.path().join("out");
    // In the first step; tilted by half a radian; in a posture that does not exist.
    for (start, word) in [
        ("half_sitting@0.4,0,0.6487", "too near"),
        ("half_sitting@0,0,0.6487,0.5,0,0", "balance"),
        ("no_such_posture", "half_sitting"),
    ] {
        let line = format!("plan --mesh @ --goal 1.4,0 --start {start} -o @");
        ends_with(&line, &[&mesh, &out], 1, &[word]);
        assert!(!out.exists(), "{start}: results of no stance");
    }
}

#[test]
fn a_goal_out_of_reach_has_no_plan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let surfaces = folder.path().join("surfaces.json");
    let nothing = r#"{"format": "scandent-surfaces/1", "surfaces": []}"#;
    std::fs::write(&surfaces, nothing).expect("writable");
    let out = folder.path().join("out");
    ends_with(
        "plan --surfaces @ --goal 2,0 -o @",
        &[&surfaces, &out],
        3,
        &[],
    );
    let report = json(out.join("report.json"));
    assert_eq!(report["path_stances"], 0);
    assert_eq!(report["surfaces"], 1, "the ground under the feet");
}
