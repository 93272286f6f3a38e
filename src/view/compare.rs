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

/// How a figure is written, and whether less of it is better.
struct Figure {
    name: &'static str,
    unit: &'static str,
    scale: f64,
    digits: usize,
    less: Option<bool>,
}

const fn figure(
    name: &'static str,
    unit: &'static str,
    scale: f64,
    digits: usize,
    less: Option<bool>,
) -> Figure {
    Figure {
        name,
        unit,
        scale,
        digits,
        less,
    }
}

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// The rows of the table, in the order of [`values`].
const FIGURES: [Figure; 15] = [
    figure("Stances", "", 1.0, 0, Some(true)),
    figure("Contact changes, at least", "", 1.0, 0, None),
    figure("Duration of the motion", "\u{a0}s", 1.0, 1, Some(true)),
    figure("Way of the base", "\u{a0}m", 1.0, 2, Some(true)),
    figure("Way of the centre of mass", "\u{a0}m", 1.0, 2, Some(true)),
    figure("Largest tilt of the base", "°", DEGREES, 1, Some(true)),
    figure(
        "Friction used, of μ, at most",
        "\u{a0}%",
        1e2,
        1,
        Some(true),
    ),
    figure(
        "Torque used, of limit, at most",
        "\u{a0}%",
        1e2,
        1,
        Some(true),
    ),
    figure("Joint range left, at least", "°", DEGREES, 1, Some(false)),
    figure(
        "Clearance to scene, at least",
        "\u{a0}mm",
        1e3,
        1,
        Some(false),
    ),
    figure(
        "Clearance to itself, at least",
        "\u{a0}mm",
        1e3,
        1,
        Some(false),
    ),
    figure(
        "Patch inside surface, at least",
        "\u{a0}mm",
        1e3,
        1,
        Some(false),
    ),
    figure(
        "CoM inside support, at least",
        "\u{a0}mm",
        1e3,
        1,
        Some(false),
    ),
    figure("Contact sets in the tree", "", 1.0, 0, None),
    figure("Posture problems solved", "", 1.0, 0, None),
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
fn row(figure: &Figure, values: &[Option<f64>]) -> Value {
    let shown = |value: &Option<f64>| match value {
        Some(value) => format!("{:.*}", figure.digits, figure.scale * value),
        None => "–".to_owned(),
    };
    let words: Vec<String> = values.iter().map(shown).collect();
    let all = values.iter().flatten().copied();
    let best = match figure.less {
        Some(true) => all.reduce(f64::min),
        Some(false) => all.reduce(f64::max),
        None => None,
    };
    let best = shown(&best);
    let all_same = words.iter().all(|word| *word == words[0]);
    let cells = words
        .iter()
        .map(|word| json!({ "text": word, "best": !all_same && *word == best && best != "–" }));
    json!({ "name": figure.name, "unit": figure.unit, "cells": cells.collect::<Vec<_>>() })
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
