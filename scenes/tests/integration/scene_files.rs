//! Scene files: those that ship are complete, and a bad one is refused by the name of its field.

use proptest::prelude::*;
use scenes::{Error, SceneFile};

fn stairs() -> &'static str {
    scenes::builtin("irregular-stairs").unwrap().toml
}

#[test]
fn shipped_scenes_name_only_what_ships() {
    let names = "irregular-stairs slope-and-hand hexapod-obstacles slope-10.5 slope-13.5 \
                 slope-15.3 slope-17.4 slope-19.7 slope-22 slope-23.8 slope-10.5-at-30 \
                 slope-23.8-at-30";
    assert_eq!(scenes::names().collect::<Vec<_>>().join(" "), names);
    for scene in scenes::names().filter_map(scenes::builtin) {
        let file = SceneFile::parse(scene.toml).unwrap();
        assert_eq!(file.name, scene.name);
        assert_eq!((scene.truth)().scene, scene.name);
        let files = file.scan.iter();
        let files = files
            .flat_map(|s| [&s.depth, &s.cloud, &s.extrinsics])
            .flatten();
        let named: Vec<&str> = files.map(String::as_str).collect();
        let shipped = scene.files.iter().map(|f| f.0).chain(scene.sweep);
        assert_eq!(named, shipped.collect::<Vec<_>>());
        for name in named {
            let bytes = scene.file(name);
            assert!(bytes.is_some_and(|bytes| !bytes.is_empty()), "{name}");
        }
        let robot = file.robot.urdf.strip_prefix("builtin:").unwrap();
        let robot = scenes::builtin_robot(robot).unwrap();
        let contacts: toml::Table = robot.contacts.parse().unwrap();
        let patches = contacts["patch"].as_array().unwrap().iter();
        let patches: Vec<&str> = patches.map(|p| p["name"].as_str().unwrap()).collect();
        for patch in file.start.contacts.iter().chain(file.friction.patch.keys()) {
            assert!(patches.contains(&patch.as_str()), "{patch}");
        }
        let posture = file.start.posture.as_deref().unwrap();
        let state = format!("group_state name=\"{posture}\"");
        assert!(robot.srdf.contains(&state), "{state}");
        let ahead = match (scene.sensor, scene.sweep) {
            (Some(_), _) => 1.0,
            (None, Some(_)) if scene.name.ends_with("-at-30") => 3.3,
            (None, Some(_)) => 3.2,
            (None, None) => 2.0,
        };
        assert_eq!(file.goal.base_position_m, Some(vec![ahead, 0.0]));
    }
    let degrees = |name: &str| scenes::builtin(name).map(|scene| scene.name);
    assert_eq!(degrees("slope-15"), Some("slope-15.3"));
    assert_eq!(degrees("slope-16"), None);
    assert_eq!(degrees("irregular-stair"), None);
    assert!(scenes::builtin("no such scene").is_none());
    assert!(scenes::builtin_robot("no such robot").is_none());
}

#[test]
fn a_scene_file_survives_writing_and_reading() {
    for scene in scenes::names().filter_map(scenes::builtin) {
        let file = SceneFile::parse(scene.toml).unwrap();
        let written = toml::to_string(&file).unwrap();
        assert_eq!(SceneFile::parse(&written).unwrap(), file);
    }
}

