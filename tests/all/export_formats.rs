//! Exported plans, read back the way their readers do.
use std::collections::BTreeMap;

use clap::ValueEnum;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use plan::{Change, Plan, Stance};
use scandent::export::{Config, Format, export};
use serde_json::Value;

use crate::support::biped;
use crate::support::program::{list, number};

/// Files are written to a micrometre and a microradian; turned about, some of them add up.
const ROUNDED: f64 = 3e-6;

fn exported(plan: &Plan, format: Format, config: &Config) -> anyhow::Result<String> {
    export(plan, None, &biped::robot(), format, config)
}

fn yaml(plan: &Plan, config: &Config) -> Value {
    serde_saphyr::from_str(&exported(plan, Format::MccYaml, config).unwrap()).unwrap()
}

/// The document of the biped's plan as it is exported by default.
fn biped_yaml() -> Value {
    yaml(&biped::plan(), &Config::default())
}

/// The commands of the steps.
fn steps(document: &Value) -> &[Value] {
    list(&document["states"]["MCC::ConfigMotion_"]["configs"]["stepCommandList"])
}

fn triple(value: &Value) -> Vector3<f64> {
    assert_eq!(list(value).len(), 3);
    Vector3::from_iterator(list(value).iter().map(number))
}

#[track_caller]
fn assert_same_place(a: &Isometry3<f64>, b: &Isometry3<f64>) {
    let off = a.inverse() * b;
    let (shift, turn) = (off.translation.vector.norm(), off.rotation.angle());
    assert!(shift < ROUNDED && turn < ROUNDED, "{shift} m, {turn} rad");
}

/// A pose as mc_rtc reads it: three angles give the transpose E = RotX(r) RotY(p) RotZ(y) of
/// passive rotations, and the pose's rotation in the world is Eᵀ.
fn pose(value: &Value) -> Isometry3<f64> {
    let [r, p, y] = triple(&value["rotation"]).into();
    let rot_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, r.cos(), r.sin(), 0.0, -r.sin(), r.cos());
    let rot_y = Matrix3::new(p.cos(), 0.0, -p.sin(), 0.0, 1.0, 0.0, p.sin(), 0.0, p.cos());
    let rot_z = Matrix3::new(y.cos(), y.sin(), 0.0, -y.sin(), y.cos(), 0.0, 0.0, 0.0, 1.0);
    let R = Rotation3::from_matrix_unchecked((rot_x * rot_y * rot_z).transpose());
    let turn = UnitQuaternion::from_rotation_matrix(&R);
    Isometry3::from_parts(triple(&value["translation"]).into(), turn)
}

/// Limbs in contact and where, as the controller keeps them.
type Touching = BTreeMap<String, Isometry3<f64>>;

