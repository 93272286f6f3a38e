//! How long the solves took.

use std::io::Write;

use anyhow::Result;

use super::{Answer, FEASIBLE};

/// The value below which the part `q` of the values lies: the nearest rank; 0 of no values.
pub(super) fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let rank = (q * values.len() as f64).ceil() as usize;
    let value = values.get(rank.saturating_sub(1).min(last));
    value.copied().unwrap_or(0.0)
}

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

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_are_nearest_ranks() {
        let mut values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(quantile(&mut values, 0.5), 10.0);
        assert_eq!(quantile(&mut values, 0.95), 19.0);
        assert_eq!(quantile(&mut values, 1.0), 20.0);
        assert_eq!(quantile(&mut [3.0], 0.5), 3.0);
        assert_eq!(quantile(&mut [], 0.5), 0.0);
    }
}