#[test]
fn a_value_that_makes_no_sense_is_refused_by_name() {
    // Text of a scene that ships => what takes its place, lines parted by ¶ ! the field refused.
    let table = r#"
        name = "irregular-stairs" => name = "" ! name
        [[scan]] => mesh_file = "room.stl"¶[[scan]] ! scan
        sensor = "xtion" => ! scan[0]
        sensor = "xtion" => sensor = "xtion"¶fx = 525.0 ! scan[0]
        sensor = "xtion" => sensor = "xtion"¶cloud = "a.pcd" ! scan[0]
        position_m = [0.08 => position_m = [nan, 0, 1]¶# ! scan[0].position_m
        quat_xyzw = [0.0, => quat_xyzw = [0.1, ! scan[0].quat_xyzw
        base_position_m = [0.0, 0.0, 0.6487] => base_position_m = [0, 0, inf] ! start.base_position_m
        contacts = ["left_foot", "right_foot"] => contacts = [] ! start.contacts
        contacts = ["left_foot", "right_foot"] => contact = [{ patch = "left_foot", position_m = [0, 0, 0] }] ! start
        base_position_m = [2.0, 0.0] => ! goal
        base_position_m = [2.0, 0.0] => base_position_m = [2.0] ! goal.base_position_m
        tolerance_m = 0.10 => tolerance_m = 0 ! goal.tolerance_m
        tolerance_m = 0.10 => yaw_rad = inf ! goal.yaw_rad
        tolerance_m = 0.10 => [[goal.contact]]¶patch = "left_foot" ! goal.contact[0]
        tolerance_m = 0.10 => [guide]¶key_postures = [[0, 0, nan, 0]] ! guide.key_postures[0]
        default = 0.6 => default = -0.6 ! friction: default
        default = 0.6 => patch.left_foot = 0 ! friction: left_foot
    "#;
    for case in table.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (edit, wanted) = case.split_once(" ! ").unwrap();
        let (from, to) = edit.split_once(" =>").unwrap();
        assert!(stairs().contains(from), "nothing to edit: {from}");
        let text = stairs().replacen(from, &to.trim().replace('¶', "\n"), 1);
        match SceneFile::parse(&text) {
            Err(Error::Field { field, .. }) => assert_eq!(field, wanted, "{case}"),
            other => panic!("{case}: {other:?}"),
        }
    }
}

#[test]
fn an_unknown_key_is_refused_with_its_line() {
    let text = stairs().replacen("tolerance_m", "tolerance_mm", 1);
    let message = SceneFile::parse(&text).unwrap_err().to_string();
    let named = message.contains("tolerance_mm") && message.contains("line");
    assert!(named, "{message}");
}

#[test]
fn all_that_is_wrong_is_told_at_once() {
    for (edits, told) in [
        (
            "name = \"irregular-stairs\" => name = \"\" ¶ quat_xyzw = [0.0, => quat_xyzw = [0.1, ¶ tolerance_m = 0.10 => tolerance_m = 0",
            &[
                "`name`: is empty",
                "`scan[0].quat_xyzw`: has length",
                "`goal.tolerance_m`: is not",
            ][..],
        ),
        (
            "tolerance_m = 0.10 => tolerance = 1 ¶ default = 0.6 => default = \"ice\" ¶ sensor = => sensors =",
            &[
                "unknown field `tolerance`",
                "invalid type: string \"ice\"",
                "unknown field `sensors`",
            ],
        ),
    ] {
        let mut text = stairs().to_owned();
        for edit in edits.split(" ¶ ") {
            let (from, to) = edit.split_once(" => ").unwrap();
            assert!(text.contains(from), "there is no {from}");
            text = text.replacen(from, to, 1);
        }
        let said = SceneFile::parse(&text).unwrap_err().to_string();
        for part in told {
            assert!(said.contains(part), "{said}\nlacks {part}");
        }
        assert_eq!(said.matches("\n  - ").count(), told.len(), "{said}");
    }
}

proptest! {
    /// A mutilated scene file is refused or read, and never panics.
    #[test]
    fn mutilated_files_do_not_panic(at in 0usize..900, cut in 0usize..40, byte in 32u8..127) {
        let mut bytes = stairs().as_bytes().to_vec();
        let at = at.min(bytes.len() - 1);
        bytes.drain(at..(at + cut).min(bytes.len()));
        bytes.insert(at, byte);
        if let Ok(text) = std::str::from_utf8(&bytes) {
            let _ = SceneFile::parse(text);
        }
    }
}
