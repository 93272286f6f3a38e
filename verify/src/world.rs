//! What a plan rests on: its world and its task, beside what was found again from its files.

use nalgebra::Vector3;
use plan::{Change, Contact, Input, Limits, Motion, Plan};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::Check;
use crate::findings::Findings;

/// Numbers that differ by less than this are one: what the mathematics of two machines may differ by.
const ROUNDING: f64 = 1e-6;

/// How far a contact of the first stance may be from where the robot stands as it is asked to, m: feet
/// are put on the faces that were found, and joints moved inside their margins.
const START_M: f64 = 0.01;

/// Differences that are told of one part of a plan at most.
const TOLD: usize = 3;

/// The parts of a plan that its files decide, as they were found again from them.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// By their names in `plan.json`.
    said: Map<String, Value>,
    /// The contacts at the start: patch, face, place in W, m.
    start: Option<Vec<(String, String, [f64; 3])>>,
    /// What its motion keeps to.
    limits: Option<Limits>,
    /// The files, in any order.
    inputs: Vec<Input>,
    /// What could not be found again, in words.
    unknown: Vec<String>,
    /// What to know beside the checks, in words.
    notes: Vec<String>,
    /// Whether what differs may have been asked for beside the files.
    overridden: bool,
}

impl World {
    /// Says what a part of the plan must be.
    ///
    /// # Errors
    /// What is no JSON.
    pub fn says(&mut self, name: &str, value: impl Serialize) -> Result<(), serde_json::Error> {
        self.said
            .insert(name.to_owned(), serde_json::to_value(value)?);
        Ok(())
    }

    /// Says how the robot stands at the start: which patch on which face, and where in W, m.
    pub fn starts(&mut self, on: impl Iterator<Item = (String, String, [f64; 3])>) {
        self.start = Some(on.collect());
    }

    /// Says what the motion keeps to.
    pub fn moves(&mut self, limits: Limits) {
        self.limits = Some(limits);
    }

    /// Says which files it was found in.
    pub fn rests_on(&mut self, inputs: Vec<Input>) {
        self.inputs = inputs;
    }

    /// Says what could not be found again: the plan is taken at its word there.
    pub fn leaves_open(&mut self, what: impl Into<String>) {
        self.unknown.push(what.into());
    }

    /// Says what to know of the plan beside the checks: it is told, and is no condition.
    pub fn tells(&mut self, what: impl Into<String>) {
        self.notes.push(what.into());
    }

    /// Takes what differs from the files to be asked for elsewhere: it is told, and no flaw.
    pub fn may_be_overridden(&mut self) {
        self.overridden = true;
    }
}

/// Compares a plan with the world that its files describe.
pub(crate) fn check(plan: &Plan, motion: Option<&Motion>, world: &World, findings: &mut Findings) {
    let mut differing: Vec<(String, String)> = Vec::new();
    for (name, value) in &world.said {
        let mut found = Vec::new();
        differences(&part(plan, name), value, name, &mut found);
        let more = found.len().saturating_sub(TOLD);
        found.truncate(TOLD);
        let mut note = found.join("; ");
        if more > 0 {
            note += &format!("; and {more} more");
        }
        if !note.is_empty() {
            differing.push((name.clone(), note));
        }
    }
    if let (Some(start), Some(first)) = (&world.start, plan.stances.first()) {
        let is_there = |(patch, face, p): &(String, String, [f64; 3])| {
            let mut contacts = first.contacts.iter();
            let same = |c: &&Contact| c.patch == *patch && c.face.as_str() == face;
            let off = |c: &Contact| (Vector3::from(c.X_WC.p) - Vector3::from(*p)).norm();
            contacts.find(same).is_some_and(|c| off(c) <= START_M)
        };
        let start_is = first.change == Change::Start && first.contacts.len() == start.len();
        if !(start_is && start.iter().all(is_there)) {
            let note = format!("the robot stands on {start:?} (patch, face, place)");
            differing.push(("start".to_owned(), note));
        }
    }
    let missing = |of: &[Input], all: &[Input]| -> Vec<String> {
        let same = |a: &Input, b: &Input| a.role == b.role && a.sha256 == b.sha256;
        let lacking = of.iter().filter(|a| !all.iter().any(|b| same(a, b)));
        lacking.map(|a| format!("{} {}", a.role, a.name)).collect()
    };
    if !world.inputs.is_empty() {
        let other = missing(&plan.inputs, &world.inputs);
        let other = other
            .into_iter()
            .chain(missing(&world.inputs, &plan.inputs));
        if let Some(name) = other.into_iter().next() {
            differing.push(("inputs".to_owned(), format!("{name} is another file now")));
        }
    }
    if let (Some(limits), Some(motion)) = (&world.limits, motion)
        && motion.limits != *limits
    {
        let note = format!("{:?} instead of {limits:?}", motion.limits);
        differing.push(("motion".to_owned(), note));
    }
    for (part, note) in differing {
        match world.overridden {
            true => findings.condition(format!(
                "{part}: not as in the files that are named: {note}"
            )),
            false => findings.flaw(None, Check::World, part, note),
        }
    }
    findings.holds_unless_flawed(None, Check::World);
    world
        .unknown
        .iter()
        .for_each(|what| findings.condition(what.clone()));
    findings.note(&world.notes);
}

/// A part of a plan by its name.
fn part(plan: &Plan, name: &str) -> Value {
    let value = match name {
        "scene" => serde_json::to_value(&plan.scene),
        "robot" => serde_json::to_value(&plan.robot),
        "faces" => serde_json::to_value(&plan.faces),
        "obstacles" => serde_json::to_value(&plan.obstacles),
        "thin_body_m" => serde_json::to_value(plan.thin_body_m),
        "required" => serde_json::to_value(&plan.required),
        "goal" => serde_json::to_value(&plan.goal),
        _ => Ok(Value::Null),
    };
    value.unwrap_or_default()
}

/// Where two values differ, and how.
fn differences(stated: &Value, real: &Value, path: &str, found: &mut Vec<String>) {
    let both = |found: &mut Vec<String>| {
        found.push(format!(
            "{path}: {} instead of {}",
            short(stated),
            short(real)
        ))
    };
    match (stated, real) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                differences(a, b, &format!("{path}[{k}]"), found);
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            for key in keys {
                let of = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or_default();
                differences(&of(a), &of(b), &format!("{path}.{key}"), found);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (
                a.as_f64().unwrap_or(f64::NAN),
                b.as_f64().unwrap_or(f64::NAN),
            );
            let same = (a - b).abs() <= ROUNDING * b.abs().max(1.0);
            if !same {
                both(found);
            }
        }
        _ if stated != real => both(found),
        _ => {}
    }
}

/// A value in a few words.
fn short(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("{} of them", items.len()),
        Value::Object(_) => "something".to_owned(),
        Value::Null => "none".to_owned(),
        other => other.to_string(),
    }
}
