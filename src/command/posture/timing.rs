//! How long the solves took.

use std::io::Write;

use anyhow::Result;

use super::{Answer, FEASIBLE};
use crate::report::quantile;

/// Median and 95th percentile of the times of those with and of those without a posture.
pub(super) fn print(answers: &[Answer], out: &mut dyn Write) -> Result<()> {
    for (what, solved) in [("with a posture", true), ("without one", false)] {
        let such = answers.iter();
        let such = such.filter(|a| (a.outcome == FEASIBLE) == solved);
        let mut us: Vec<f64> = such.map(|answer| answer.us).collect();
        if us.is_empty() {
            continue;
        }
        let (median, p95) = (quantile(&mut us, 0.5), quantile(&mut us, 0.95));
        writeln!(
            out,
            "  {:<14} {:>5}: median {median:.0} µs, 95 % within {p95:.0} µs",
            what,
            us.len()
        )?;
    }
    Ok(())
}
