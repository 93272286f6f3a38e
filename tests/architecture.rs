//! The crate arrows of ARCHITECTURE.md, asserted from `cargo metadata` and from the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The rooms that each room may depend on.
const ARROWS: &[(&str, &[&str])] = &[
    ("surfaces", &[]),
    ("perception", &["surfaces"]),
    ("calibration", &["perception"]),
    ("robot_model", &[]),
    ("posture", &["robot_model", "surfaces"]),
    ("motion", &["posture", "robot_model", "surfaces"]),
    ("planner", &["motion", "posture", "robot_model", "surfaces"]),
    ("scenes", &["perception", "robot_model", "surfaces"]),
    ("simulation", &["motion", "robot_model", "surfaces"]),
    (
        "scandent",
        &[
            "calibration",
            "motion",
            "perception",
            "planner",
            "posture",
            "robot_model",
            "scenes",
            "simulation",
            "surfaces",
        ],
    ),
];

/// Third-party crates that only the named rooms may use, because one file hides them from the rest.
const GUARDED: &[(&str, &[&str])] = &[
    ("parry3d-f64", &["robot_model", "scandent"]),
    ("glamx", &["robot_model", "scandent"]),
    ("clarabel", &["posture"]),
    ("sqp-craft-activeset", &["posture", "simulation"]),
    ("mujoco-rs", &["simulation"]),
    ("kiddo", &["perception"]),
    ("anyhow", &["scandent"]),
    ("clap", &["scandent"]),
    ("indicatif", &["scandent"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every workspace package with the names of its normal and build dependencies.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(root())
        .output()
        .expect("cargo metadata runs");
    assert!(
        output.status.success(),
        "cargo metadata failed: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    packages
        .iter()
        .map(|package| {
            let needed = package["dependencies"]
                .as_array()
                .expect("dependencies")
                .iter()
                // `kind` is null for normal dependencies; tests may look upwards.
                .filter(|d| d["kind"] != "dev")
                .map(|d| d["name"].as_str().expect("name").to_owned())
                .collect();
            (package["name"].as_str().expect("name").to_owned(), needed)
        })
        .collect()
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a source folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Where under `folder` the crate `name` is used: `file: path` for every path that begins with it
/// and with none of `except`.
fn uses(folder: &str, name: &str, except: &[&str]) -> Vec<String> {
    let mut files = Vec::new();
    rust_files(&root().join(folder), &mut files);
    files.sort();
    let path = format!("{}::", name.replace('-', "_"));
    let mut found = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source file");
        let used = text.match_indices(&path).any(|(at, _)| {
            // `super::posture::` and `my_posture::` are other things of that name.
            let begins =
                !text[..at].ends_with(|c: char| c == ':' || c == '_' || c.is_alphanumeric());
            begins && !except.iter().any(|prefix| text[at..].starts_with(prefix))
        });
        if used {
            let relative = file.strip_prefix(root()).unwrap_or(&file);
            found.push(relative.display().to_string());
        }
    }
    found
}

#[test]
fn arrows_between_rooms_only_point_downwards() {
    let dependencies = dependencies();
    let rooms: BTreeSet<&str> = ARROWS.iter().map(|(room, _)| *room).collect();
    let listed: BTreeSet<&str> = dependencies.keys().map(String::as_str).collect();
    assert_eq!(
        listed, rooms,
        "a room without a rule, or a rule without a room"
    );
    for (room, allowed) in ARROWS {
        for needed in dependencies[*room]
            .iter()
            .filter(|d| rooms.contains(d.as_str()))
        {
            assert!(
                allowed.contains(&needed.as_str()),
                "{room} must not depend on {needed}; it may use {allowed:?}"
            );
        }
    }
}

#[test]
fn guarded_crates_stay_in_their_rooms() {
    let dependencies = dependencies();
    for (guarded, rooms) in GUARDED {
        let users: Vec<&str> = dependencies
            .iter()
            .filter(|(_, needed)| needed.contains(*guarded))
            .map(|(room, _)| room.as_str())
            .collect();
        for user in &users {
            assert!(
                rooms.contains(user),
                "{user} must not use {guarded}; only {rooms:?} may"
            );
        }
    }
}

#[test]
fn the_application_uses_parry_in_the_verifier_only() {
    for name in ["parry3d-f64", "glamx"] {
        for file in uses("src", name, &[]) {
            assert!(
                file.starts_with("src/verify/"),
                "{file} uses {name}; only src/verify may"
            );
        }
    }
}

#[test]
fn the_verifier_shares_nothing_with_the_solver() {
    let solver = [
        uses("src/verify", "posture", &[]),
        // The plan's file format is data.
        uses("src/verify", "planner", &["planner::plan::"]),
        uses(
            "src/verify",
            "motion",
            &["motion::record::", "motion::check("],
        ),
    ]
    .concat();
    assert!(
        solver.is_empty(),
        "{solver:?} use what they are there to check"
    );
}

#[test]
fn one_file_of_the_robot_model_converts_to_parrys_algebra() {
    for name in ["glamx", "parry3d-f64"] {
        let files = uses("robot_model/src", name, &[]);
        assert_eq!(
            files,
            ["robot_model/src/collision/parry.rs"],
            "files that use {name}"
        );
    }
}
