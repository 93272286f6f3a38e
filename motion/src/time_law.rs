//! The fastest time along a path, by reachability.
//!
//!   max ∫ ṡ   s.t.   a_r(s) s̈ + b_r(s) ṡ² ≤ c_r(s)      at every grid point, ṡ = 0 at both ends
//!
//! Backwards, the largest ṡ² from which the end is reached; forwards, the largest s̈ that stays below
//! it. Between grid points s̈ is constant; a running mean over a short time then bounds the jerk.
//!
//! Source: \[pham2018\] Algorithm 1; deviation: at rest every row has room, so that the least ṡ² of a
//! controllable set is 0 and need not be followed.

/// One limit at one place of a path: a s̈ + b ṡ² ≤ c, c > 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Of s̈.
    pub a: f64,
    /// Of ṡ².
    pub b: f64,
    /// What is allowed.
    pub c: f64,
}

/// A path's parameter, from 0 on, in time: from rest to rest with continuous acceleration.
#[derive(Clone, Debug)]
pub struct TimeLaw {
    /// Time, s, ṡ and ∫ s dt at the grid points.
    knots: Vec<[f64; 4]>,
    /// Time over which the mean is taken, s.
    smooth_s: f64,
    /// Factor by which all is slower.
    slower: f64,
}

/// How often the time of a place is halved, to a hundredth of what the law takes from one grid point to the
/// next, and how often it is then improved where the path moves faster than this, 1/s.
const HALVINGS: usize = 7;
const NEWTONS: usize = 3;
const SLOW: f64 = 1e-3;
/// Part of ṡ² that is kept from one grid point to the next before the end: what stands still stays there.
const MOVING: f64 = 0.01;
/// Smallest part of a limit that counts as a coefficient.
const SMALL: f64 = 1e-9;

impl TimeLaw {
    /// The fastest time along a path with these limits at the places `at`, from 0 on; nothing where the
    /// path cannot be gone along.
    pub fn fastest(at: &[f64], limits: &[Vec<Row>], smooth_s: f64) -> Option<Self> {
        Self::within(at, limits, &vec![1.0; at.len()], smooth_s)
    }

    /// The same with limits that are drawn in by these factors.
    pub(crate) fn within(
        at: &[f64],
        limits: &[Vec<Row>],
        drawn: &[f64],
        smooth_s: f64,
    ) -> Option<Self> {
        let n = limits.len().checked_sub(1).filter(|n| *n > 0)?;
        let mut most = vec![0.0; n + 1];
        // Limits that are drawn in by k keep s̈ and ṡ² to a k-th of what those as they are do.
        for i in (0..n).rev() {
            let k = drawn[i];
            most[i] = controllable(&limits[i], at[i + 1] - at[i], k * most[i + 1]) / k;
        }
        let mut x = 0.0_f64;
        let mut knots = Vec::with_capacity(n + 1);
        knots.push([0.0; 4]);
        for (i, (rows, k)) in limits.iter().zip(drawn).enumerate().take(n) {
            let ds = at[i + 1] - at[i];
            let up = rows.iter().filter(|r| r.a > SMALL * r.c);
            let reach = up
                .map(|r| (r.c / k - r.b * x) / r.a)
                .fold(f64::INFINITY, f64::min);
            let slow = MOVING * x.min(most[i + 1]);
            let next = (x + 2.0 * ds * reach).clamp(slow, most[i + 1]);
            let [t, s, rate, area] = knots[i];
            let dt = 2.0 * ds / (rate + next.sqrt());
            if !dt.is_finite() {
                return None;
            }
            let bend = (next - x) / (2.0 * ds);
            let area = area + dt * (s + dt * (rate / 2.0 + dt * bend / 6.0));
            knots.push([t + dt, at[i + 1], next.sqrt(), area]);
            x = next;
        }
        Some(Self {
            knots,
            smooth_s,
            slower: 1.0,
        })
    }

