//! The fastest law of continuous acceleration within given limits.

use super::OVER;
use crate::config::Config;
use crate::time_law::{Row, TimeLaw};

/// The limits at equally spaced places of phases that are gone through one after the other: phase k from
/// s = k to k + 1.
pub(super) struct Grid {
    rows: Vec<Vec<Vec<Row>>>,
    /// Number of each phase's first place, where the last one's last one is the same place.
    first: Vec<usize>,
}

impl Grid {
    pub fn new(rows: Vec<Vec<Vec<Row>>>) -> Self {
        let mut first = vec![0];
        for phase in &rows {
            first.push(first[first.len() - 1] + phase.len() - 1);
        }
        Self { rows, first }
    }

    /// Every place, and its limits: at a border those of both phases.
    fn merged(&self) -> (Vec<f64>, Vec<Vec<Row>>) {
        let mut at = vec![0.0];
        let mut all = vec![Vec::new()];
        for (k, phase) in self.rows.iter().enumerate() {
            let pieces = (phase.len() - 1) as f64;
            all[self.first[k]].extend(&phase[0]);
            for (i, rows) in phase.iter().enumerate().skip(1) {
                at.push(k as f64 + i as f64 / pieces);
                all.push(rows.clone());
            }
        }
        (at, all)
    }

    /// The phase of a parameter, and how far along its places that is.
    fn along(&self, s: f64) -> (usize, f64) {
        let k = (s.max(0.0) as usize).min(self.rows.len() - 1);
        let pieces = self.rows[k].len() - 1;
        (k, (s - k as f64).clamp(0.0, 1.0) * pieces as f64)
    }

    /// The excess at every sample of a law, by limits between those of the grid, and the first and last
    /// places of the grid from which the mean comes.
    fn excesses(&self, law: &TimeLaw, dt_s: f64) -> Vec<([usize; 2], f64)> {
        let steps = (law.duration_s() / dt_s).ceil() as usize;
        let over = (0..=steps).map(|i| {
            let t = i as f64 * dt_s;
            let [s, rate, bend] = law.at(t);
            let (k, at) = self.along(s);
            let grid = &self.rows[k];
            let low = (at as usize).min(grid.len() - 2);
            let part = at - low as f64;
            let number = |s: f64, round: fn(f64) -> f64| {
                let (k, at) = self.along(s);
                self.first[k] + round(at) as usize
            };
            let [from, to] = law.span(t);
            let span = [number(from, f64::floor), number(to, f64::ceil)];
            let mix = |a: f64, b: f64| a + part * (b - a);
            let rows = grid[low].iter().zip(&grid[low + 1]).map(|(r, n)| Row {
                a: mix(r.a, n.a),
                b: mix(r.b, n.b),
                c: mix(r.c, n.c),
            });
            (span, excess(rows, rate, bend))
        });
        over.collect()
    }
}

/// How much slower a law has to be for its limits: an acceleration falls with the square of that.
pub(super) fn excess(rows: impl Iterator<Item = Row>, rate: f64, bend: f64) -> f64 {
    let used = rows.map(|r| (r.a * bend + r.b * rate * rate) / r.c);
    used.fold(0.0, f64::max).sqrt()
}

/// The fastest smooth law, and how much slower it has still to be: where the mean over time exceeds a
/// limit, the limits from which it came are drawn in, and the law is sought again, `tries` times in all.
pub(super) fn smooth(grid: &Grid, config: &Config, tries: usize) -> Option<(TimeLaw, f64)> {
    let (at, mut limits) = grid.merged();
    let mut best: Option<(TimeLaw, f64)> = None;
    for _ in 0..tries {
        let Some(law) = TimeLaw::fastest(&at, &limits, config.smooth_s) else {
            break;
        };
        let used = grid.excesses(&law, config.dt_s);
        let over = used.iter().fold(0.0, |a: f64, (_, over)| a.max(*over));
        let time = |law: &TimeLaw, over: f64| law.duration_s() * over.max(1.0);
        if best
            .as_ref()
            .is_none_or(|(b, o)| time(&law, over) < time(b, *o))
        {
            best = Some((law, over));
        }
        if over <= 1.0 + OVER {
            break;
        }
        let mut drawn = vec![1.0_f64; limits.len()];
        for ([from, to], over) in used {
            for k in drawn[from..=to].iter_mut() {
                *k = k.max(over * over);
            }
        }
        for (rows, k) in limits.iter_mut().zip(drawn) {
            rows.iter_mut().for_each(|row| row.c /= k);
        }
    }
    best
}
