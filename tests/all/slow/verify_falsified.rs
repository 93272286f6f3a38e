//! What a plan says of its world, its task and its promises is held against its files: falsified plans
//! fail or pass conditionally in words, and with `--against` all of them fail.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::support::program::{FLOOR, ends_with, json as read_json, root, said, scandent};
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

/// Adds to a margin that every stance states.
fn margins(plan: &mut Value, name: &str, by: f64) {
    for stance in each(plan, "stances") {
        let stated = &mut stance["margins"][name];
        if let Some(value) = stated.as_f64() {
            *stated = (value + by).into();
        }
    }
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
    ("the robot's hash altered", |p| hash(p, "urdf")),
    ("the postures' hash altered", |p| hash(p, "srdf")),
    ("the robot forgotten", |p| p["inputs"].as_array_mut().unwrap().retain(|i| i["role"] != "urdf")),
    ("no margin of the centre of mass", |p| p["required"]["com_m"] = 0.0.into()),
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
    ("joints that nobody wants", |p| p["goal"]["joints"] = json!({"wanted": {}, "tolerance_rad": 0.1})),
    ("a margin that soles do not hold", |p| p["required"]["com_m"] = 0.06.into()),
    ("no clearance", |p| p["required"]["clearance_m"] = 0.0.into()),
    ("no clearance of its own parts", |p| p["required"]["self_clearance_m"] = 0.0.into()),
    ("no margin of the joints", |p| p["required"]["joint_rad"] = 0.0.into()),
    ("all the friction", |p| p["required"]["friction_use"] = 1.0.into()),
    ("all the torque", |p| p["required"]["torque_use"] = 1.0.into()),
    ("edges as they are seen", |p| p["required"]["edge_sigmas"] = 0.0.into()),
    ("a stated margin better", |p| each(p, "stances").for_each(|s| s["margins"]["inclusion_m"] = 0.4.into())),
    ("friction stated worse", |p| margins(p, "friction_use", 0.1)),
    ("torque stated worse", |p| margins(p, "torque_use", 0.1)),
    ("room of the joints stated worse", |p| margins(p, "joint_rad", -0.01)),
    ("balance stated worse", |p| margins(p, "equilibrium", 0.01)),
    ("contacts stated farther apart", |p| margins(p, "closure_m", 0.005)),
    ("clearance stated worse than promised", |p| margins(p, "clearance_m", -0.5)),
    ("distance of parts stated worse than promised", |p| margins(p, "self_clearance_m", -0.5)),
    ("feet stated over the edge", |p| margins(p, "inclusion_m", -0.5)),
    ("a setting that is not the scene's", |p| p["config"]["posture"]["clearance_m"] = 0.015.into()),
    ("no settings", |p| p["config"] = json!({})),
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

/// What is changed in which file beside a plan from flags: the first of a text, for another.
#[rustfmt::skip]
const FILES: &[(&str, &str, &str)] = &[
    ("quadruped.urdf", "effort=\"", "effort=\"9"),
    ("quadruped.urdf", "upper=\"", "upper=\"9"),
    ("quadruped.urdf", "lower=\"-", "lower=\"-9"),
    ("quadruped.urdf", "velocity=\"", "velocity=\"9"),
    ("quadruped.urdf", "mass value=\"", "mass value=\"0"),
    ("quadruped.urdf", "<collision>", "<collision><!-- -->"),
    ("quadruped.urdf", "</robot>", ""),
    ("quadruped.srdf", "value=\"", "value=\"1"),
    ("contacts.toml", "friction", "# friction"),
    ("contacts.toml", "radius_m = ", "radius_m = 1"),
    ("contacts.toml", "[", "# ["),
    ("floor.obj", "v 3", "v 4"),
    ("floor.obj", "f 1 2 3 4", "f 1 2 3"),
    ("floor.obj", "v", ""),
];

#[test]
fn a_plan_from_flags_rests_on_its_files() {
    let folder = scratch("from-flags");
    let robot = root("scenes/robots/quadruped");
    for name in ["quadruped.urdf", "quadruped.srdf", "contacts.toml"] {
        std::fs::copy(robot.join(name), folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("floor.obj"), FLOOR).unwrap();
    let names = [
        "quadruped.urdf",
        "quadruped.srdf",
        "contacts.toml",
        "floor.obj",
        "out",
    ];
    let [urdf, srdf, contacts, mesh, out] = names.map(|name| folder.join(name));
    let line = "plan --robot @ --srdf @ --contacts @ --mesh @ --goal 0.2,0 -o @";
    ends_with(
        line,
        &[&urdf, &srdf, &contacts, &mesh, &out],
        0,
        &["verified"],
    );
    let plan = out.join("plan.json");
    let words = ends_with("verify @", &[&plan], 0, &["PASS: "]);
    assert!(!words.contains("CONDITIONALLY"), "{words}");
    let caught = |what: &str| {
        let alone = scandent("verify @", &[&plan]);
        let words = said(&alone);
        let caught = alone.status.code() == Some(1) || words.contains("PASS, CONDITIONALLY");
        assert!(caught, "{what}: {words}");
    };
    for (name, from, to) in FILES {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{name}: no {from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        caught(&format!("{name}: {from} for {to}"));
        std::fs::remove_file(&path).unwrap();
        caught(&format!("{name} is away"));
        std::fs::write(&path, text).unwrap();
    }
    let whole = read_json(&plan);
    let mut changed = whole.clone();
    for input in each(&mut changed, "inputs").filter(|input| input["role"] == "flags") {
        input["name"] = input["name"]
            .as_str()
            .unwrap()
            .replace("0.2,0", "0.1,0")
            .into();
    }
    std::fs::write(&plan, changed.to_string()).unwrap();
    caught("another goal among the flags");
    std::fs::write(&plan, whole.to_string()).unwrap();
    ends_with("verify @", &[&plan], 0, &["PASS: "]);
}

const KEY: &str = "-----BEGIN PRIVATE KEY-----
MC4CAQAwBQYDK2VwBCIEICcz5I4EogGVEgUxYrKLebYn0uDykgf6aFKg9lPwh/6a
-----END PRIVATE KEY-----
";
const PUBLIC: &str = "-----BEGIN PUBLIC KEY-----
MCowBQYDK2VwAyEA9ZRVkYVPWgojjn8NmMoI8whCefBdST4Q2/tbGPAKzLk=
-----END PUBLIC KEY-----
";
const ANOTHER: &str = "-----BEGIN PUBLIC KEY-----
MCowBQYDK2VwAyEACcZEBy3niU6GQXl4PJRKue9EaD2siBECE5EtZLp007k=
-----END PUBLIC KEY-----
";

#[test]
fn a_signature_ties_a_certificate_to_its_plan() {
    let folder = scratch("signed");
    let plan = changed("irregular-stairs", |_| {}, &folder);
    let [certificate, key, public, another] =
        ["c.json", "key.pem", "public.pem", "another.pem"].map(|name| folder.join(name));
    for (path, text) in [(&key, KEY), (&public, PUBLIC), (&another, ANOTHER)] {
        std::fs::write(path, text).unwrap();
    }
    let signing = "verify @ -o @ --sign @";
    ends_with(signing, &[&plan, &certificate, &key], 0, &["c.json.sig"]);
    let line = "verify @ --signed @ --by @";
    let paths: [&Path; 3] = [&plan, &certificate, &public];
    ends_with(line, &paths, 0, &["signed for this plan", "PASS: "]);
    let by_another: [&Path; 3] = [&plan, &certificate, &another];
    ends_with(line, &by_another, 1, &["not signed by the owner"]);
    let no_key: [&Path; 3] = [&plan, &certificate, &key];
    ends_with(line, &no_key, 1, &["no public ed25519 key"]);
    ends_with(
        signing,
        &[&plan, &certificate, &public],
        1,
        &["no private ed25519 key"],
    );
    // A letter of the certificate, of the plan, of the signature.
    let signature = folder.join("c.json.sig");
    for (path, from, to, words) in [
        (
            &certificate,
            "\"pass\": true",
            "\"pass\": true ",
            "another certificate",
        ),
        (&plan, "\"seed\":0", "\"seed\":1", "another plan"),
        (
            &signature,
            "\"signature\": \"",
            "\"signature\": \"0",
            "64 bytes",
        ),
        (&signature, "signature/1", "signature/2", "format"),
    ] {
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains(from), "{from}");
        std::fs::write(path, text.replacen(from, to, 1)).unwrap();
        ends_with(line, &paths, 1, &[words]);
        std::fs::write(path, text).unwrap();
    }
    ends_with(line, &paths, 0, &["signed for this plan"]);
    // A plan that fails is not signed.
    let broken = changed(
        "irregular-stairs",
        |p| margins(p, "torque_use", 0.1),
        &folder,
    );
    std::fs::remove_file(&signature).unwrap();
    ends_with(signing, &[&broken, &certificate, &key], 1, &["fails: "]);
    assert!(!signature.exists());
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
        1,
        &["torque_use: stated_margin", "hrp2.urdf: not the plan's"],
    );
    ends_with(
        &format!("{line} --against irregular-stairs"),
        &paths,
        1,
        &["not the plan's"],
    );
}
