//! Starts in the middle of a way: as an earlier plan or the robot's own joints have it.
//!
//! Pass criteria: from each stance of a plan but the last, on one foot or two, `--start-stance` leads to the goal with a
//! certificate; it begins where the plan has the robot, to 0.01 m and 0.02 rad; the same start in a scene file, by its
//! joints, is the same plan. A joint that is not there or beyond its limits is said. A robot walks on without a foot that is
//! excluded.

use std::path::Path;

use plan::{Change, Plan};
use robot_model::Configuration;

use crate::support::program::{ends_with, read, succeeds};
use crate::support::shipped::shipped;

fn plan_in(folder: &Path) -> Plan {
    serde_json::from_str(&read(folder.join("plan.json"))).expect("a plan")
}

#[test]
fn from_every_stance_of_a_plan_there_is_a_way_on() {
    let earlier = shipped("irregular-stairs");
    let file = earlier.results.join("plan.json");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let count = earlier.plan.stances.len();
    assert!(count > 10);
    for (number, stance) in earlier.plan.stances.iter().enumerate().take(count - 1) {
        let at = format!("{}:{number}", file.display());
        let results = folder.path().join(number.to_string());
        let line = "plan irregular-stairs --threads 2 --start-stance @ -o @";
        succeeds(line, &[Path::new(&at), &results]);
        let plan = plan_in(&results);
        let [was, is] = [&stance.q, &plan.stances[0].q].map(|q| Configuration::from_q(q).unwrap());
        assert!((was.p_WB - is.p_WB).norm() < 0.01, "stance {number}");
        assert!((was.joints - is.joints).amax() < 0.02, "stance {number}");
    }
}

#[test]
fn a_start_by_joints_is_the_stance_that_they_are_of() {
    let earlier = shipped("irregular-stairs");
    let file = format!("{}:4", earlier.results.join("plan.json").display());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stance = &earlier.plan.stances[4];
    let q = Configuration::from_q(&stance.q).unwrap();
    let (roll, pitch, yaw) = q.R_WB.euler_angles();
    let patches: Vec<&str> = stance.contacts.iter().map(|c| c.patch.as_str()).collect();
    let joints = earlier.plan.robot.joint_names.iter().zip(q.joints.iter());
    let joints: String = joints
        .map(|(name, value)| format!("{name} = {value:?}\n"))
        .collect();
    let builtin = scenes::builtin("irregular-stairs").unwrap();
    let scene: toml::Table = toml::from_str(builtin.toml).unwrap();
    let p = q.p_WB;
    let start = format!(
        "base_position_m = [{:?}, {:?}, {:?}]\nbase_rpy_rad = [{roll:?}, {pitch:?}, {yaw:?}]\n\
         contacts = {patches:?}\n[joints_rad]\n{joints}",
        p.x, p.y, p.z
    );
    let mut scene = scene.clone();
    scene.insert(
        "start".to_owned(),
        toml::Value::Table(toml::from_str(&start).unwrap()),
    );
    let depth = "irregular-stairs_depth.png";
    std::fs::write(folder.path().join(depth), builtin.file(depth).unwrap()).unwrap();
    let scene_file = folder.path().join("scene.toml");
    std::fs::write(&scene_file, scene.to_string()).unwrap();
    let (by_joints, by_stance) = (folder.path().join("joints"), folder.path().join("stance"));
    succeeds("plan @ --threads 2 -o @", &[&scene_file, &by_joints]);
    let line = "plan irregular-stairs --threads 2 --start-stance @ -o @";
    succeeds(line, &[Path::new(&file), &by_stance]);
    let [a, b] = [plan_in(&by_joints), plan_in(&by_stance)];
    let changes =
        |plan: &Plan| -> Vec<_> { plan.stances.iter().map(|s| s.change.clone()).collect() };
    assert_eq!(changes(&a), changes(&b));
}

#[test]
fn a_hexapod_walks_without_a_leg() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let floor = folder.path().join("floor.obj");
    std::fs::write(
        &floor,
        "v -2 -2 0\nv 3 -2 0\nv 3 2 0\nv -2 2 0\nf 1 2 3 4\n",
    )
    .unwrap();
    let line = r#"plan --mesh @ --goal 0.8,0 --robot builtin:hexapod --set planner.exclude=["front_left"] -o @"#;
    succeeds(line, &[&floor, folder.path()]);
    let plan = plan_in(folder.path());
    let made =
        |change: &Change| matches!(change, Change::Add { patch, .. } if patch == "front_left");
    assert!(!plan.stances.iter().any(|s| made(&s.change)));
    let last = plan.stances.last().unwrap();
    assert!(!last.contacts.iter().any(|c| c.patch == "front_left"));
}

#[test]
fn joints_that_are_not_there_or_beyond_their_limits_are_said() {
    let line = "plan irregular-stairs --start half_sitting@0,0,0.65 --start HEAD_JOINT0=4";
    ends_with(line, &[], 1, &["HEAD_JOINT0 at 4.000 is beyond its limits"]);
    let line = "plan irregular-stairs --start half_sitting@0,0,0.65 --start NECK=0";
    ends_with(line, &[], 1, &["the start", "\"NECK\""]);
    let earlier = shipped("irregular-stairs").results.join("plan.json");
    let at = format!("{}:999", earlier.display());
    ends_with(
        "plan irregular-stairs --start-stance @",
        &[Path::new(&at)],
        1,
        &["no stance 999"],
    );
}
