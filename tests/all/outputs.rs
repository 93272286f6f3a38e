//! Results are the old ones or the new ones, whatever happens: nothing else is replaced, and nothing
//! is half there after a full disk or a kill at any moment.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::program::{FLOOR, assert_ended, command, ends_with, json, read, succeeds};

const LINE: &str = "plan --mesh @ --robot builtin:quadruped --goal";

#[test]
fn devices_links_folders_and_inputs_are_not_replaced() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let mesh = at("floor.obj");
    std::fs::write(&mesh, FLOOR).expect("writable");
    std::os::unix::fs::symlink(&mesh, at("link")).expect("a link");
    std::fs::hard_link(&mesh, at("hard.obj")).expect("a second name");
    let hard = at("hard.obj");
    for (path, why) in [
        (mesh.as_path(), "this file is an input"),
        (&hard, "this file is an input"),
        (&at("link"), "a link is there"),
        (folder.path(), "a folder is there"),
        (Path::new("/dev/full"), "a device or pipe is there"),
        (&at("floor.obj/x.json"), "cannot be written"),
    ] {
        ends_with("surfaces --mesh @ -o @", &[&mesh, path], 1, &[why]);
        assert_eq!(read(&mesh), FLOOR);
    }
    // Neither is an input in the folder of results, and what else is there stays.
    let results = at("results");
    std::fs::create_dir_all(results.join("pictures")).expect("a folder");
    let surfaces = results.join("surfaces.json");
    succeeds("surfaces --mesh @ -o @", &[&mesh, &surfaces]);
    let line = "plan --robot builtin:quadruped --goal 0.2,0 --surfaces @ -o @";
    ends_with(
        line,
        &[&surfaces, &results],
        1,
        &["surfaces.json in it is an input"],
    );
    ends_with(
        &format!("{LINE} 0.2,0 -o @"),
        &[&mesh, &mesh],
        1,
        &["a file is there"],
    );
    assert_eq!(read(&mesh), FLOOR);
    succeeds(&format!("{LINE} 0.2,0 -o @"), &[&mesh, &results]);
    assert!(results.join("pictures").is_dir() && results.join("plan.json").is_file());
}

#[test]
fn results_are_written_though_nobody_reads_the_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, results) = floor_in(folder.path());
    let mut run = command(&format!("{LINE} 0.2,0 -o @"), &[&mesh, &results]);
    let mut run = run.stdout(Stdio::piped()).spawn().expect("it starts");
    drop(run.stdout.take());
    assert!(run.wait().expect("it ends").success());
    assert!(results.join("plan.json").is_file());
}

#[test]
fn a_full_disk_leaves_the_old_results() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, results) = floor_in(folder.path());
    succeeds(&format!("{LINE} 0.2,0 -o @"), &[&mesh, &results]);
    let before = contents(&results);
    // No file may grow beyond so many kilobytes: some of the results fit.
    for kilobytes in [1, 8, 64, 256] {
        let program = command(&format!("{LINE} 0.5,0 -o @"), &[&mesh, &results]);
        let limited = format!("trap '' XFSZ; ulimit -f {kilobytes}; exec \"$@\"");
        let mut shell = Command::new("bash");
        shell
            .args(["-c", &limited, "bash"])
            .arg(program.get_program());
        let output = shell
            .args(program.get_args())
            .output()
            .expect("bash starts");
        assert_ended(&output, 1, &["cannot be written", "results"]);
        assert_eq!(contents(&results), before);
    }
    let beside = std::fs::read_dir(folder.path()).expect("readable").count();
    assert_eq!(beside, 2, "something was left beside the results");
}

/// A mesh of a floor in a folder, and where results go beside it.
fn floor_in(folder: &Path) -> (PathBuf, PathBuf) {
    let mesh = folder.join("floor.obj");
    std::fs::write(&mesh, FLOOR).expect("writable");
    (mesh, folder.join("results"))
}

/// Names and contents of the files in a folder.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("readable");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.is_file())
        .map(|path| {
            let bytes = std::fs::read(&path).expect("readable");
            (path.display().to_string(), bytes)
        })
        .collect();
    files.sort();
    files
}

#[test]
fn a_kill_at_any_moment_leaves_old_or_new_results() {
    // More of them by `KILLS=100`.
    let kills: u32 = std::env::var("KILLS").map_or(20, |n| n.parse().expect("a number"));
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, results) = floor_in(folder.path());
    // Two plans of different lengths in turns.
    let line = |n: u32| format!("{LINE} {},0 -o @", ["0.2", "0.7"][n as usize % 2]);
    let begin = Instant::now();
    succeeds(&line(0), &[&mesh, &results]);
    let takes = begin.elapsed();
    std::fs::write(results.join("notes.txt"), "mine").expect("writable");
    std::fs::create_dir(results.join("pictures")).expect("a folder");
    let mut ended = 0;
    for n in 1..=kills {
        let mut program = command(&line(n), &[&mesh, &results]);
        let program = program.stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = program.spawn().expect("the program starts");
        // Moments spread evenly over a run and somewhat beyond, by the golden ratio.
        let moment = 0.5 + 0.8 * (f64::from(n) * 0.618_034).fract();
        std::thread::sleep(Duration::from_secs_f64(moment * takes.as_secs_f64()));
        child.kill().expect("killed, or ended");
        ended += u32::from(child.wait().expect("ended").success());
        one_run(&results);
    }
    assert!(ended < kills, "every run ended before it was killed");
    succeeds(&line(1), &[&mesh, &results]);
    assert!(results.join("pictures").is_dir());
    let beside = std::fs::read_dir(folder.path()).expect("readable").count();
    assert_eq!(beside, 2, "something was left beside the results");
}

/// Asserts that all results are there and of one run.
fn one_run(results: &Path) {
    let (plan, report) = (
        json(results.join("plan.json")),
        json(results.join("report.json")),
    );
    assert_eq!(report["motion_s"], plan["motion"]["duration_s"]);
    succeeds("verify @", &[&results.join("plan.json")]);
    for name in [
        "motion.json",
        "certificate.json",
        "plan.csv",
        "view.html",
        "notes.txt",
    ] {
        assert!(results.join(name).is_file(), "{name}");
    }
}
