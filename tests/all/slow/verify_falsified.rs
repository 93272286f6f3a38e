//! What a plan says of its world, its task and its promises is held against its files: falsified plans
//! fail or pass conditionally in words, and with `--against` all of them fail.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::support::program::{ends_with, json as read_json, root, said, scandent};
use crate::support::shipped::shipped;

/// One way to falsify a plan.
type Falsification = (&'static str, fn(&mut Value));

fn each<'a>(plan: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Value> {
    plan[list].as_array_mut().unwrap().iter_mut()
}

fn contacts(plan: &mut Value) -> impl Iterator<Item = &mut Value> {
    each(plan, "stances").flat_map(|s| s["contacts"].as_array_mut().unwrap())
}

fn edges(plan: &mut Value) -> impl Iterator<Item = &mut Value> {
    let rings = each(plan, "faces").flat_map(|f| f["region"].as_array_mut().unwrap());
    rings
        .filter_map(|ring| ring.get_mut("edges")?.as_array_mut())
        .flatten()
}

/// Drops the faces that no contact is on.
fn untouched_faces(plan: &mut Value) {
    let touched: Vec<Value> = contacts(plan).map(|c| c["face"].clone()).collect();
    let faces = plan["faces"].as_array_mut().unwrap();
    faces.retain(|face| touched.contains(&face["id"]));
}

fn hash(plan: &mut Value, role: &str) {
    let mut inputs = each(plan, "inputs").filter(|input| input["role"] == role);
    inputs.next().unwrap()["sha256"] = "0".repeat(64).into();
}

#[rustfmt::skip]
const FALSIFICATIONS: &[Falsification] = &[
    ("all obstacles removed", |p| p["obstacles"] = json!([])),
    ("an obstacle removed", |p| drop(p["obstacles"].as_array_mut().unwrap().pop())),
    ("an obstacle moved", |p| each(p, "obstacles").next().unwrap()["points_W"][0][0] = 50.0.into()),
    ("untouched faces removed", untouched_faces),
    ("insets zeroed", |p| edges(p).for_each(|e| { e["further_m"] = 0.0.into(); e["inside_rad"] = 0.0.into(); })),
    ("every edge real", |p| edges(p).for_each(|e| e["kind"] = "real".into())),
    ("planes known exactly", |p| each(p, "faces").for_each(|f| f["plane_covariance"] = Value::Null)),
    ("bodies thinned", |p| p["thin_body_m"] = 0.01.into()),
    ("more friction", |p| contacts(p).for_each(|c| c["friction"] = 1.5.into())),
    ("less friction", |p| contacts(p).for_each(|c| c["friction"] = 0.9.into())),
    ("the scan's hash altered", |p| hash(p, "scan")),
    ("the scene's hash altered", |p| hash(p, "scene")),
    ("the contacts' hash altered", |p| hash(p, "contacts")),
    ("the scan forgotten", |p| p["inputs"].as_array_mut().unwrap().retain(|i| i["role"] != "scan")),
    ("the scene forgotten", |p| p["inputs"].as_array_mut().unwrap().retain(|i| i["role"] != "scene")),
    ("another scene's name", |p| p["scene"] = "elsewhere".into()),
    ("the motion deleted", |p| drop(p.as_object_mut().unwrap().remove("motion"))),
    ("the motion shorter", |p| p["motion"]["duration_s"] = (-1e300).into()),
    ("the motion's samples fewer", |p| p["motion"]["samples"] = 3.into()),
    ("the goal anywhere", |p| p["goal"]["tolerance_m"] = 1e300.into()),
    ("the goal farther off", |p| p["goal"]["tolerance_m"] = 5.0.into()),
    ("no goal", |p| { p["goal"]["base_position_m"] = Value::Null; p["goal"]["contacts"] = json!([]); p["goal"]["yaw_rad"] = Value::Null; }),
    ("another goal", |p| p["goal"]["base_position_m"] = p["stances"].as_array().unwrap().last().unwrap()["q"].as_array().unwrap()[..3].to_vec().into()),
    ("a margin that soles do not hold", |p| p["required"]["com_m"] = 0.06.into()),
    ("no clearance", |p| p["required"]["clearance_m"] = 0.0.into()),
    ("no clearance of its own parts", |p| p["required"]["self_clearance_m"] = 0.0.into()),
    ("no margin of the joints", |p| p["required"]["joint_rad"] = 0.0.into()),
    ("all the friction", |p| p["required"]["friction_use"] = 1.0.into()),
    ("all the torque", |p| p["required"]["torque_use"] = 1.0.into()),
    ("edges as they are seen", |p| p["required"]["edge_sigmas"] = 0.0.into()),
    ("a stated margin better", |p| each(p, "stances").for_each(|s| s["margins"]["inclusion_m"] = 0.4.into())),
    ("another command line", |p| p["inputs"].as_array_mut().unwrap().push(
        json!({"role": "flags", "name": "command line", "sha256": "0".repeat(64)}))),
];

/// A folder of this name that is there.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A copy of a scene's plan and motion, changed.
fn changed(scene: &'static str, change: fn(&mut Value), folder: &Path) -> PathBuf {
    let results = &shipped(scene).results;
    let mut plan = read_json(results.join("plan.json"));
    change(&mut plan);
    std::fs::copy(results.join("motion.json"), folder.join("motion.json")).unwrap();
    let path = folder.join("plan.json");
    std::fs::write(&path, plan.to_string()).unwrap();
    path
}

#[test]
fn every_falsified_plan_fails_or_says_what_it_rests_on() {
    let folder = scratch("falsified");
    for (what, change) in FALSIFICATIONS {
        let path = changed("slope-and-hand", *change, &folder);
        let alone = scandent("verify @", &[&path]);
        let words = said(&alone);
        let caught = alone.status.code() == Some(1) || words.contains("PASS, CONDITIONALLY");
        assert!(caught, "{what}: {words}");
        let against = scandent("verify @ --against slope-and-hand", &[&path]);
        assert_eq!(against.status.code(), Some(1), "{what}: {}", said(&against));
    }
    let whole = changed("slope-and-hand", |_| {}, &folder);
    for line in ["verify @", "verify @ --against slope-and-hand"] {
        let words = ends_with(line, &[&whole], 0, &["PASS: "]);
        assert!(!words.contains("CONDITIONALLY"), "{words}");
    }
    ends_with(
        "verify @ --against irregular-stairs",
        &[&whole],
        1,
        &["world"],
    );
}

#[test]
fn a_foreign_robot_is_named() {
    let folder = scratch("foreign-robot");
    let path = changed("irregular-stairs", |_| {}, &folder);
    let ours = root("scenes/robots/hrp2");
    let text = std::fs::read_to_string(ours.join("hrp2.urdf")).unwrap();
    let urdf = folder.join("hrp2.urdf");
    std::fs::write(&urdf, text.replacen("effort=\"", "effort=\"9", 40)).unwrap();
    let line = "verify @ --robot @ --srdf @ --contacts @";
    let beside = ["hrp2.srdf", "contacts.toml"].map(|name| ours.join(name));
    let paths: [&Path; 4] = [&path, &urdf, &beside[0], &beside[1]];
    ends_with(
        line,
        &paths,
        0,
        &["PASS, CONDITIONALLY", "hrp2.urdf: not the plan's"],
    );
    ends_with(
        &format!("{line} --against irregular-stairs"),
        &paths,
        1,
        &["not the plan's"],
    );
}
