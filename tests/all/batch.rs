//! `scandent batch`: items planned one by one, whatever ends the program.
//!
//! Pass criteria: after any number of kills at any instant the same command ends with every item done, none
//! that was done is done again, and all files but those with times are the same bytes from 1 and from 2
//! shards; an item that makes no sense is a record and does not end the batch.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use crate::support::program::{command, ends_with, succeeds};

const ITEMS: &str = r#"
{"item": "one", "family": "ramp", "world_seed": 1, "robot": "builtin:quadruped"}
{"item": "none", "scene": "no-such-scene"}
{"item": "few", "family": "ramp", "world_seed": 2, "robot": "builtin:quadruped", "set": {"planner.nodes_max": 2}}
{"item": "two", "family": "ramp", "world_seed": 3, "robot": "builtin:quadruped"}
"#;

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.path() {
            path if path.is_dir() => found.extend(files(&path)),
            path => found.push(path),
        }
    }
    found
}

/// All bytes of a batch without times, by name.
fn results(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let timeless = |path: &PathBuf| !(path.ends_with("item.json") || path.ends_with("report.json"));
    let files = files(folder).into_iter().filter(timeless);
    let read = |path: PathBuf| {
        let bytes = std::fs::read(&path).expect("a result");
        (path.strip_prefix(folder).expect("inside").to_owned(), bytes)
    };
    files.map(read).collect()
}

/// The records of items, by the file that holds each.
fn records(folder: &Path) -> BTreeMap<PathBuf, u64> {
    let found = files(folder).into_iter().filter(|path| {
        // What stands beside its place is not there yet.
        let hidden = |part: std::path::Component| part.as_os_str().as_encoded_bytes()[0] == b'.';
        let inside = path.strip_prefix(folder).expect("inside");
        path.ends_with("item.json") && !inside.components().any(hidden)
    });
    found
        .map(|path| (path.clone(), path.metadata().expect("a record").ino()))
        .collect()
}

#[test]
fn a_batch_goes_on_after_kills_and_is_the_same_in_shards() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let manifest = folder.path().join("items.jsonl");
    std::fs::write(&manifest, ITEMS).expect("written");
    let whole = folder.path().join("whole");
    let words = [
        "4 items: 1 budget-spent, 1 error, 2 solved",
        "no-such-scene",
    ];
    ends_with(
        "batch @ -o @ --export npz --threads 2",
        &[&manifest, &whole],
        1,
        &words,
    );
    let wanted = results(&whole);
    assert!(wanted.contains_key(Path::new("items/one/motion.npz")));

    let shards = folder.path().join("shards");
    let mut kept = BTreeMap::new();
    for n in 0..24 {
        let wait_ms = 40 * n;
        let shard = format!(
            "batch @ -o @ --export npz --threads 1 --shard {}/2",
            1 + n % 2
        );
        let mut program = command(&shard, &[&manifest, &shards]);
        let mut child = program
            .stdout(Stdio::null())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(Duration::from_millis(wait_ms));
        child.kill().expect("it is killed");
        child.wait().expect("it ended");
        let now = records(&shards);
        let lost = kept
            .iter()
            .find(|(path, record)| now.get(*path) != Some(record));
        assert_eq!(lost, None, "after {wait_ms} ms");
        kept = now;
    }
    for (shard, code) in [("1/2", 0), ("2/2", 1)] {
        let line = format!("batch @ -o @ --export npz --shard {shard}");
        ends_with(&line, &[&manifest, &shards], code, &[]);
    }
    assert_eq!(results(&shards), wanted);

    let plan = shards.join("items/two/plan.json");
    let said = succeeds(
        "verify @ --against @",
        &[&plan, &plan.with_file_name("world.toml")],
    );
    assert!(!said.contains("if "), "{said}");
}

#[test]
fn a_manifest_that_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let manifest = folder.path().join("items.jsonl");
    std::fs::write(&manifest, "{\"item\": \"a\"}\n{\"item\": \"a\"}\n").expect("written");
    let out = folder.path().join("out");
    ends_with(
        "batch @ -o @",
        &[&manifest, &out],
        1,
        &["\"a\" is there twice"],
    );
    ends_with("batch @ -o @ --seed 3", &[&manifest, &out], 1, &["items"]);
    ends_with(
        "batch @ -o @",
        &[&folder.path().join("none"), &out],
        1,
        &["none"],
    );
}
