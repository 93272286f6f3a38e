//! Posture problems drawn from a seed: how many have a posture, and after how many iterations.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::program::{Program, argument, json};
use crate::table::Worse::{Less, More, Neither};
use crate::table::{Table, column, median};

/// Robots and the families that can be drawn for them.
const SETS: [(&str, &str); 3] = [
    ("hrp2", "easy free steep one-foot chimney spread infeasible"),
    ("hexapod", "easy free steep infeasible"),
    ("quadruped", "easy free steep infeasible"),
];

/// Solves `count` problems of every family with seed 1.
pub fn sets(program: &Program, count: usize, folder: &Path) -> Result<Table> {
    let mut table = Table::new(
        &format!("Posture sets of {count} problems"),
        vec![
            column("with a posture", Less, 1.0, 0.0, 0),
            column("infeasible", Neither, 0.0, 0.0, 0),
            column("undecided", More, 1.0, 0.0, 0),
            column("median iterations", More, 1.0, 0.1, 1),
        ],
    );
    let (problems, results) = (folder.join("problems.json"), folder.join("results.json"));
    for (robot, families) in SETS {
        for family in families.split(' ') {
            let robot_flag = format!("builtin:{robot}");
            let (count, out) = (count.to_string(), argument(&problems));
            let robot_flags = ["--robot", &robot_flag];
            let draw = ["posture-sets", "--family", family, "--count", &count];
            let rest = ["--seed", "1", "-o", &out];
            program.run(&[&draw[..], &robot_flags, &rest].concat(), &[0])?;
            let (solve, to) = (["posture", &out], argument(&results));
            let args = [&solve[..], &robot_flags, &["-o", &to]].concat();
            program.run(&args, &[0, 3])?;
            table.push(format!("{robot}, {family}"), figures(&json(&results)?)?);
        }
    }
    Ok(table)
}

fn figures(file: &Value) -> Result<Vec<Option<f64>>> {
    let results = file["results"].as_array().context("no `results`")?;
    let of = |outcome: &'static str| results.iter().filter(move |r| r["outcome"] == outcome);
    let count = |outcome| Some(of(outcome).count() as f64);
    let iterations = of("feasible").filter_map(|r| r["iterations"].as_f64());
    let iterations = median(&iterations.collect::<Vec<_>>());
    let counts = ["feasible", "infeasible", "undecided"].map(count);
    Ok([&counts[..], &[iterations]].concat())
}
