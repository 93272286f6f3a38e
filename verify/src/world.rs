//! What a plan rests on: its world and its task, beside what was found again from its files.

use plan::{Change, Input, Limits, Motion, Plan};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::Check;
use crate::findings::{Findings, exceeds};

/// Numbers that differ by less than this are one: what the mathematics of two machines may differ by.
const ROUNDING: f64 = 1e-6;

/// How far the first stance may be from the start that is asked for, m and rad: feet are put on the
/// faces that were found.
const START: f64 = 0.01;

/// Differences that are told of one part of a plan at most.
const TOLD: usize = 3;

/// The parts of a plan that its files decide, as they were found again from them.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// By their names in `plan.json`.
    said: Map<String, Value>,
    /// Posture and contacts (patch, face) at the start.
    start: Option<(Vec<f64>, Vec<(String, String)>)>,
    /// What its motion keeps to.
    limits: Option<Limits>,
    /// The files, in any order.
    inputs: Vec<Input>,
    /// What could not be found again, in words.
    unknown: Vec<String>,
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

    /// Says how the robot stands at the start: its configuration, and which patch on which face.
    pub fn starts(&mut self, q: Vec<f64>, on: impl Iterator<Item = (String, String)>) {
        self.start = Some((q, on.collect()));
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
    if let (Some((q, on)), Some(first)) = (&world.start, plan.stances.first()) {
        let mut found = Vec::new();
        let off = q.iter().zip(&first.q).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        if q.len() != first.q.len() || exceeds(off, START) {
            found.push(format!("the posture is off by {off:.4} m or rad"));
        }
        let stands = first.contacts.iter();
        let mut stands: Vec<_> = stands
            .map(|c| (c.patch.clone(), c.face.to_string()))
            .collect();
        let mut on = on.clone();
        (stands.sort(), on.sort());
        if first.change != Change::Start || stands != on {
            found.push(format!("on {stands:?}, the files say {on:?}"));
        }
        if let Some(note) = found.into_iter().next() {
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
