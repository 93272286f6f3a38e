//! `scandent bench`: worlds that nobody made by hand, for every robot that ships.
//!
//! Pass criteria: the results are a line of JSON for each world, the same on other threads and in shards;
//! the scenes that it writes can be planned by themselves, and given to it again.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::support::program::{ends_with, succeeds};

/// The lines of a run's results, without times.
fn rows(folder: &Path) -> BTreeMap<String, Value> {
    let lines = std::fs::read_to_string(folder.join("results.jsonl")).expect("results");
    let rows = lines.lines().map(|line| {
        let mut row: Value = serde_json::from_str(line).expect("a line is JSON");
        let fields = row.as_object_mut().expect("an object");
        fields.retain(|key, _| !key.ends_with("_ms"));
        (row["world"].to_string(), row)
    });
    rows.collect()
}

#[test]
fn a_few_worlds_are_planned_alike_in_shards_and_on_threads() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = |name: &str, more: &str| {
        let output = folder.path().join(name);
        let line = "bench --family turn --family ribs --count 1 --robot builtin:hrp2 -o @";
        let said = succeeds(&format!("{line} {more}"), &[&output]);
        (rows(&output), said, output)
    };
    let (whole, said, output) = run("whole", "--threads 1");
    assert_eq!(whole.len(), 2, "{said}");
    assert!(said.contains("| **all** | hrp2 | 2 | 2 |"), "{said}");
    let mut parts = run("first", "--shard 1/2 --threads 2").0;
    parts.extend(run("second", "--shard 2/2 --threads 3").0);
    assert_eq!(parts, whole);
    let scene = output.join("worlds/ribs-hrp2-1.toml");
    let alone = succeeds("run @ -o @", &[&scene, &folder.path().join("alone")]);
    assert!(alone.contains("verified"), "{alone}");
    // Scenes that are given are a run, too.
    let said = succeeds("bench @ -o @", &[&scene, &folder.path().join("given")]);
    assert!(said.contains("ribs-hrp2-1: solved"), "{said}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    ends_with("bench --family moon", &[], 1, &["moon", "stairs-up"]);
    ends_with("bench --shard 3/2", &[], 2, &["1 ≤ i ≤ n"]);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let words = [
        "no-such.toml",
        "| **all** | the scene's | 1 | 0 | 0 | 0 | 0 | 0 | 1 |",
    ];
    ends_with("bench no-such.toml -o @", &[folder.path()], 1, &words);
}
