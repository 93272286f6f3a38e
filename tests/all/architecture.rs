//! The crate arrows of ARCHITECTURE.md, asserted from `cargo metadata` and from the sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::support::program::{list, root};

/// The crates that each crate may depend on.
const ARROWS: &[(&str, &str)] = &[
    ("elementary", ""),
    ("surfaces", ""),
    ("perception", "surfaces"),
    ("calibration", "perception"),
    ("robot_model", ""),
    ("plan", "surfaces"),
    ("posture", "plan robot_model surfaces"),
    ("motion", "plan posture robot_model surfaces"),
    ("planner", "motion plan posture robot_model surfaces"),
    // Shares nothing with what it checks: no posture, no motion, no planner, no perception.
    ("verify", "plan robot_model surfaces"),
    ("scenes", "perception robot_model surfaces"),
    ("simulation", "motion plan robot_model surfaces"),
    ("record", "scenes surfaces"),
    (
        "scandent",
        "calibration elementary motion perception plan planner posture robot_model scenes simulation surfaces \
         verify",
    ),
    (
        "python",
        "perception plan planner posture robot_model scandent scenes surfaces verify",
    ),
];

/// Third-party crates that only the named crates may use, because one file hides them from the rest.
const GUARDED: &[(&str, &[&str])] = &[
    ("libm", &["elementary"]),
    ("parry3d-f64", &["robot_model", "verify"]),
    ("glamx", &["robot_model"]),
    ("clarabel", &["posture"]),
    ("sqp-craft-activeset", &["posture", "simulation"]),
    ("mujoco-rs", &["simulation"]),
    ("kiddo", &["perception"]),
    ("urdf-rs", &["robot_model"]),
    ("gltf", &["robot_model"]),
    ("anyhow", &["scandent", "python", "record"]),
    ("clap", &["scandent", "record"]),
    ("pyo3", &["python"]),
    // The one reads numpy's archives, the other writes them.
    ("zip", &["perception", "scandent"]),
    ("tiff", &["perception"]),
    ("indicatif", &["scandent"]),
    ("minijinja", &["scandent", "simulation"]),
];

/// The name of a package's library: the package `scandent-robot-model` has `robot_model`.
fn library(package: &str) -> String {
    match package.strip_prefix("scandent-") {
        Some(name) => name.replace('-', "_"),
        None => package.to_owned(),
    }
}

/// Every workspace package with the names of its normal and build dependencies.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let mut cargo = Command::new(env!("CARGO"));
    let args = "metadata --format-version 1 --no-deps --offline";
    let cargo = cargo.args(args.split(' ')).current_dir(root(""));
    let output = cargo.output().expect("cargo metadata runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo metadata failed: {error}");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let name = |package: &Value| library(package["name"].as_str().expect("a name"));
    let needed = |package: &Value| {
        // `kind` is null for normal dependencies; tests may look upwards.
        let normal = list(&package["dependencies"]).iter();
        normal.filter(|d| d["kind"] != "dev").map(name).collect()
    };
    let packages = list(&metadata["packages"]).iter();
    packages.map(|p| (name(p), needed(p))).collect()
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
    rust_files(&root(folder), &mut files);
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
            let relative = file.strip_prefix(root("")).unwrap_or(&file);
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
    // No crate without a rule, no rule without a crate.
    assert_eq!(listed, crates);
    for (name, allowed) in ARROWS {
        let needed = dependencies[*name].iter().map(String::as_str);
        for needed in needed.filter(|d| crates.contains(d)) {
            let may = allowed.split(' ').any(|name| name == needed);
            assert!(may, "{name} must not depend on {needed}: {allowed}");
        }
    }
}

#[test]
fn guarded_crates_stay_in_their_crates() {
    let dependencies = dependencies();
    for (guarded, crates) in GUARDED {
        for (user, needed) in &dependencies {
            let may = crates.contains(&user.as_str()) || !needed.contains(*guarded);
            assert!(may, "{user} must not use {guarded}; only {crates:?} may");
        }
    }
}

#[test]
fn one_file_of_the_robot_model_converts_to_parrys_algebra() {
    for name in ["glamx", "parry3d-f64"] {
        let users = uses("robot_model/src", name);
        assert_eq!(users, ["robot_model/src/collision/parry.rs"], "{name}");
    }
}