    /// The same law, `factor` times slower.
    pub fn slower(&self, factor: f64) -> Self {
        Self {
            slower: self.slower * factor,
            ..self.clone()
        }
    }

    /// How long it takes, s.
    pub fn duration_s(&self) -> f64 {
        (self.end_s() + self.smooth_s) * self.slower
    }

    /// s, ṡ and s̈ at a time.
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        self.with_span(t_s).0
    }

    /// s, ṡ and s̈ at a time, and the part of the path over which the mean is taken there: s from … to ….
    pub fn with_span(&self, t_s: f64) -> ([f64; 3], [f64; 2]) {
        let t = t_s / self.slower;
        let (now, before) = (self.sharp(t), self.sharp(t - self.smooth_s));
        let mean = |k: usize| (now[k] - before[k]) / self.smooth_s;
        let k = 1.0 / self.slower;
        ([mean(2), mean(0) * k, mean(1) * k * k], [before[0], now[0]])
    }

    /// When the path is at `s`, s.
    pub fn time_s(&self, s: f64) -> f64 {
        // The mean is there after the law is, by no more than the time over which it is taken.
        let after = self.knots.partition_point(|knot| knot[1] < s);
        let at = |k: usize| self.knots[k.min(self.knots.len() - 1)][0];
        let mut low = at(after.saturating_sub(1)) * self.slower;
        let mut high = (at(after) + self.smooth_s) * self.slower;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle)[0] < s {
                low = middle;
            } else {
                high = middle;
            }
        }
        // From there on where the path moves, to rounding.
        for _ in 0..NEWTONS {
            let [at, rate, _] = self.at(low);
            low += if rate > SLOW { (s - at) / rate } else { 0.0 };
        }
        low
    }

    /// When the law would end without the mean, s.
    fn end_s(&self) -> f64 {
        self.knots[self.knots.len() - 1][0]
    }

    /// s, ṡ and ∫ s dt at a time before the mean is taken.
    fn sharp(&self, t: f64) -> [f64; 3] {
        if t <= 0.0 {
            return [0.0; 3];
        }
        let after = self.knots.partition_point(|knot| knot[0] <= t);
        let [begin, s, rate, area] = self.knots[after - 1];
        let dt = t - begin;
        let Some(next) = self.knots.get(after) else {
            return [s, 0.0, area + dt * s];
        };
        let bend = (next[2] - rate) / (next[0] - begin);
        [
            s + dt * (rate + dt * bend / 2.0),
            rate + dt * bend,
            area + dt * (s + dt * (rate / 2.0 + dt * bend / 6.0)),
        ]
    }
}

/// The largest x = ṡ² for which some s̈ keeps to the rows and 0 ≤ x + 2 Δs s̈ ≤ `next`.
///
/// For a given x the rows bound s̈ from both sides; the gap between the bounds is concave in x, and
/// Newton's method from above ends on it after a few of its pieces.
fn controllable(rows: &[Row], ds: f64, next: f64) -> f64 {
    let ends = [
        Row {
            a: 2.0 * ds,
            b: 1.0,
            c: next,
        },
        Row {
            a: -2.0 * ds,
            b: -1.0,
            c: 0.0,
        },
    ];
    let rows = || rows.iter().chain(&ends);
    let flat = |r: &&Row| r.a.abs() <= SMALL * r.c.abs() && r.b > 0.0;
    let still = rows().filter(flat).map(|r| r.c / r.b);
    let mut x = still.fold(X_MAX, f64::min);
    for _ in 0..PIECES_MAX {
        // The tightest bounds at x, as lines d + e x.
        let (mut most, mut least) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut high, mut low) = ((most, 0.0), (least, 0.0));
        for r in rows() {
            if r.a.abs() <= SMALL * r.c.abs() && r.c != 0.0 {
                continue;
            }
            let value = (r.c - r.b * x) / r.a;
            let line = || (r.c / r.a, -r.b / r.a);
            if r.a > 0.0 && value < most {
                (most, high) = (value, line());
            } else if r.a < 0.0 && value > least {
                (least, low) = (value, line());
            }
        }
        let gap = most - least;
        let slope = high.1 - low.1;
        if gap >= -1e-12 * (1.0 + high.0.abs()) || slope >= 0.0 {
            break;
        }
        x = ((low.0 - high.0) / slope).clamp(0.0, x);
    }
    x
}

