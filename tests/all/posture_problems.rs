//! `scandent posture` on contact sets with known answers.

use std::path::Path;
use std::process::Output;

use serde_json::{Value, json};

use crate::support::program::{self, assert_ended, list, number, scandent};

fn solve(folder: &Path, problems: &Value) -> Output {
    let file = folder.join("problems.json");
    std::fs::write(&file, problems.to_string()).expect("writable");
    let results = folder.join("results.json");
    scandent("posture @ --robot builtin:hrp2 -o @", &[&file, &results])
}

/// A sole flat on z = 0.
fn sole(side: &str, x: f64, y: f64) -> Value {
    let link = format!("{}LEG_LINK5", side[..1].to_uppercase());
    json!({
        "link": link, "patch": format!("{side}_foot"), "p": [x, y, 0.0],
        "R": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    })
}

/// Forces and moments about the origin that the contacts exert.
fn wrench(result: &Value) -> [f64; 6] {
    let mut sum = [0.0; 6];
    let vector = |v: &Value| [0, 1, 2].map(|i| number(&v[i]));
    for contact in list(&result["forces"]) {
        let (points, forces) = (list(&contact["points_W"]), list(&contact["forces_W"]));
        for (p, f) in points.iter().map(vector).zip(forces.iter().map(vector)) {
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                sum[i] += f[i];
                sum[3 + i] += p[j] * f[k] - p[k] * f[j];
            }
        }
    }
    sum
}

#[test]
fn known_contact_sets_get_their_answers_in_order() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut turned = sole("left", 0.0, 0.1);
    // The left sole may turn: the given heading, 0.6 rad inward, is not binding.
    let (s, c) = 0.6_f64.sin_cos();
    turned["R"] = json!([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]);
    turned["yaw_free"] = json!(true);
    let mut by_role = sole("right", 0.0, -0.1);
    by_role["patch"] = json!("foot");
    let problems = json!([
        {"id": 7, "mu": 0.6, "contacts": [sole("left", 0.0, 0.1), sole("right", 0.0, -0.1)]},
        {"id": "apart", "mu": 0.6, "contacts": [sole("left", 0.0, 0.1), sole("right", 3.0, -0.1)]},
        {"id": 9, "mu": 0.6, "contacts": [turned, by_role]},
    ]);
    let output = solve(folder.path(), &problems);
    assert_ended(&output, 0, &[]);
    let file = program::json(folder.path().join("results.json"));
    assert_eq!(file["joint_names"].as_array().map(Vec::len), Some(30));
    let results = list(&file["results"]);
    let ids: Vec<&Value> = results.iter().map(|r| &r["id"]).collect();
    assert_eq!(ids, [&json!(7), &json!("apart"), &json!(9)]);

    for feasible in [0, 2] {
        let result = &results[feasible];
        assert_eq!(result["outcome"], "feasible", "{result}");
        assert_eq!(result["q"].as_array().map(Vec::len), Some(3 + 4 + 30));
        assert!(number(&result["margins"]["joint_rad"]) > 0.0);
        assert!(number(&result["us"]) > 0.0);
        // The ground holds the robot, 58 kg at 9.81 m/s²: to the generator's 1e-5 of the weight.
        let [fx, fy, fz, ..] = wrench(result);
        let weight = 58.0 * 9.81;
        assert!(fx.abs() < 0.01 && fy.abs() < 0.01, "{fx} {fy}");
        assert!((fz - weight).abs() < 0.01, "{fz} is not {weight}");
    }
    // Feet 3 m apart are out of reach for any humanoid.
    assert_ne!(results[1]["outcome"], "feasible");
    assert!(results[1]["q"].is_null() && results[1]["forces"].is_null());
    let reason = results[1]["reason"].as_str().expect("a reason");
    assert!(reason.contains("foot"), "{reason}");
}

#[test]
fn a_problem_that_makes_no_sense_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let with = |change: fn(&mut Value)| {
        let mut contact = sole("left", 0.0, 0.1);
        change(&mut contact);
        json!([{"id": "first", "mu": 0.6, "contacts": [sole("left", 0.0, 0.1)]},
               {"id": "second", "mu": 0.6, "contacts": [contact]}])
    };
    let cases = [
        (with(|c| c["link"] = json!("LLEG_LINK9")), "LLEG_LINK9"),
        (with(|c| c["patch"] = json!("hoof")), "hoof"),
        (with(|c| c["R"][0][0] = json!(-1.0)), "mirrors"),
        (with(|c| c["R"][0][0] = json!(2.0)), "no rotation"),
    ];
    for (problems, word) in cases {
        let output = solve(folder.path(), &problems);
        assert_ended(&output, 1, &["problems.json", "second", "contact 0", word]);
        assert!(
            !folder.path().join("results.json").exists(),
            "results of a bad file"
        );
    }
}
