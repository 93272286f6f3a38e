//! Scan to verified plan through the program, for the scenes that ship and for a known mesh.
//!
//! Pass criteria, for every scene: exit code 0; all result files; a report with the stages' times
//! and the search's size; the plan passes `verify`; the same `plan.json`, byte for byte, on 1, 2
//! and 4 threads.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn scandent(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scandent"))
        .args(args)
        .output()
        .expect("the program starts")
}

fn assert_done(output: &Output, what: &str) {
    assert_eq!(
        output.status.code(),
        Some(0),
        "{what}: {}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

fn path(folder: &Path) -> &str {
    folder
        .to_str()
        .expect("a temporary folder with a UTF-8 name")
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Runs a scene that ships and judges what it leaves.
fn judge(scene: &str) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut plans = Vec::new();
    for threads in ["1", "2", "4"] {
        let out = folder.path().join(threads);
        assert_done(
            &scandent(&["run", scene, "--threads", threads, "-o", path(&out)]),
            scene,
        );
        plans.push(read(&out.join(scene), "plan.json"));
    }
    assert!(
        plans[0] == plans[1] && plans[0] == plans[2],
        "{scene}: threads change the plan"
    );

    let results = folder.path().join("1").join(scene);
    for name in [
        "surfaces.json",
        "contacts.yaml",
        "plan.csv",
        "certificate.json",
    ] {
        assert!(!read(&results, name).is_empty(), "{scene}: {name} is empty");
    }
    let page = String::from_utf8(read(&results, "view.html")).expect("UTF-8");
    assert!(page.contains("</html>") && page.contains(scene));
    let report: Value = serde_json::from_slice(&read(&results, "report.json")).expect("JSON");
    for stage in ["perception", "planning"] {
        assert!(
            report["stages_ms"][stage]
                .as_f64()
                .is_some_and(|ms| ms > 0.0),
            "{report}"
        );
    }
    assert_eq!(report["threads"], 1);
    let size = |field: &str| report[field].as_u64().unwrap_or_default();
    assert!(size("surfaces") > 0, "{report}");
    assert!(
        size("nodes_generated") >= size("nodes_expanded"),
        "{report}"
    );
    assert!(
        size("nodes_expanded") + 1 >= size("path_stances"),
        "{report}"
    );
    let plan = results.join("plan.json");
    assert_done(&scandent(&["verify", path(&plan)]), "verify");
    let exported = scandent(&["export", path(&plan), "--format", "json"]);
    assert_done(&exported, "export");
    judge_times(&results, &exported.stdout);
    assert_done(&scandent(&["view", path(&plan)]), "view");
}

/// What is exported lands when the motion lands: 1 s later, as long as `export.start_s` is by default.
fn judge_times(results: &Path, exported: &[u8]) {
    let document: Value = serde_json::from_slice(exported).expect("JSON");
    let motion: Value = serde_json::from_slice(&read(results, "motion.json")).expect("JSON");
    let ends = |phases: &Value, patch: &str, end: &str, later: f64| -> Vec<(String, i64)> {
        let phases = phases.as_array().expect("phases").iter();
        phases
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
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = scandent(&["run", "irregular-stairs", "-o", path(folder.path())]);
    assert_done(&run, "run");
    let results = folder.path().join("irregular-stairs");
    let mut plan: Value = serde_json::from_slice(&read(&results, "plan.json")).expect("JSON");
    // Half a metre to the side: every foot off its surface.
    let y = plan["stances"][2]["q"][1]
        .as_f64()
        .expect("a base position");
    plan["stances"][2]["q"][1] = Value::from(y + 0.5);
    let broken = results.join("broken.json");
    std::fs::write(&broken, plan.to_string()).expect("writable");
    let output = scandent(&["verify", path(&broken)]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("stance 2"), "{text}");
}

/// Two steps of 0.15 m on a floor, as a mesh of boxes.
fn steps_obj() -> String {
    let boxes = [
        [-1.0, 3.0, -1.0, 1.0, -0.1, 0.0],
        [0.3, 0.7, -0.4, 0.4, 0.0, 0.15],
        [0.7, 2.2, -0.5, 0.5, 0.0, 0.30],
    ];
    let faces = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let mut text = String::new();
    for (number, [x0, x1, y0, y1, z0, z1]) in boxes.into_iter().enumerate() {
        for (x, y) in [(x0, y0), (x0, y1), (x1, y0), (x1, y1)] {
            text += &format!("v {x} {y} {z0}\nv {x} {y} {z1}\n");
        }
        for face in faces {
            let corners: Vec<String> = face
                .iter()
                .map(|i| (1 + i + 8 * number).to_string())
                .collect();
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    text
}

#[test]
fn a_known_mesh_is_climbed_without_any_scan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = folder.path().join("steps.obj");
    std::fs::write(&mesh, steps_obj()).expect("writable");
    let out = folder.path().join("out");
    let plan = |goal: &str, more: &[&str]| {
        let mut args = vec![
            "plan",
            "--mesh",
            path(&mesh),
            "--goal",
            goal,
            "-o",
            path(&out),
        ];
        args.extend(more);
        scandent(&args)
    };
    assert_done(&plan("1.4,0", &[]), "plan");
    let written: Value = serde_json::from_slice(&read(&out, "plan.json")).expect("JSON");
    let last = written["stances"]
        .as_array()
        .and_then(|s| s.last())
        .expect("a last stance");
    let base: Vec<f64> = (0..2).filter_map(|i| last["q"][i].as_f64()).collect();
    // The goal's tolerance, and the solver's.
    assert!(
        (base[0] - 1.4).abs() < 0.1001 && base[1].abs() < 0.1001,
        "{base:?}"
    );

    // A goal where the robot stands needs no step.
    assert_done(&plan("0,0", &[]), "a goal at the start");
    // In a wall, a metre under the floor, is no place for a base: the reason is said, no plan is
    // left over from before.
    let blocked = plan("1.4,0,-1.0", &["--set", "planner.nodes_max=30"]);
    assert!(matches!(blocked.status.code(), Some(3 | 4)));
    let text = String::from_utf8_lossy(&blocked.stdout).into_owned();
    assert!(text.contains("what blocks the way"), "{text}");
    assert!(out.join("partial_plan.json").exists() && !out.join("plan.json").exists());
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
        let output = scandent(&[
            "plan",
            "--mesh",
            path(&mesh),
            "--goal",
            "1.4,0",
            "--start",
            start,
            "-o",
            path(&out),
        ]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{start}: {text}");
        assert!(text.contains(word), "{start}: no {word:?} in: {text}");
        assert!(
            !out.exists(),
            "{start}: results of a start that is no stance"
        );
    }
}

#[test]
fn a_goal_out_of_reach_has_no_plan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let surfaces = folder.path().join("surfaces.json");
    std::fs::write(
        &surfaces,
        r#"{"format": "scandent-surfaces/1", "surfaces": []}"#,
    )
    .expect("writable");
    let out = folder.path().join("out");
    let args = [
        "plan",
        "--surfaces",
        path(&surfaces),
        "--goal",
        "2,0",
        "-o",
        path(&out),
    ];
    let output = scandent(&args);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(3), "{text}");
    let report: Value = serde_json::from_slice(&read(&out, "report.json")).expect("JSON");
    assert_eq!(report["path_stances"], 0);
    assert_eq!(report["surfaces"], 1, "the ground under the feet");
}