/// Largest ṡ², 1/s²: where the path stands still nothing else bounds it. A path takes a tenth of a second.
const X_MAX: f64 = 100.0;
/// Largest number of pieces of the bounds that are gone through; usual are three.
const PIECES_MAX: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line of length 1 with bounds on speed and acceleration.
    fn line(speed: f64, acceleration: f64, n: usize) -> Vec<Vec<Row>> {
        let rows = vec![
            Row {
                a: 1.0,
                b: 0.0,
                c: acceleration,
            },
            Row {
                a: -1.0,
                b: 0.0,
                c: acceleration,
            },
            Row {
                a: 0.0,
                b: 1.0,
                c: speed * speed,
            },
        ];
        vec![rows; n + 1]
    }

    /// Equal steps from 0 to 1.
    fn at(n: usize) -> Vec<f64> {
        (0..=n).map(|i| i as f64 / n as f64).collect()
    }

    #[test]
    fn a_straight_line_takes_the_time_of_the_bang_bang_law_and_of_the_trapezoid() {
        for (speed, acceleration) in [(9.0, 2.0), (0.5, 2.0)] {
            let rows = line(speed, acceleration, 400);
            let law = TimeLaw::fastest(&at(400), &rows, 0.05).unwrap();
            let peak = f64::min(speed, f64::sqrt(acceleration));
            let exact = 1.0 / peak + peak / acceleration;
            // The grid meets the corner of the law to within one of its steps.
            let took = law.duration_s() - 0.05;
            assert!((took / exact - 1.0).abs() < 3e-3, "{took} for {exact}");
        }
    }

    #[test]
    fn it_keeps_to_its_limits_rests_at_the_ends_and_its_jerk_is_bounded() {
        let law = TimeLaw::fastest(&at(50), &line(0.8, 2.0, 50), 0.1)
            .unwrap()
            .slower(1.5);
        let h = law.duration_s() / 2000.0;
        let states: Vec<_> = (0..=2000).map(|i| law.at(i as f64 * h)).collect();
        assert!(states[0].iter().all(|x| x.abs() < 1e-12));
        let [s, rate, bend] = states[2000];
        assert!((s - 1.0).abs() < 1e-12 && rate.abs() < 1e-9 && bend.abs() < 1e-9);
        for pair in states.windows(2) {
            let [[s, rate, bend], next] = [pair[0], pair[1]];
            assert!(rate <= 0.8 / 1.5 + 1e-9 && bend.abs() <= 2.0 / 2.25 + 1e-9);
            assert!((next[0] - s - h * rate).abs() < h * h);
            assert!((next[1] - rate - h * (bend + next[2]) / 2.0).abs() < 0.02 * h);
            // From the one bound to the other within the time of the mean.
            assert!((next[2] - bend).abs() <= 2.0 * 2.0 / 2.25 / (0.1 * 1.5) * h + 1e-9);
        }
    }

    #[test]
    fn a_law_that_comes_to_rest_before_its_end_goes_on() {
        let mut rows = line(1.0, 1.0, 40);
        // At one place little speed can be held, and only by slowing down all the way.
        rows[38][0] = Row {
            a: 1.0,
            b: 80.0,
            c: 0.01,
        };
        let law = TimeLaw::fastest(&at(40), &rows, 0.1).unwrap();
        assert!(law.duration_s() < 100.0, "{}", law.duration_s());
    }

    #[test]
    fn a_path_that_cannot_be_left_is_refused() {
        let mut rows = line(1.0, 1.0, 10);
        rows[0][0].c = 0.0;
        assert!(TimeLaw::fastest(&at(10), &rows, 0.1).is_none());
    }
}
