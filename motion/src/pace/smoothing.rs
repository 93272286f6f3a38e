//! The fastest law of continuous acceleration within given limits.

use super::{OVER, place_s, places_before};
use crate::config::Config;
use crate::time_law::{Row, TimeLaw};

/// The limits that bind at places of phases that are gone through one after the other: phase k from s = k to
/// k + 1; a law keeps those of both phases at a border.
pub(super) struct Grid {
    at: Vec<f64>,
    limits: Vec<Vec<Row>>,
    /// By what factor these are drawn in, where a law's mean over time would exceed them else.
    drawn: Vec<f64>,
    /// Those of each phase as they are.
    own: Vec<Vec<Vec<Row>>>,
    /// Number of each phase's first place; the last one's last place is the end.
    first: Vec<usize>,
}

/// A little more than what an excess asks for: the next law's samples meet sharp places elsewhere.
const DRAWN: f64 = 1.004;

/// By how much a law exceeds the limits at `s`.
pub(super) struct Excess {
    pub s: f64,
    /// The stretch of s over which the law's mean is taken there.
    pub span: [f64; 2],
    pub over: f64,
    /// What binds at `s`, where that is known better than from the places beside it.
    pub rows: Vec<Row>,
}

/// The largest excess, 1 at least.
pub(super) fn worst<'a>(used: impl Iterator<Item = &'a Excess>) -> f64 {
    used.fold(1.0, |worst, excess| worst.max(excess.over))
}

impl Grid {
    /// Of the limits of every phase, all of which bind.
    pub fn new(own: Vec<Vec<Vec<Row>>>) -> Self {
        let mut grid = Self {
            at: vec![0.0],
            limits: vec![Vec::new()],
            drawn: Vec::new(),
            first: vec![0],
            own: Vec::new(),
        };
        for (k, phase) in own.iter().enumerate() {
            let pieces = phase.len() - 1;
            let border = grid.limits.len() - 1;
            grid.limits[border].extend(&phase[0]);
            grid.limits.extend(phase[1..].iter().cloned());
            grid.at
                .extend((1..=pieces).map(|i| k as f64 + place_s(i, pieces)));
            grid.first.push(border + pieces);
        }
        grid.drawn = vec![1.0; grid.limits.len()];
        grid.own = own;
        grid
    }

    /// The limits of every phase, those included that were taken in.
    pub fn into_own(self) -> Vec<Vec<Vec<Row>>> {
        self.own
    }

    /// The phase of a parameter, and how far along its places that is.
    fn along(&self, s: f64) -> (usize, f64) {
        let k = (s.max(0.0) as usize).min(self.own.len() - 1);
        let pieces = self.own[k].len() - 1;
        (k, places_before(s - k as f64, pieces))
    }

    /// The excess at every sample of a law, between those of the places beside it.
    fn excesses(&self, law: &TimeLaw, dt_s: f64) -> Vec<Excess> {
        let steps = (law.duration_s() / dt_s).ceil() as usize;
        let over = (0..=steps).map(|i| {
            let t = i as f64 * dt_s;
            let ([s, rate, bend], span) = law.with_span(t);
            let (k, at) = self.along(s);
            let low = (at as usize).min(self.own[k].len() - 2);
            let [a, b] = [low, low + 1].map(|i| excess(&self.own[k][i], rate, bend));
            Excess {
                s,
                span,
                over: a + (at - low as f64) * (b - a),
                rows: Vec::new(),
            }
        });
        over.collect()
    }

    /// Draws in the limits from which these excesses come, and takes in those that are known between the places.
    pub fn draw_in<'a>(&mut self, used: impl Iterator<Item = &'a Excess>) {
        let mut drawn = vec![1.0_f64; self.limits.len()];
        for Excess {
            s,
            span,
            over,
            rows,
        } in used
        {
            let [from, to] = *span;
            let number = |s: f64, round: fn(f64) -> f64| {
                let (k, at) = self.along(s);
                self.first[k] + round(at) as usize
            };
            for k in &mut drawn[number(from, f64::floor)..=number(to, f64::ceil)] {
                *k = k.max(over * over * DRAWN);
            }
            let (k, at) = self.along(*s);
            let low = (at as usize).min(self.own[k].len() - 2);
            for i in [low, low + 1] {
                self.own[k][i].extend(rows);
                self.limits[self.first[k] + i].extend(rows);
            }
        }
        let factors = self.drawn.iter_mut().zip(drawn);
        factors.for_each(|(factor, k)| *factor *= k);
    }
}

/// What binds at some s̈ and ṡ² ≥ 0, over what is allowed: of the points (a, b)/c the upper hull.
pub(super) fn binding(rows: &mut [Row]) -> Vec<Row> {
    for row in rows.iter_mut() {
        let part = row.c.recip();
        *row = Row {
            a: row.a * part,
            b: row.b * part,
            c: 1.0,
        };
    }
    let Some(&first) = rows.first() else {
        return Vec::new();
    };
    let [mut left, mut top, mut right] = [first; 3];
    for row in &*rows {
        if row.a < left.a || (row.a == left.a && row.b > left.b) {
            left = *row;
        }
        if row.a > right.a || (row.a == right.a && row.b > right.b) {
            right = *row;
        }
        if row.b > top.b {
            top = *row;
        }
    }
    // What is under both ends is under every line between corners.
    let (mut count, least) = (0, left.b.min(right.b));
    for i in 0..rows.len() {
        if rows[i].b > least {
            rows.swap(i, count);
            count += 1;
        }
    }
    let rows = &mut rows[..count];
    let mut hull = vec![left];
    corners(rows, [left, top], &mut hull);
    corners(rows, [top, right], &mut hull);
    hull
}

