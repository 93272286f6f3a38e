//! The fastest law of continuous acceleration within given limits.

use super::OVER;
use crate::config::Config;
use crate::time_law::{Row, TimeLaw};

/// How often a law is sought at most.
const SMOOTHINGS: usize = 8;

/// How much slower a law has to be for its limits: an acceleration falls with the square of that.
pub(super) fn excess(rows: impl Iterator<Item = Row>, rate: f64, bend: f64) -> f64 {
    let used = rows.map(|r| (r.a * bend + r.b * rate * rate) / r.c);
    used.fold(0.0, f64::max).sqrt()
}

/// The fastest smooth law, and how much slower it has still to be: where the mean over time exceeds a
/// limit, the limits from which it came are drawn in, and the law is sought again.
pub(super) fn smooth(grid: &[Vec<Row>], config: &Config) -> Option<(TimeLaw, f64)> {
    let mut limits = grid.to_vec();
    let mut best: Option<(TimeLaw, f64)> = None;
    for _ in 0..SMOOTHINGS {
        let Some(law) = TimeLaw::fastest(&limits, config.smooth_s) else {
            break;
        };
        let used = interpolated(grid, &law, config.dt_s);
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
        let mut drawn = vec![1.0_f64; grid.len()];
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

/// The excess at every sample of a law, by limits between those of the grid, and the first and last
/// places of the grid from which the mean comes.
fn interpolated(grid: &[Vec<Row>], law: &TimeLaw, dt_s: f64) -> Vec<([usize; 2], f64)> {
    let pieces = grid.len() - 1;
    let steps = (law.duration_s() / dt_s).ceil() as usize;
    let over = (0..=steps).map(|i| {
        let t = i as f64 * dt_s;
        let [s, rate, bend] = law.at(t);
        let at = s.clamp(0.0, 1.0) * pieces as f64;
        let low = (at as usize).min(pieces - 1);
        let part = at - low as f64;
        let span = law.span(t).map(|s| s * pieces as f64);
        let span = [
            span[0].floor() as usize,
            (span[1].ceil() as usize).min(pieces),
        ];
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
