//! The crate arrows of ARCHITECTURE.md, asserted from `cargo metadata` and from the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates that each crate may depend on.
const ARROWS: &[(&str, &[&str])] = &[
    ("surfaces", &[]),
    ("perception", &["surfaces"]),
    ("calibration", &["perception"]),
    ("robot_model", &[]),
    ("plan", &["surfaces"]),
    ("posture", &["plan", "robot_model", "surfaces"]),
    ("motion", &["plan", "posture", "robot_model", "surfaces"]),
    (
        "planner",
        &["motion", "plan", "posture", "robot_model", "surfaces"],
    ),
    // Shares nothing with what it checks: no posture, no motion, no planner, no perception.
    ("verify", &["plan", "robot_model", "surfaces"]),
    ("scenes", &["perception", "robot_model", "surfaces"]),
    ("simulation", &["motion", "plan", "robot_model", "surfaces"]),
    ("record", &["scenes", "surfaces"]),
    (
        "scandent",
        &[
            "calibration",
            "motion",
            "perception",
            "plan",
            "planner",
            "posture",
            "robot_model",
            "scenes",
            "simulation",
            "surfaces",
            "verify",
        ],
    ),
];

/// Third-party crates that only the named crates may use, because one file hides them from the rest.
const GUARDED: &[(&str, &[&str])] = &[
    ("parry3d-f64", &["robot_model", "verify"]),
    ("glamx", &["robot_model"]),
    ("clarabel", &["posture"]),
    ("sqp-craft-activeset", &["posture", "simulation"]),
    ("mujoco-rs", &["simulation"]),
    ("kiddo", &["perception"]),
    ("urdf-rs", &["robot_model"]),
    ("anyhow", &["scandent", "record"]),
    ("clap", &["scandent", "record"]),
    ("indicatif", &["scandent"]),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The name of a package's library: the package `scandent-robot-model` has `robot_model`.
fn library(package: &str) -> String {
    match package.strip_prefix("scandent-") {
        Some(name) => name.replace('-', "_"),
        None => package.to_owned(),
    }
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
                .map(|d| library(d["name"].as_str().expect("name")))
                .collect();
            (library(package["name"].as_str().expect("name")), needed)
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

/// The files under `folder` in which the crate `name` is used.
fn uses(folder: &str, name: &str) -> Vec<String> {
    let mut files = Vec::new();
    rust_files(&root().join(folder), &mut files);
    files.sort();
    let path = format!("{}::", name.replace('-', "_"));
    let mut found = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a source file");
        let used = text.match_indices(&path).any(|(at, _)| {
            // `super::posture::` and `my_posture::` are other things of that name.
            !text[..at].ends_with(|c: char| c == ':' || c == '_' || c.is_alphanumeric())
        });
        if used {
            let relative = file.strip_prefix(root()).unwrap_or(&file);
            found.push(relative.display().to_string());
        }
    }
    found
}

#[test]
fn arrows_between_crates_only_point_downwards() {
    let dependencies = dependencies();
    let crates: BTreeSet<&str> = ARROWS.iter().map(|(name, _)| *name).collect();
    let listed: BTreeSet<&str> = dependencies.keys().map(String::as_str).collect();
    assert_eq!(
        listed, crates,
        "a crate without a rule, or a rule without a crate"
    );
    for (name, allowed) in ARROWS {
        for needed in dependencies[*name]
            .iter()
            .filter(|d| crates.contains(d.as_str()))
        {
            assert!(
                allowed.contains(&needed.as_str()),
                "{name} must not depend on {needed}; it may use {allowed:?}"
            );
        }
    }
}

#[test]
fn guarded_crates_stay_in_their_crates() {
    let dependencies = dependencies();
    for (guarded, crates) in GUARDED {
        let users: Vec<&str> = dependencies
            .iter()
            .filter(|(_, needed)| needed.contains(*guarded))
            .map(|(name, _)| name.as_str())
            .collect();
        for user in &users {
            assert!(
                crates.contains(user),
                "{user} must not use {guarded}; only {crates:?} may"
            );
        }
    }
}

#[test]
fn one_file_of_the_robot_model_converts_to_parrys_algebra() {
    for name in ["glamx", "parry3d-f64"] {
        let files = uses("robot_model/src", name);
        assert_eq!(
            files,
            ["robot_model/src/collision/parry.rs"],
            "files that use {name}"
        );
    }
}
