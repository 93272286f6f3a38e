//! Ctrl-C: the search stops, and what it has is written as what it is.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::support::program::{assert_ended, command};

#[test]
fn an_interrupted_search_writes_the_way_so_far() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("results");
    // Beside the stairs there is nothing to stand on, which no length proves; the budget is far beyond
    // what can be searched.
    let budget = "--set planner.nodes_max=1000000 --set planner.candidates_max=10000000";
    let line = format!("plan irregular-stairs --goal 1.5,0.72 -o @ {budget}");
    let mut program = command(&line, &[&out]);
    let program = program.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = program.spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(1500));
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(
        killed.expect("kill").success(),
        "the search ended before it was interrupted"
    );
    let output = child.wait_with_output().expect("the program ends");
    assert_ended(&output, 4, &["interrupted"]);
    assert!(out.join("partial_plan.json").exists());
    assert!(
        !out.join("plan.json").exists(),
        "an unfinished plan must not be called a plan"
    );
    assert!(out.join("report.json").exists() && out.join("surfaces.json").exists());
}
