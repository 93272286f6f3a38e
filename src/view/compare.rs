//! Plans side by side: their figures in one table, their pages beside each other on one clock.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use plan::{Margins, Plan};
use serde_json::{Value, json};

use super::{ViewInput, page, stance};
use crate::config::differing;
use crate::template::render;

/// A plan of several, and what it is called.
pub struct Compared<'a> {
    /// Its name among them.
    pub name: &'a str,
    /// What its own page shows.
    pub input: ViewInput<'a>,
}

/// A unit: how it is written, how many of it a figure's SI unit is, and the digits behind the point.
type Unit = (&'static str, f64, usize);

const COUNT: Unit = ("", 1.0, 0);
const METRES: Unit = ("\u{a0}m", 1.0, 2);
const MILLIMETRES: Unit = ("\u{a0}mm", 1e3, 1);
const SECONDS: Unit = ("\u{a0}s", 1.0, 1);
const DEGREES: Unit = ("°", 180.0 / std::f64::consts::PI, 1);
const PERCENT: Unit = ("\u{a0}%", 1e2, 1);

/// A figure's name, how it is written, and whether less of it is better.
type Figure = (&'static str, Unit, Option<bool>);

/// The rows of the table, in the order of [`values`].
const FIGURES: [Figure; 15] = [
    ("Stances", COUNT, Some(true)),
    ("Contact changes, at least", COUNT, None),
    ("Duration of the motion", SECONDS, Some(true)),
    ("Way of the base", METRES, Some(true)),
    ("Way of the centre of mass", METRES, Some(true)),
    ("Largest tilt of the base", DEGREES, Some(true)),
    ("Friction used, of μ, at most", PERCENT, Some(true)),
    ("Torque used, of limit, at most", PERCENT, Some(true)),
    ("Joint range left, at least", DEGREES, Some(false)),
    ("Clearance to scene, at least", MILLIMETRES, Some(false)),
    ("Clearance to itself, at least", MILLIMETRES, Some(false)),
    ("Patch inside surface, at least", MILLIMETRES, Some(false)),
    ("CoM inside support, at least", MILLIMETRES, Some(false)),
    ("Contact sets in the tree", COUNT, None),
    ("Posture problems solved", COUNT, None),
];

/// Settings of which differences are told.
const TOLD: usize = 12;

/// The page of plans side by side, as HTML.
///
/// # Errors
/// As [`page`], with the name of the plan.
pub fn compare_page(plans: &[Compared]) -> Result<String> {
    let each = plans.iter().map(|one| {
        let about = || one.name.to_owned();
        let (html, values) = (
            page(&one.input).with_context(about)?,
            values(&one.input).with_context(about)?,
        );
        anyhow::Ok((html, values))
    });
    let each = each.collect::<Result<Vec<_>>>()?;
    let rows = FIGURES.iter().enumerate().map(|(k, figure)| {
        let of: Vec<Option<f64>> = each.iter().map(|(_, values)| values[k]).collect();
        row(figure, &of)
    });
    let first = plans.first().map(|one| &one.input.plan.config);
    let settings = plans.iter().skip(1).map(|one| {
        let mut found = Vec::new();
        first
            .into_iter()
            .for_each(|first| differing(&one.input.plan.config, first, "", &mut found));
        found.truncate(TOLD);
        json!({ "name": one.name, "differs": found })
    });
    let said = json!({
        "plans": plans.iter().zip(&each).map(|(one, (html, _))| json!({
            "name": one.name,
            "scene": one.input.plan.scene,
            "robot": one.input.plan.robot.name,
            "unsolved": one.input.plan.search.unsolved.as_ref().map(|u| &u.sentence),
            "duration_s": one.input.motion.map_or(0.0, |motion| motion.duration_s()),
            "html": html,
        })).collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
        "settings": settings.collect::<Vec<_>>(),
    });
    render("compare.html", include_str!("compare.html"), said)
}

/// A row of the table: the figures in words, and which is the best where they differ as they are written.
fn row(&(name, (unit, scale, digits), less): &Figure, values: &[Option<f64>]) -> Value {
    let shown = |value: &Option<f64>| match value {
        Some(value) => format!("{:.*}", digits, scale * value),
        None => "–".to_owned(),
    };
    let words: Vec<String> = values.iter().map(shown).collect();
    let all = values.iter().flatten().copied();
    let best = match less {
        Some(true) => all.reduce(f64::min),
        Some(false) => all.reduce(f64::max),
        None => None,
    };
    let best = shown(&best);
    let all_same = words.iter().all(|word| *word == words[0]);
    let cells = words
        .iter()
        .map(|word| json!({ "text": word, "best": !all_same && *word == best && best != "–" }));
    json!({ "name": name, "unit": unit, "cells": cells.collect::<Vec<_>>() })
}

/// The figures of a plan, in the order of [`FIGURES`].
fn values(input: &ViewInput) -> Result<[Option<f64>; FIGURES.len()]> {
    let (plan, motion) = (input.plan, input.motion);
    let states: Vec<(&[f64], [f64; 3])> = match motion {
        Some(motion) => motion.samples.iter().map(|s| (&s.q[..], s.com_W)).collect(),
        None => plan.stances.iter().map(|s| (&s.q[..], s.com_W)).collect(),
    };
    let base = states.iter().map(|(q, _)| Vector3::new(q[0], q[1], q[2]));
    let com = states.iter().map(|(_, com)| Vector3::from(*com));
    let tilt = states.iter().map(|(q, _)| {
        (1.0 - 2.0 * (q[3] * q[3] + q[4] * q[4]))
            .clamp(-1.0, 1.0)
            .acos()
    });
    let inside = plan.stances.iter().map(|one| {
        let record = stance::record(one, &plan.required, input.robot)?;
        anyhow::Ok(record["support"]["com_edge_m"].as_f64())
    });
    let inside = inside
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .flatten()
        .reduce(f64::min);
    let most = |of: fn(&Margins) -> f64| margins(plan).map(of).reduce(f64::max);
    let least = |of: fn(&Margins) -> Option<f64>| margins(plan).filter_map(of).reduce(f64::min);
    let search = &plan.search;
    Ok([
        Some(plan.stances.len() as f64),
        Some(search.changes_min as f64),
        motion.map(plan::Motion::duration_s),
        Some(length(base)),
        Some(length(com)),
        tilt.reduce(f64::max),
        most(|m| m.friction_use),
        most(|m| m.torque_use),
        least(|m| Some(m.joint_rad)),
        least(|m| m.clearance_m),
        least(|m| m.self_clearance_m),
        least(|m| m.inclusion_m),
        inside,
        Some(search.nodes_generated as f64),
        Some(search.candidates_solved as f64),
    ])
}

fn margins(plan: &Plan) -> impl Iterator<Item = &Margins> {
    plan.stances.iter().map(|stance| &stance.margins)
}

/// The length of a way through points, m.
fn length(points: impl Iterator<Item = Vector3<f64>> + Clone) -> f64 {
    let pairs = points.clone().zip(points.skip(1));
    pairs.map(|(a, b)| (b - a).norm()).sum()
}