/// Plays the step commands: at which times which limbs touch.
fn play(document: &Value, start: Touching) -> Vec<(f64, Touching)> {
    // (time, limb, the new place or none), as the controller expands its simple form.
    let mut events: Vec<(f64, String, Option<Isometry3<f64>>)> = Vec::new();
    let mut busy: BTreeMap<String, f64> = BTreeMap::new();
    for step in steps(document) {
        let limb = step["limb"].as_str().unwrap().to_owned();
        let [from, to] = ["startTime", "endTime"].map(|key| number(&step[key]));
        assert!(from < to, "{step}");
        // The controller drops a command that begins before the limb's last one ended.
        assert!(*busy.get(&limb).unwrap_or(&0.0) < from, "{step}");
        busy.insert(limb.clone(), to);
        events.push((from, limb.clone(), None));
        match step["type"].as_str().unwrap() {
            "Add" => {
                assert_eq!(step["constraint"]["type"], "Surface");
                events.push((to, limb, Some(pose(&step["pose"]))));
            }
            "Remove" => assert!(step.get("pose").is_none() && step.get("constraint").is_none()),
            other => panic!("{other}"),
        }
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut touching = start;
    let mut history = vec![(0.0, touching.clone())];
    for (time, limb, place) in events {
        match place {
            Some(place) => drop(touching.insert(limb, place)),
            None => drop(touching.remove(&limb)),
        }
        history.push((time, touching.clone()));
    }
    history
}

fn limb(patch: &str) -> String {
    match patch {
        "left_foot" => "LeftFoot".to_owned(),
        "right_foot" => "RightFoot".to_owned(),
        other => panic!("{other}"),
    }
}

/// The contact sets of the plan, in order.
fn planned(plan: &Plan) -> Vec<Touching> {
    let mut touching = Touching::new();
    let mut sets = Vec::new();
    for stance in &plan.stances {
        let place = |patch: &str| {
            let contact = stance.contacts.iter().find(|c| c.patch == patch).unwrap();
            let [x, y, z, w] = contact.X_WC.quat_xyzw;
            let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
            Isometry3::from_parts(Vector3::from(contact.X_WC.p).into(), turn)
        };
        match &stance.change {
            Change::Start => {
                for contact in &stance.contacts {
                    touching.insert(limb(&contact.patch), place(&contact.patch));
                }
            }
            Change::Add { patch, .. } => drop(touching.insert(limb(patch), place(patch))),
            Change::Remove { patch, .. } => drop(touching.remove(&limb(patch))),
            Change::Goal => continue,
        }
        sets.push(touching.clone());
    }
    sets
}

#[test]
fn the_controller_makes_the_contacts_of_the_plan_in_their_order() {
    let (plan, document) = (biped::plan(), biped_yaml());
    let sets = planned(&plan);
    let played = play(&document, sets[0].clone());
    assert_eq!(played.len(), sets.len());
    for ((time, played), planned) in played.iter().zip(&sets) {
        assert_eq!(played.len(), planned.len(), "at {time} s");
        for (limb, place) in planned {
            assert_same_place(&played[limb], place);
        }
    }
    let initial = &document["states"]["MCC::Initial_"]["configs"]["initialContacts"];
    let limbs: Vec<&String> = initial.as_object().unwrap().keys().collect();
    assert_eq!(limbs, ["LeftFoot", "RightFoot"]);
}

#[test]
fn nominal_poses_and_postures_are_those_of_the_stances() {
    let (plan, document) = (biped::plan(), biped_yaml());
    let configs = &document["states"]["MCC::ConfigMotion_"]["configs"];
    assert_eq!(configs["baseTime"], "Relative");
    let poses = list(&configs["nominalCentroidalPoseList"]);
    let postures = list(&configs["nominalPostureList"]);
    // Every stance but the start is gone to once.
    assert_eq!(poses.len(), plan.stances.len() - 1);
    assert_eq!(postures.len(), poses.len());
    let mut before = 0.0;
    let at_com = |nominal: &Value, stance: &Stance| {
        let [x, y, z] = stance.com_W;
        assert_same_place(&pose(nominal), &Isometry3::translation(x, y, z));
    };
    for ((entry, posture), stance) in poses.iter().zip(postures).zip(&plan.stances[1..]) {
        let time = number(&entry["time"]);
        // The controller drops what is earlier than the last, and keeps one of equal times.
        assert!(time > before);
        before = time;
        assert_eq!(posture["time"], entry["time"]);
        at_com(&entry["pose"], stance);
        let target = posture["target"].as_object().unwrap();
        assert_eq!(target.len(), plan.robot.joint_names.len());
        for (joint, q) in plan.robot.joint_names.iter().zip(&stance.q[7..]) {
            let [value] = list(&target[joint]) else {
                panic!("{joint}: {}", target[joint]);
            };
            assert!((number(value) - q).abs() < ROUNDED, "{joint}");
        }
    }
    let robot = &document["robots"]["biped"];
    let manager = &robot["CentroidalManager"];
    assert_eq!(manager["nominalCentroidalPoseBaseFrame"], "World");
    at_com(&manager["nominalCentroidalPose"], &plan.stances[0]);
    assert_eq!(robot["BaseOrientationTask"]["frame"], "torso");
}

#[test]
fn limb_frames_are_the_patches() {
    let (robot, document) = (biped::robot(), biped_yaml());
    let tasks = list(&document["LimbTaskList"]);
    let surfaces = list(&document["Contacts"]["Surface"]);
    let frames = list(&document["robots"]["biped"]["frames"]);
    assert_eq!([tasks.len(), surfaces.len(), frames.len()], [2; 3]);
    for (i, patch) in robot.patches.iter().enumerate() {
        let (task, surface, frame) = (&tasks[i], &surfaces[i], &frames[i]);
        assert_eq!(task["limb"], limb(&patch.name).as_str());
        assert_eq!(surface["name"], task["limb"]);
        assert_eq!(frame["name"], task["frame"]);
        assert_eq!(frame["parent"], patch.link.as_str());
        assert_same_place(&pose(&frame["X_p_f"]), &patch.X_BC);
        for (vertex, v) in list(&surface["vertices"]).iter().zip(&patch.polygon) {
            assert!((triple(vertex) - Vector3::new(v.x, v.y, 0.0)).norm() < ROUNDED);
        }
    }
}

#[test]
fn a_tilted_contact_keeps_its_frame() {
    let mut plan = biped::plan();
    let turn = UnitQuaternion::from_euler_angles(-0.35, 0.2, 1.1);
    let q = turn.coords;
    let contacts = plan.stances.iter_mut().flat_map(|s| &mut s.contacts);
    for contact in contacts.filter(|c| c.face.as_str() == "step") {
        contact.X_WC.quat_xyzw = [q.x, q.y, q.z, q.w];
    }
    let document = yaml(&plan, &Config::default());
    let steps = steps(&document);
    let placed = pose(&steps[0]["pose"]);
    assert!(placed.rotation.angle_to(&turn) < ROUNDED);
    // Offsets are in the frame of their place: the approach comes from above in the world.
    let approach = triple(&steps[0]["swingConfig"]["approachOffset"]);
    assert!((turn * approach).z > 0.05 - ROUNDED);
}

#[test]
fn names_and_friction_can_be_others() {
    let limbs = |patch: &str, limb: &str| Config {
        limbs: BTreeMap::from([(patch.to_owned(), limb.to_owned())]),
        ..Config::default()
    };
    let config = Config {
        robot: Some("mc_biped".to_owned()),
        ..limbs("left_foot", "Paw")
    };
    let document = yaml(&biped::plan(), &config);
    assert!(document["robots"].get("mc_biped").is_some());
    let initial = &document["states"]["MCC::Initial_"]["configs"]["initialContacts"];
    // 0.8 of 0.7.
    assert!((number(&initial["Paw"]["fricCoeff"]) - 0.56).abs() < 1e-9);
    assert_eq!(initial["Paw"]["type"], "Surface");

    let instant = Config {
        swing_s: 0.0,
        ..Config::default()
    };
    for (config, word) in [
        (limbs("left_foot", "RightFoot"), "left_foot and right_foot"),
        (limbs("tail", "Tail"), "export.limbs"),
        (instant, "export.swing_s"),
    ] {
        let refused = exported(&biped::plan(), Format::MccYaml, &config);
        let text = refused.unwrap_err().to_string();
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn a_contact_that_goes_nowhere_is_taken_away() {
    let mut plan = biped::plan();
    plan.stances.truncate(2);
    let document = yaml(&plan, &Config::default());
    let [step] = steps(&document) else {
        panic!("{document}");
    };
    assert_eq!([&step["type"], &step["limb"]], ["Remove", "LeftFoot"]);
    assert!(triple(&step["swingConfig"]["withdrawOffset"]).z > 0.0);
}

#[test]
fn json_holds_phases_and_wrenches() {
    let plan = biped::plan();
    let text = exported(&plan, Format::Json, &Config::default()).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["format"], "scandent-contacts/1");
    let phases = list(&document["phases"]);
    let kinds: Vec<&Value> = phases.iter().map(|p| &p["kind"]).collect();
    assert_eq!(kinds, ["shift", "step", "shift", "step", "shift"]);
    // They follow each other.
    for pair in phases.windows(2) {
        assert_eq!(pair[0]["end_s"], pair[1]["start_s"]);
    }
    for (stance, planned) in list(&document["stances"]).iter().zip(&plan.stances) {
        let contacts = list(&stance["contacts"]).iter();
        let lift: f64 = contacts.map(|c| number(&c["wrench_W"][2])).sum();
        assert!((lift - plan.robot.mass_kg * 9.81).abs() < 1e-6);
        assert_eq!(list(&stance["q"]).len(), planned.q.len());
    }
}

#[test]
fn csv_has_a_row_a_stance_and_a_cell_a_column() {
    let plan = biped::plan();
    let text = exported(&plan, Format::Csv, &Config::default()).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), plan.stances.len() + 1);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let column = |name: &str| rows[0].iter().position(|n| *n == name).unwrap();
    let mut before = -1.0;
    for (row, stance) in rows[1..].iter().zip(&plan.stances) {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!(number("index"), stance.index as f64);
        assert!(number("time_s") > before);
        before = number("time_s");
        assert!((number("com_z_m") - stance.com_W[2]).abs() < ROUNDED);
        assert!((number("left_knee_rad") - stance.q[9]).abs() < ROUNDED);
        let states = [row[column("left_foot")], row[column("right_foot")]];
        let loaded = states.iter().filter(|s| **s == "loaded").count();
        assert_eq!(loaded, stance.contacts.iter().filter(|c| c.loaded).count());
    }
}

#[test]
fn plans_that_cannot_be_written_are_refused() {
    type Break = (fn(&mut Plan), &'static str);
    let breaks: [Break; 5] = [
        (|plan| plan.robot.joint_names.swap(0, 1), "joints"),
        (|plan| plan.stances.clear(), "no stances"),
        (|plan| plan.stances[1].q.truncate(16), "16 values"),
        (|plan| plan.stances[0].com_W[0] = f64::NAN, "not finite"),
        (|p| p.stances[0].contacts[0].patch = "tail".into(), "tail"),
    ];
    for (apply, cause) in breaks {
        for &format in Format::value_variants() {
            let mut plan = biped::plan();
            apply(&mut plan);
            let refused = exported(&plan, format, &Config::default());
            let text = format!("{:#}", refused.unwrap_err());
            assert!(text.contains(cause), "{text}");
        }
    }
}