/// Appends the corners of the hull from `p` on to `q`, which is one: the point farthest over the line between them
/// is one, and what is under it none.
fn corners(rows: &mut [Row], [p, q]: [Row; 2], hull: &mut Vec<Row>) {
    let (mut count, mut most, mut farthest) = (0, 0.0, q);
    for i in 0..rows.len() {
        let row = rows[i];
        let over = (q.a - p.a) * (row.b - p.b) - (q.b - p.b) * (row.a - p.a);
        if over > 0.0 {
            rows.swap(i, count);
            count += 1;
            if over > most {
                (most, farthest) = (over, row);
            }
        }
    }
    if count > 0 {
        let rows = &mut rows[..count];
        corners(rows, [p, farthest], hull);
        corners(rows, [farthest, q], hull);
    } else if q != p {
        hull.push(q);
    }
}

/// How much slower a law has to be for its limits: an acceleration falls with the square of that.
pub(super) fn excess(rows: &[Row], rate: f64, bend: f64) -> f64 {
    let used = rows.iter().map(|r| (r.a * bend + r.b * rate * rate) / r.c);
    used.fold(0.0, f64::max).sqrt()
}

/// The fastest smooth law, and how much slower it has still to be: where the mean over time exceeds a
/// limit, the limits from which it came are drawn in, and the law is sought again, `tries` times in all. Asked
/// again, it goes on from there.
pub(super) fn smooth(grid: &mut Grid, config: &Config, tries: usize) -> Option<(TimeLaw, f64)> {
    let mut best: Option<(TimeLaw, f64)> = None;
    for _ in 0..tries {
        let Some(law) = TimeLaw::within(&grid.at, &grid.limits, &grid.drawn, config.smooth_s)
        else {
            break;
        };
        let used = grid.excesses(&law, config.dt_s);
        let over = worst(used.iter());
        let time = |law: &TimeLaw, over: f64| law.duration_s() * over;
        if best
            .as_ref()
            .is_none_or(|(b, o)| time(&law, over) < time(b, *o))
        {
            best = Some((law, over));
        }
        if over <= 1.0 + OVER {
            break;
        }
        grid.draw_in(used.iter().filter(|excess| excess.over > 1.0 + OVER));
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_never_binds() {
        let row = |k: i32| {
            let [a, b, c] = [1.0, 2.3, 3.1].map(|f| (f64::from(k) * f).sin());
            Row { a, b, c: 1.1 + c }
        };
        let all: Vec<Row> = (0..200).map(row).collect();
        let kept = binding(&mut all.clone());
        assert!(kept.len() < 30, "{}", kept.len());
        for k in 0..100 {
            let (bend, rate) = (f64::from(k - 50), f64::from(k % 7));
            let [one, other] = [&all, &kept].map(|rows| excess(rows, rate, bend));
            assert!((one - other).abs() < 1e-12 * (1.0 + one), "{one} {other}");
        }
    }

    #[test]
    fn limits_that_were_drawn_in_stay_so() {
        let config = Config::default();
        let row = |a: f64, b: f64| Row { a, b, c: 1.0 };
        let place = |i: usize| {
            let sharp = if i == 20 { 4.0 } else { 0.25 };
            vec![row(0.1, 0.0), row(-0.1, 0.0), row(0.0, sharp)]
        };
        let mut grid = Grid::new(vec![(0..=40).map(place).collect()]);
        let mut over = |tries| smooth(&mut grid, &config, tries).unwrap().1;
        assert!(over(1) > 1.01);
        over(8);
        assert!(over(1) <= 1.0 + OVER);
    }

    #[test]
    fn a_limit_between_two_places_slows_a_law_there_alone() {
        let config = Config::default();
        let row = |a: f64, b: f64| Row { a, b, c: 1.0 };
        let place = vec![row(0.1, 0.0), row(-0.1, 0.0), row(0.0, 0.25)];
        let mut grid = Grid::new(vec![vec![place; 41]]);
        let (before, _) = smooth(&mut grid, &config, 8).unwrap();
        let sharp = vec![row(0.0, 1.0)];
        let at = |law: &TimeLaw| law.at(law.time_s(0.51))[1];
        assert!(at(&before) > 1.5);
        grid.draw_in(
            [Excess {
                s: 0.51,
                span: [0.5, 0.52],
                over: 1.0,
                rows: sharp,
            }]
            .iter(),
        );
        let (law, over) = smooth(&mut grid, &config, 8).unwrap();
        assert!(at(&law) * over.recip() < 1.01, "{}", at(&law));
        // All of it slowed down by as much would take 1.9 times as long.
        assert!(law.duration_s() * over < 1.3 * before.duration_s());
    }
}
