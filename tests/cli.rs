//! The command line as a user meets it: exit codes and messages.

use std::path::Path;
use std::process::{Command, Output};

fn scandent(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scandent"))
        .args(args)
        .env_remove("RUST_LOG")
        .output()
        .expect("the program starts")
}

fn code(output: &Output) -> i32 {
    output
        .status
        .code()
        .expect("the program was not killed by a signal")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Asserts the exit code and that stderr contains every one of `words`.
fn assert_fails(args: &[&str], expected: i32, words: &[&str]) {
    let output = scandent(args);
    let text = stderr(&output);
    assert_eq!(code(&output), expected, "{args:?}: {text}");
    for word in words {
        assert!(text.contains(word), "{args:?}: no {word:?} in: {text}");
    }
    assert!(!text.contains("panicked"), "{args:?}: {text}");
}

#[test]
fn a_wrong_command_line_is_a_usage_error() {
    assert_fails(&["--no-such-flag"], 2, &["--no-such-flag"]);
    assert_fails(&["no-such-command"], 2, &["no-such-command"]);
    assert_fails(&["run", "--threads", "0"], 2, &["--threads"]);
    assert_fails(&["run", "--seed", "minus-one"], 2, &["--seed"]);
    assert_fails(
        &["plan", "--goal", "1,far"],
        2,
        &["far", "not a finite number"],
    );
    assert_fails(&["plan", "--goal", "1,2,3,4,5"], 2, &["5 numbers given"]);
    assert_fails(
        &["export", "plan.json", "--format", "smoke"],
        2,
        &["mcc-yaml"],
    );
    assert_fails(
        &["plan", "--mesh", "a.stl", "--surfaces", "b.json"],
        2,
        &["cannot be used with"],
    );
}

#[test]
fn an_unknown_setting_lists_the_known_ones() {
    assert_fails(
        &["config", "--set", "planner.nodez_max=1"],
        2,
        &["nodez_max", "`nodes_max`"],
    );
    assert_fails(
        &["config", "--set", "plannner.nodes_max=1"],
        2,
        &["plannner", "`planner`"],
    );
    assert_fails(
        &["config", "--set", "planner.nodes_max=many"],
        2,
        &["planner.nodes_max=many"],
    );
    assert_fails(
        &["config", "--set", "planner.nodes_max"],
        2,
        &["table.key=value"],
    );
}

#[test]
fn a_missing_file_is_named() {
    let missing = "no/such/file.x";
    assert_fails(&["surfaces", missing], 1, &[missing]);
    assert_fails(&["surfaces", "--mesh", missing], 1, &[missing]);
    assert_fails(&["verify", missing], 1, &[missing]);
    assert_fails(&["view", missing, "-o", "x.html"], 1, &[missing]);
    assert_fails(&["export", missing, "--format", "csv"], 1, &[missing]);
    assert_fails(&["robot", missing], 1, &[missing]);
    assert_fails(&["run", "no/such/scene.toml"], 1, &["no/such/scene.toml"]);
    assert_fails(
        &["plan", "--surfaces", missing, "--goal", "1,0"],
        1,
        &[missing],
    );
    assert_fails(
        &[
            "posture",
            missing,
            "--robot",
            "builtin:hrp2",
            "-o",
            "x.json",
        ],
        1,
        &[missing],
    );
    assert_fails(&["config", "--config", missing], 1, &[missing]);
}

#[test]
fn an_unknown_scene_or_robot_lists_those_that_ship() {
    assert_fails(
        &["run", "iregular-stairs"],
        1,
        &["iregular-stairs", "irregular-stairs"],
    );
    assert_fails(&["robot", "builtin:hrp3"], 1, &["hrp3", "hrp2"]);
}

#[test]
fn the_printed_settings_can_be_read_back() {
    let changed = scandent(&["config", "--set", "planner.nodes_max=123"]);
    assert_eq!(code(&changed), 0, "{}", stderr(&changed));
    assert!(stdout(&changed).contains("nodes_max = 123"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("settings.toml");
    std::fs::write(&file, &changed.stdout).expect("writable");
    let again = scandent(&["config", "--config", file.to_str().expect("UTF-8")]);
    assert_eq!(stdout(&again), stdout(&changed));
}

#[test]
fn a_broken_settings_file_names_file_and_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("broken.toml");
    std::fs::write(&file, "[planner]\nnodes_max = = 3\n").expect("writable");
    assert_fails(
        &["config", "--config", file.to_str().expect("UTF-8")],
        1,
        &["broken.toml", "line 2"],
    );
}

#[test]
fn every_scene_that_ships_is_listed_with_what_it_shows() {
    let output = scandent(&["scenes"]);
    assert_eq!(code(&output), 0);
    let text = stdout(&output);
    for scene in ["irregular-stairs", "slope-and-hand"] {
        let line = text
            .lines()
            .find(|line| line.contains(scene))
            .unwrap_or_default();
        assert!(
            line.len() > scene.len() + 20,
            "no description of {scene}: {text}"
        );
    }
}

#[test]
fn the_robot_that_ships_is_described() {
    let output = scandent(&["robot", "builtin:hrp2"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for word in ["30 joints", "left_foot", "right_foot", "half_sitting"] {
        assert!(text.contains(word), "no {word:?} in: {text}");
    }
}

/// Ids and number of the surfaces in a file.
fn surface_ids(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).expect("written");
    let set = surfaces::SurfaceSet::from_json(&text).expect("a set of surfaces");
    set.surfaces.into_iter().map(|s| s.id).collect()
}

#[test]
fn several_scans_are_one_set_and_can_be_registered() {
    let scan = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/scenes/scenes/irregular-stairs_depth.png"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("surfaces.json");
    let out = file.display().to_string();
    let (here, off) = (
        "0,0,1.3,-0.6,0.6,-0.37416573867,0.37416573867",
        "0.01,0,1.31,-0.6,0.6,-0.37416573867,0.37416573867",
    );
    let run = |more: &[&str]| {
        let output = scandent(&[&["surfaces", "-o", &out], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        (stdout(&output), surface_ids(&file))
    };
    let (_, single) = run(&[scan, "--pose", here]);
    // The same scan twice: every face is found again, and keeps its name.
    let twice = [scan, scan, "--pose", here, "--pose", here];
    let (told, both) = run(&twice);
    assert!(told.contains("are one face"), "{told}");
    assert!(!told.contains("warning"), "{told}");
    let kept = both.iter().filter(|id| single.contains(id)).count();
    assert!(2 * kept > single.len(), "{single:?} became {both:?}");
    assert!(both.len() < single.len() + single.len() / 2);
    let (_, apart) = run(&[&twice[..], &["--set", "surfaces.merge.enabled=false"]].concat());
    assert_eq!(apart.len(), 2 * single.len());
    // Stairs ahead and no wall beside: a shift is left open, and named.
    let refine = ["--set", "perception.registration.refine=true"];
    let moved = [scan, scan, "--pose", here, "--pose", off];
    let (told, _) = run(&[&moved[..], &refine].concat());
    let stays = told.contains("stays at the pose given");
    assert!(
        stays && told.contains("do not determine the shift along"),
        "{told}"
    );
}

#[test]
fn completions_name_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let output = scandent(&["completions", shell]);
        assert_eq!(code(&output), 0);
        assert!(stdout(&output).contains("surfaces"), "{shell}");
    }
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    if !Path::new("/bin/sh").exists() {
        eprintln!("SKIPPED: no /bin/sh to make a pipe with");
        return;
    }
    // `true` closes the pipe at once; the completions are larger than a pipe holds.
    let program = env!("CARGO_BIN_EXE_scandent");
    let script = format!("{{ '{program}' completions zsh; echo $? >&2; }} | true");
    let output = Command::new("/bin/sh")
        .args(["-c", &script])
        .output()
        .expect("sh");
    assert_eq!(stderr(&output).trim(), "0");
}
