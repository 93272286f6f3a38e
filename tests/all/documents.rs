//! What other programs meet: one JSON document of every command with `--json`, files by the standard input and output.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

use serde_json::Value;

use crate::schemas::assert_as_said;
use crate::support::program::{FLOOR, command, json, list, read, root, said, succeeds};

/// A short way over it.
const SCENE: &str = "name = \"floor\"\nmesh_file = \"floor.obj\"\nrobot = { urdf = \"builtin:quadruped\" }\n\
    goal = { base_position_m = [0.2, 0.0], tolerance_m = 0.1 }\n";
const ITEM: &str = r#"{"item": "a", "scene": "floor.toml"}"#;

/// Command lines with their exit codes, their status, and what their document must hold.
#[rustfmt::skip]
const LINES: &[(&str, i32, &str, &[&str])] = &[
    ("scenes", 0, "done", &["scenes"]),
    ("surfaces --mesh floor.obj -o surfaces.json --view", 0, "done", &["surfaces", "stages_ms", "written", "open", "next"]),
    ("plan --surfaces surfaces.json --robot builtin:quadruped --goal 0.2,0 -o out", 0, "done", &["report", "verified", "written"]),
    ("plan floor.toml --goal 9,9 -o no", 3, "no_plan", &["report", "written"]),
    ("plan floor.toml --goal 2,0 --set planner.nodes_max=1 -o no", 4, "undecided", &["unusable"]),
    ("plan floor.toml --no-such-flag", 2, "usage", &["error"]),
    ("run floor.toml -o runs", 0, "done", &["report", "open"]),
    ("bench floor.toml -o bench", 0, "done", &["worlds"]),
    ("batch items.jsonl -o batch", 0, "done", &["items"]),
    ("verify out/plan.json -o certificate.json", 0, "done", &["certificate", "written"]),
    #[cfg(feature = "mujoco")]
    ("simulate out/plan.json --hold", 0, "done", &["simulation", "written"]),
    ("export out/plan.json --format csv -o plan.csv", 0, "done", &["written"]),
    ("export out/plan.json --format csv", 2, "usage", &["error"]),
    ("view out/plan.json", 0, "done", &["open"]),
    ("posture-sets --robot builtin:quadruped --family easy --count 2 -o sets.json", 0, "done", &["problems"]),
    ("posture sets.json --robot builtin:quadruped -o answers.json", 0, "done", &["feasible", "written"]),
    ("robot builtin:quadruped", 0, "done", &["robot"]),
    ("config", 0, "done", &["settings"]),
    ("schemas -o schemas", 0, "done", &["written"]),
    ("completions bash", 0, "done", &["script"]),
    ("man -o man", 0, "done", &["pages"]),
    ("slope no.pcap", 1, "error", &["error"]),
    ("calibrate lidar no.pcap", 1, "error", &["error"]),
    ("calibrate camera --robot builtin:quadruped --poses no.csv --frames no", 1, "error", &["error"]),
];

