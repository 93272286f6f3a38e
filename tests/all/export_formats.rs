//! Exported plans, read back the way their readers do.
use std::collections::BTreeMap;

use clap::ValueEnum;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use plan::{Plan, Stance};
use robot_model::PatchKind;
use scandent::export::{Config, Format, export};
use serde_json::Value;

use crate::support::biped;
use crate::support::controller::{
    ROUNDED, assert_same_place, limb, planned, play, pose, steps, triple,
};
use crate::support::program::{list, number};

fn exported(plan: &Plan, format: Format, config: &Config) -> anyhow::Result<String> {
    let bytes = export(plan, None, &biped::robot(), format, config)?;
    Ok(String::from_utf8(bytes)?)
}

fn yaml(plan: &Plan, config: &Config) -> Value {
    serde_saphyr::from_str(&exported(plan, Format::MccYaml, config).unwrap()).unwrap()
}

/// The document of the biped's plan as it is exported by default.
fn biped_yaml() -> Value {
    yaml(&biped::plan(), &Config::default())
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
    // A list: read as one, a map with limbs for its keys has no entries, and nothing would touch.
    let initial = &document["states"]["MCC::Initial_"]["configs"];
    let limbs = list(&initial["initialContacts"]).iter();
    let limbs: Vec<&Value> = limbs.map(|c| &c["limb"]).collect();
    assert_eq!(limbs, ["LeftFoot", "RightFoot"]);
    // Without a time it waits for a click.
    assert!(number(&initial["autoStartTime"]) > 0.0);
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

/// The controller's own 50 N are more than a hand may ever carry.
#[test]
fn a_limb_has_touched_down_before_it_bears_what_is_planned() {
    let force = |plan: &Plan| {
        let document = yaml(plan, &Config::default());
        number(&document["LimbManagerSet"]["LimbManager"]["LeftFoot"]["touchDownForceZ"])
    };
    let mut plan = biped::plan();
    assert_eq!(force(&plan), 50.0);
    let contacts = plan.stances.iter_mut().flat_map(|s| &mut s.contacts);
    let forces = contacts.flat_map(|c| &mut c.forces_W);
    forces.for_each(|f| *f = f.map(|x| 0.1 * x));
    let light = force(&plan);
    assert!(
        light > 5.0 && light < 0.5 * 0.1 * plan.robot.mass_kg * 9.81 + 1.0,
        "{light}"
    );
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
    let paw = list(initial).iter().find(|c| c["limb"] == "Paw");
    let paw = paw.expect("the left foot's contact");
    // 0.8 of 0.7.
    assert!((number(&paw["fricCoeff"]) - 0.56).abs() < 1e-9);
    assert_eq!(paw["type"], "Surface");

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

/// A robot with a fist whose plan walks on its soles, and the same plan with the fist on something.
#[test]
fn only_a_ball_that_touches_is_none_for_the_controller() {
    let mut robot = biped::robot();
    let mut fist = robot.patches[0].clone();
    (fist.name, fist.kind) = ("fist".into(), PatchKind::Point { radius_m: 0.03 });
    robot.patches.push(fist);
    let mut plan = biped::plan();
    let config = Config::default();
    let bytes = export(&plan, None, &robot, Format::MccYaml, &config).unwrap();
    assert_eq!(
        bytes,
        exported(&plan, Format::MccYaml, &config)
            .unwrap()
            .into_bytes()
    );
    plan.stances[0].contacts[0].patch = "fist".into();
    let refused = export(&plan, None, &robot, Format::MccYaml, &config);
    let text = format!("{:#}", refused.unwrap_err());
    assert!(text.contains("no contact of a ball, and fist"), "{text}");
}
