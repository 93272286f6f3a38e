//! Every number and word of a plan and of its motion, changed in turn, is caught, or stands here among
//! those that claim nothing.

use std::collections::BTreeSet;

use plan::{Motion, Plan};
use serde_json::Value;
use verify::{Certificate, World, verify_in};

use crate::support::program::robot;
use crate::support::shipped::{Shipped, shipped};

/// What may be changed without a word: who made the plan and how, and what claims less than holds.
#[rustfmt::skip]
const CLAIMS_NOTHING: &[&str] = &[
    // Who, by what, and how the search went.
    "program.name", "program.version", "seed", "inputs.*.name", "search.nodes_generated",
    "search.nodes_expanded", "search.candidates_solved", "search.route.*.*", "search.changes_min",
    // Settings: what they make of the world is compared, the rest is how it was found.
    "config",
    // Named by the plan and opened by the program, which holds it against its hash.
    "motion.file", "motion.sha256",
    // A distance that is worse than there is, and still what is promised.
    "stances.*.margins.inclusion_m", "stances.*.margins.clearance_m",
    "stances.*.margins.self_clearance_m",
];

/// The world of the plan itself, as its files give it.
fn world(plan: &Plan) -> World {
    let mut world = World::default();
    world.says("scene", &plan.scene).unwrap();
    world.says("robot", &plan.robot).unwrap();
    world.says("faces", &plan.faces).unwrap();
    world.says("obstacles", &plan.obstacles).unwrap();
    world.says("thin_body_m", plan.thin_body_m).unwrap();
    world.says("required", &plan.required).unwrap();
    world.says("goal", &plan.goal).unwrap();
    let on = plan.stances[0].contacts.iter();
    let on = on.map(|c| (c.patch.clone(), c.face.to_string(), c.X_WC.p));
    world.starts(on);
    world.rests_on(plan.inputs.clone());
    world
}

/// The paths of all leaves, and each path with stars for places in lists.
fn leaves(value: &Value, path: &str, pattern: &str, found: &mut Vec<(String, String)>) {
    match value {
        Value::Array(items) => (items.iter().enumerate()).for_each(|(k, item)| {
            leaves(item, &format!("{path}/{k}"), &format!("{pattern}.*"), found);
        }),
        Value::Object(members) => members.iter().for_each(|(key, item)| {
            leaves(
                item,
                &format!("{path}/{key}"),
                &format!("{pattern}.{key}"),
                found,
            );
        }),
        _ => found.push((path.to_owned(), pattern.trim_start_matches('.').to_owned())),
    }
}

/// Other values of a leaf: off by more than what the arithmetic allows (a thousandth of the weight, half
/// of a joint's acceleration).
fn others(leaf: &Value, pattern: &str) -> Vec<Value> {
    let least = match pattern {
        _ if pattern.contains("forces_W") || pattern.contains(".tau.") => 5.0,
        // A point that bears nothing may be anywhere on its patch.
        _ if pattern.contains("force_points_W") => 0.3,
        "samples.*.a.*" => 30.0,
        "samples.*.v.*" => 0.1,
        _ => 0.05,
    };
    match leaf {
        Value::Number(number) if number.is_f64() => {
            let x = number.as_f64().unwrap();
            let by = least + 0.05 * x.abs();
            vec![(x + by).into(), (x - by).into()]
        }
        Value::Number(number) => vec![(number.as_u64().unwrap() + 1).into()],
        Value::String(text) => vec![format!("{text}x").into()],
        Value::Bool(is) => vec![(!is).into()],
        _ => vec![0.5.into()],
    }
}

/// The patterns of which a change in some leaf passes `verdict`, of every `stride`-th leaf.
fn escaped(whole: &Value, stride: usize, passes: impl Fn(&Value) -> bool) -> BTreeSet<String> {
    let mut all = Vec::new();
    leaves(whole, "", "", &mut all);
    let mut seen: BTreeSet<&String> = BTreeSet::new();
    let mut escaped = BTreeSet::new();
    for (k, (path, pattern)) in all.iter().enumerate() {
        // The first of every kind, and some of all.
        if !seen.insert(pattern) && k % stride != 0 {
            continue;
        }
        for other in others(whole.pointer(path).unwrap(), pattern) {
            let mut changed = whole.clone();
            *changed.pointer_mut(path).unwrap() = other;
            if passes(&changed) {
                escaped.insert(pattern.clone());
            }
        }
    }
    escaped
}

fn judge(escaped: &BTreeSet<String>, allowed: &[&str]) {
    let is_allowed = |pattern: &&String| {
        let under = |name: &&str| *pattern == name || pattern.starts_with(&format!("{name}."));
        allowed.iter().any(under)
    };
    let unnoticed: Vec<_> = escaped
        .iter()
        .filter(|pattern| !is_allowed(pattern))
        .collect();
    assert!(unnoticed.is_empty(), "passed unnoticed: {unnoticed:#?}");
}

fn unconditional(certificate: &Certificate) -> bool {
    certificate.pass && certificate.conditions.is_empty()
}

fn plan_and_motion(planned: &Shipped) -> (Value, Value) {
    let plan = serde_json::to_value(&planned.plan).unwrap();
    (plan, serde_json::to_value(&planned.motion).unwrap())
}

#[test]
fn every_leaf_of_a_plan_is_caught_or_claims_nothing() {
    let planned = shipped("slope-and-hand");
    let (mut robot, world) = (robot("hrp2"), world(&planned.plan));
    // The scene's friction.
    for contact in planned.plan.stances.iter().flat_map(|s| &s.contacts) {
        let patch = robot.patch_index(&contact.patch).unwrap();
        robot.patches[patch].friction = contact.friction;
    }
    // The motion is gone through once, with the plan as it is.
    let whole = verify_in(&planned.plan, Some(&planned.motion), &robot, &world);
    assert!(unconditional(&whole), "{}", whole.table());
    let (plan, _) = plan_and_motion(planned);
    let passes = |changed: &Value| {
        let Ok(plan) = serde_json::from_value::<Plan>(changed.clone()) else {
            return false;
        };
        // The motion is gone through where what the plan says of it is changed.
        let touched = plan.motion != planned.plan.motion;
        let motion = touched.then_some(&planned.motion);
        let certificate = verify_in(&plan, motion, &robot, &world);
        certificate.pass && certificate.conditions.len() == usize::from(!touched)
    };
    let stride = plan.to_string().len() / 400;
    judge(&escaped(&plan, stride, passes), CLAIMS_NOTHING);
}

#[test]
fn every_leaf_of_a_motion_is_caught_or_claims_nothing() {
    let planned = shipped("irregular-stairs");
    let (robot, mut world) = (robot("hrp2"), world(&planned.plan));
    world.moves(planned.motion.limits);
    let (_, motion) = plan_and_motion(planned);
    let passes = |changed: &Value| {
        let Ok(motion) = serde_json::from_value::<Motion>(changed.clone()) else {
            return false;
        };
        unconditional(&verify_in(&planned.plan, Some(&motion), &robot, &world))
    };
    let stride = motion.to_string().len() / 200;
    judge(&escaped(&motion, stride, passes), &[]);
}
