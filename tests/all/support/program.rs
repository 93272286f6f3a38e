//! The program as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use robot_model::Robot;
use serde_json::Value;

/// The program with the words of `line`, each `@` of it the next of `paths`; not yet started.
pub fn command(line: &str, paths: &[&Path]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scandent"));
    let mut paths = paths.iter();
    for word in line.split_whitespace() {
        match word {
            "@" => command.arg(paths.next().expect("a path for each @")),
            _ => command.arg(word),
        };
    }
    assert!(paths.next().is_none(), "more paths than @ in {line}");
    command.env_remove("RUST_LOG");
    command
}

/// Runs it to its end.
pub fn scandent(line: &str, paths: &[&Path]) -> Output {
    command(line, paths).output().expect("the program starts")
}

/// What it printed, standard error last.
pub fn said(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// Runs it, asserts that it succeeded and returns what it printed.
#[track_caller]
pub fn succeeds(line: &str, paths: &[&Path]) -> String {
    ends_with(line, paths, 0, &[])
}

/// Runs it and asserts its exit code, each of `words` in what it printed, and that nothing panicked.
#[track_caller]
pub fn ends_with(line: &str, paths: &[&Path], code: i32, words: &[&str]) -> String {
    assert_ended(&scandent(line, paths), code, words)
}

/// As [`ends_with`], of a run that ended.
#[track_caller]
pub fn assert_ended(output: &Output, code: i32, words: &[&str]) -> String {
    let text = said(output);
    assert_eq!(output.status.code(), Some(code), "{text}");
    for word in words {
        assert!(text.contains(word), "no {word:?} in: {text}");
    }
    assert!(!text.contains("panicked"), "{text}");
    text
}

/// A floor to walk on, as a Wavefront OBJ.
pub const FLOOR: &str = "v -2 -2 0\nv 3 -2 0\nv 3 2 0\nv -2 2 0\nf 1 2 3 4\n";

/// A file of this repository.
pub fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A file that was written.
#[track_caller]
pub fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A JSON file that was written.
#[track_caller]
pub fn json(path: impl AsRef<Path>) -> Value {
    serde_json::from_str(&read(path)).expect("JSON")
}

/// A number of a JSON file.
#[track_caller]
pub fn number(value: &Value) -> f64 {
    let number = value.as_f64();
    number.unwrap_or_else(|| panic!("{value} is no number"))
}

/// The items of a list of a JSON file.
#[track_caller]
pub fn list(value: &Value) -> &[Value] {
    let items = value.as_array();
    items.unwrap_or_else(|| panic!("{value} is no list"))
}

/// A robot that ships.
pub fn robot(name: &str) -> Robot {
    scenes::robot(name).expect("it ships")
}

/// Points, m, as a PLY file.
pub fn ply(points: &[[f64; 3]]) -> String {
    let axes = ["x", "y", "z"].map(|axis| format!("property float {axis}\n"));
    let (count, axes) = (points.len(), axes.concat());
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex {count}\n{axes}end_header\n");
    for [x, y, z] in points {
        text += &format!("{x:.6} {y:.6} {z:.6}\n");
    }
    text
}