fn in_folder(folder: &Path, line: &str, input: &[u8]) -> Output {
    let mut command = command(line, &[]);
    command.current_dir(folder).stdin(Stdio::piped());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    stdin.write_all(input).expect("written");
    drop(stdin);
    child.wait_with_output().expect("it ends")
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [
        ("floor.obj", FLOOR),
        ("floor.toml", SCENE),
        ("items.jsonl", ITEM),
    ] {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    folder
}

#[test]
fn every_command_tells_one_document() {
    let folder = folder();
    let (mut seen, mut files) = (BTreeSet::new(), Vec::new());
    for (line, code, status, names) in LINES {
        let output = in_folder(folder.path(), &format!("{line} --json"), &[]);
        let document: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|error| panic!("{line}: {error}: {}", said(&output)));
        assert_eq!(output.status.code(), Some(*code), "{line}: {document:#}");
        assert_eq!(document["exit_code"], *code, "{line}");
        assert_eq!(document["status"], *status, "{line}");
        for name in *names {
            assert!(!document[name].is_null(), "{line}: no {name}: {document:#}");
        }
        if document["error"].is_object() {
            assert_eq!(document["error"]["kind"], *status);
            assert!(document["error"]["message"].is_string());
        }
        for written in document["written"].as_array().into_iter().flatten() {
            let path = folder.path().join(written.as_str().expect("a path"));
            assert!(path.exists(), "{line}: {}", path.display());
        }
        seen.extend(line.split(' ').next());
        files.push(("document", document));
    }
    let item = json(folder.path().join("batch/items/a/item.json"));
    files.push(("bench_row", item["row"].clone()));
    files.push(("batch_item", item));
    #[cfg(feature = "mujoco")]
    files.push((
        "simulation",
        json(folder.path().join("out/simulation.json")),
    ));
    assert_as_said(&files);
    let help = succeeds("--help", &[]);
    let commands = help.lines().skip_while(|l| !l.starts_with("Commands:"));
    let commands = commands.skip(1).take_while(|l| !l.is_empty());
    // `serve` is asked for its document where it is served from.
    let other = |name: &&str| !["help", "serve"].contains(name);
    let commands = commands.filter_map(|line| line.split_whitespace().next());
    assert_eq!(commands.filter(other).collect::<BTreeSet<_>>(), seen);
}

/// Files given by a pipe say the same as by their names, and come out of one alike.
#[test]
fn files_go_in_and_out_by_pipes() {
    let folder = folder();
    let piped = |line: &str, input: &[u8]| {
        let output = in_folder(folder.path(), line, input);
        assert!(output.status.success(), "{line}: {}", said(&output));
        output.stdout
    };
    let file = |name: &str| read(folder.path().join(name));
    piped("surfaces --mesh floor.obj -o surfaces.json", &[]);
    let surfaces = piped("surfaces --mesh obj:- -o -", FLOOR.as_bytes());
    assert_eq!(String::from_utf8_lossy(&surfaces), file("surfaces.json"));
    let line = "plan --robot builtin:quadruped --goal 0.2,0 -o out --surfaces";
    piped(&format!("{line} surfaces.json"), &[]);
    let by_name = json(folder.path().join("out/plan.json"));
    piped(&format!("{line} -"), &surfaces);
    let by_pipe = json(folder.path().join("out/plan.json"));
    assert_eq!(by_name["stances"], by_pipe["stances"]);
    piped("run - -o runs", SCENE.as_bytes());
    piped("batch - -o batch", ITEM.as_bytes());
    assert!(file("batch/index.csv").contains("\na,solved"));
    // A plan's motion is looked for where the program runs.
    std::fs::copy(
        folder.path().join("out/motion.json"),
        folder.path().join("motion.json"),
    )
    .expect("a copy");
    let plan = file("out/plan.json");
    let certificate = piped("verify - -o -", plan.as_bytes());
    let certificate: Value = serde_json::from_slice(&certificate).expect("JSON");
    assert_eq!(certificate["pass"], true);
    let table = piped("export - --format csv", plan.as_bytes());
    assert!(String::from_utf8_lossy(&table).lines().count() > list(&by_name["stances"]).len());
    let page = piped("view - -o -", plan.as_bytes());
    assert!(page.starts_with(b"<!doctype html>"));
    // Of a robot the URDF, which may name no file beside itself but from the current folder on.
    let urdf = read(root("scenes/robots/quadruped/quadruped.urdf"));
    let told = piped("robot - --propose proposed", urdf.as_bytes());
    assert!(String::from_utf8_lossy(&told).contains("postures: standing"));
    assert!(folder.path().join("proposed/quadruped.srdf").is_file());
    let mesh = r#"<robot name="r"><link name="l"><collision><geometry><mesh filename="a.stl"/>"#;
    let mesh = format!("{mesh}</geometry></collision></link></robot>");
    let output = in_folder(folder.path(), "robot -", mesh.as_bytes());
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    for word in ["standard input", "current folder", "a.stl"] {
        assert!(words.contains(word), "{words}");
    }
}
