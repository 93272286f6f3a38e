//! The committed schemas are those of the program, and its files are as they say.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::support::program::{json, read, root, said, succeeds};
use crate::support::shipped::shipped;

#[test]
fn the_committed_schemas_are_current() {
    let folder = tempfile::tempdir().expect("a folder");
    succeeds("schemas -o @", &[folder.path()]);
    let names = |folder: &Path| {
        let entries = std::fs::read_dir(folder).expect("readable");
        let names = entries.map(|entry| entry.expect("readable").file_name());
        names.collect::<std::collections::BTreeSet<_>>()
    };
    let (committed, current) = (root("docs/schemas"), folder.path());
    assert_eq!(
        names(&committed),
        names(current),
        "scandent schemas -o docs/schemas"
    );
    for name in names(current) {
        let (committed, current) = (read(committed.join(&name)), read(current.join(&name)));
        assert_eq!(committed, current, "scandent schemas -o docs/schemas");
    }
}

/// Reads pairs of a schema and a file: the file is as the schema says and, with a key that is unknown, is not.
const VALIDATE: &str = r#"
import json, sys
from jsonschema import Draft202012Validator as Validator
for schema, file in zip(sys.argv[1::2], sys.argv[2::2]):
    schema, value = json.load(open(schema)), json.load(open(file))
    Validator.check_schema(schema)
    for error in Validator(schema).iter_errors(value):
        print(f"{file}: {error.json_path}: {error.message[:300]}")
    if schema.get("additionalProperties", True) is False and Validator(schema).is_valid({**value, "no_such_key": 1}):
        print(f"{file}: an unknown key passes")
"#;

/// Asserts that files are as the schemas of these names say; without Python's jsonschema that is skipped.
pub fn assert_as_said(files: &[(&str, Value)]) {
    let folder = tempfile::tempdir().expect("a folder");
    let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../python-venv/bin/python");
    let python = if venv.exists() {
        venv
    } else {
        "python3".into()
    };
    let mut command = Command::new(python);
    let can = command.args(["-c", "import jsonschema"]).output();
    if !can.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: no jsonschema for Python: scripts/test installs it");
        return;
    }
    let mut command = Command::new(command.get_program());
    command.args(["-c", VALIDATE]);
    for (number, (name, value)) in files.iter().enumerate() {
        let file = folder.path().join(format!("{number}-{name}.json"));
        std::fs::write(&file, value.to_string()).expect("writable");
        command
            .arg(root(&format!("docs/schemas/{name}.schema.json")))
            .arg(file);
    }
    let output = command.output().expect("Python starts");
    assert!(
        output.status.success() && output.stdout.is_empty(),
        "{}",
        said(&output)
    );
}

#[test]
fn files_are_as_the_schemas_say() {
    let folder = tempfile::tempdir().expect("a folder");
    let results = &shipped("irregular-stairs").results;
    let mut files: Vec<(&str, Value)> = ["certificate", "plan", "report", "search", "surfaces"]
        .map(|name| (name, json(results.join(format!("{name}.json")))))
        .into();
    let mut motion = json(results.join("motion.json"));
    // A few of some thousand samples: Python takes its time.
    let samples = motion["samples"].as_array_mut().expect("samples");
    samples.truncate(3);
    files.push(("motion", motion));
    let toml = |text: &str| -> Value { toml::from_str(text).expect("TOML") };
    for scene in scenes::names().filter_map(scenes::builtin) {
        files.push(("scene", toml(scene.toml)));
    }
    for robot in ["hrp2", "quadruped", "hexapod"] {
        let robot = scenes::builtin_robot(robot).expect("it ships");
        files.push(("contacts", toml(robot.contacts)));
    }
    files.push(("settings", toml(&succeeds("config", &[]))));
    let problems = folder.path().join("problems.json");
    let line = "posture-sets --robot builtin:hrp2 --family hard --count 12 -o @";
    succeeds(line, &[&problems]);
    files.push(("posture_problems", json(&problems)));
    assert_as_said(&files);
}
