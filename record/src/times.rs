//! Times of two programs, taken in turns.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use crate::plans::plan;
use crate::program::{Program, json};
use crate::table::Worse::{More, Neither};
use crate::table::{Table, column, median};

/// Stages of a run, as its report calls them.
const STAGES: [&str; 4] = ["perception", "planning", "motion", "verify"];

/// Of every scene the new program's time over the old one's, stage by stage: medians of `runs` runs,
/// the programs in turns, on one thread.
pub fn ratios(
    new: &Program,
    old: &Program,
    names: &[&str],
    runs: usize,
    folder: &Path,
) -> Result<Table> {
    let mut columns = vec![column("old run ms", Neither, 0.0, 0.0, 0)];
    columns.extend(STAGES.map(|stage| column(&format!("{stage}, new/old"), More, 0.15, 0.0, 2)));
    columns.push(column("all, new/old", More, 0.15, 0.0, 2));
    let title = format!("Times, medians of {runs} runs on one thread");
    let mut table = Table::new(&title, columns);
    for name in names {
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..runs {
            for (program, times) in [new, old].into_iter().zip(&mut times) {
                let folder = folder.join("times");
                plan(program, name, &["--threads".into(), "1".into()], &folder)?;
                times.push(json(&folder.join("report.json"))?);
            }
        }
        let stage = |reports: &[Value], name: &str| {
            let of = |r: &Value| r["stages_ms"][name].as_f64();
            median(&reports.iter().filter_map(of).collect::<Vec<_>>())
        };
        let whole = |reports: &[Value]| {
            let of = |r: &Value| {
                let stages = r["stages_ms"].as_object()?.values();
                Some(stages.filter_map(Value::as_f64).sum::<f64>())
            };
            median(&reports.iter().filter_map(of).collect::<Vec<_>>())
        };
        let [new, old] = &times;
        let ratio = |new: Option<f64>, old: Option<f64>| Some(new? / old?);
        let mut figures = vec![whole(old)];
        figures.extend(STAGES.map(|name| ratio(stage(new, name), stage(old, name))));
        figures.push(ratio(whole(new), whole(old)));
        table.push(*name, figures);
    }
    Ok(table)
}

/// What a table of ratios is compared to: as fast as before.
pub fn as_before(ratios: &Table) -> Table {
    let mut before = ratios.clone();
    for row in &mut before.rows {
        for (figure, column) in row.figures.iter_mut().zip(&before.columns) {
            if column.worse == More {
                *figure = figure.map(|_| 1.0);
            }
        }
    }
    before
}
