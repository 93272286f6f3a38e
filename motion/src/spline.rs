//! Cubic splines through values at equally spaced knots: twice continuously differentiable.
//!
//!   s(t) = a y_i + b y_{i+1} + h²/6 ((a³ − a) M_i + (b³ − b) M_{i+1}),   b = (t − t_i)/h, a = 1 − b
//!
//! with the second derivatives M from continuity of the first ones and from given end slopes.

/// A curve of `dim` coordinates.
#[derive(Clone, Debug)]
pub struct Spline {
    dim: usize,
    step: f64,
    /// Values, knot by knot.
    value: Vec<f64>,
    /// Second derivatives, knot by knot.
    second: Vec<f64>,
}

/// The derivative that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The curve.
    Value,
    /// Its first derivative.
    First,
    /// Its second derivative.
    Second,
}

/// Slopes at the two ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// At rest: the first derivative is zero.
    Rest,
    /// As the first and last five values have it, to fourth order.
    Free,
}

impl Spline {
    /// The spline through `value` (`dim` coordinates a knot, at least two knots) at knots `step`
    /// apart, the first at 0.
    pub fn new(dim: usize, step: f64, value: Vec<f64>, ends: Ends) -> Self {
        let mut spline = Self {
            second: vec![0.0; value.len()],
            dim,
            step,
            value,
        };
        spline.solve(ends);
        spline
    }

    /// Number of knots.
    pub fn knots(&self) -> usize {
        self.value.len() / self.dim.max(1)
    }

    /// Solves for the second derivatives.
    fn solve(&mut self, ends: Ends) {
        let (n, dim, h) = (self.knots(), self.dim, self.step);
        if n < 2 {
            return;
        }
        // The tridiagonal system 2 1 | 1 4 1 | … | 1 2, the same for every coordinate.
        let mut ratio = vec![0.5];
        for i in 1..n {
            let diagonal = if i + 1 < n { 4.0 } else { 2.0 };
            ratio.push(1.0 / (diagonal - ratio[i - 1]));
        }
        let (value, second) = (&self.value, &mut self.second);
        let y = |i: usize, k: usize| value[i * dim + k];
        let scale = 6.0 / (h * h);
        let last = (n - 1) * dim;
        for k in 0..dim {
            let (begin, end) = match ends {
                Ends::Rest => (0.0, 0.0),
                Ends::Free => (slope(h, n, |i| y(i, k)), -slope(h, n, |i| y(n - 1 - i, k))),
            };
            second[k] = scale * (y(1, k) - y(0, k) - h * begin) * ratio[0];
            second[last + k] = scale * (h * end - y(n - 1, k) + y(n - 2, k));
        }
        // Knot by knot, all coordinates of one beside each other.
        for i in 1..n {
            let (done, rest) = second.split_at_mut(i * dim);
            let row = done[(i - 1) * dim..].iter().zip(&mut rest[..dim]);
            if i + 1 == n {
                row.for_each(|(before, now)| *now = (*now - before) * ratio[i]);
                continue;
            }
            let three = value[(i - 1) * dim..].iter().zip(&value[i * dim..]);
            let three = three.zip(&value[(i + 1) * dim..]);
            for ((before, now), ((low, y), high)) in row.zip(three) {
                *now = (scale * (high - 2.0 * y + low) - before) * ratio[i];
            }
        }
        for i in (0..n - 1).rev() {
            let (row, after) = second.split_at_mut((i + 1) * dim);
            for (now, after) in row[i * dim..].iter_mut().zip(&after[..dim]) {
                *now -= ratio[i] * after;
            }
        }
    }

    /// Writes the curve, or a derivative of it, at `t`; beyond the ends the end's value.
    pub fn evaluate(&self, t: f64, order: Order, out: &mut [f64]) {
        let (n, dim, h) = (self.knots(), self.dim, self.step);
        if n < 2 {
            out.fill(0.0);
            if order == Order::Value {
                out.copy_from_slice(&self.value[..dim]);
            }
            return;
        }
        let at = (t / h).clamp(0.0, (n - 1) as f64);
        let i = (at as usize).min(n - 2);
        let (b, a) = (at - i as f64, 1.0 - (at - i as f64));
        let (y, yb, m, mb) = match order {
            Order::Value => {
                let bend = |x: f64| h * h / 6.0 * (x * x * x - x);
                (a, b, bend(a), bend(b))
            }
            Order::First => {
                let bend = |x: f64| h / 6.0 * (3.0 * x * x - 1.0);
                (-1.0 / h, 1.0 / h, -bend(a), bend(b))
            }
            Order::Second => (0.0, 0.0, a, b),
        };
        let (low, high) = (i * dim, (i + 1) * dim);
        let values = self.value[low..high]
            .iter()
            .zip(&self.value[high..high + dim]);
        let seconds = (self.second[low..high].iter()).zip(&self.second[high..high + dim]);
        for (out, ((low, high), (bend, bend_b))) in out.iter_mut().zip(values.zip(seconds)) {
            *out = y * low + yb * high + m * bend + mb * bend_b;
        }
    }
}

/// One-sided first derivative at the first of up to five values.
fn slope(h: f64, n: usize, y: impl Fn(usize) -> f64) -> f64 {
    match n {
        0 | 1 => 0.0,
        2 => (y(1) - y(0)) / h,
        3 | 4 => (-1.5 * y(0) + 2.0 * y(1) - 0.5 * y(2)) / h,
        _ => (-25.0 * y(0) + 48.0 * y(1) - 36.0 * y(2) + 16.0 * y(3) - 3.0 * y(4)) / (12.0 * h),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(spline: &Spline, t: f64, order: Order) -> f64 {
        let mut out = [0.0; 2];
        spline.evaluate(t, order, &mut out);
        out[1]
    }

    proptest! {
        #[test]
        fn it_is_twice_continuously_differentiable(
            values in prop::collection::vec(-1.0..1.0_f64, 6..20), free in any::<bool>(),
        ) {
            let both: Vec<f64> = values.iter().flat_map(|y| [0.0, *y]).collect();
            let ends = if free { Ends::Free } else { Ends::Rest };
            let h = 0.3;
            let spline = Spline::new(2, h, both, ends);
            for (i, y) in values.iter().enumerate() {
                let t = i as f64 * h;
                prop_assert!((at(&spline, t, Order::Value) - y).abs() < 1e-12);
                if i == 0 || i + 1 == values.len() {
                    continue;
                }
                // Values of up to 1 at knots 0.3 apart have derivatives of some tens; the third
                // one, up to 1e4, changes the second by 1e-4 between the two sides.
                for (order, tolerance) in [(Order::First, 1e-5), (Order::Second, 1e-3)] {
                    let (before, after) = (at(&spline, t - 1e-8, order), at(&spline, t + 1e-8, order));
                    prop_assert!((before - after).abs() < tolerance, "{order:?} at {t}: {before} {after}");
                }
            }
            if !free {
                for t in [0.0, h * (values.len() - 1) as f64] {
                    prop_assert!(at(&spline, t, Order::First).abs() < 1e-10);
                }
            }
        }
    }

    #[test]
    fn a_smooth_curve_is_met_to_fourth_order() {
        let error = |n: usize| {
            let h = 2.0 / n as f64;
            let values = (0..=n).flat_map(|i| [0.0, (3.0 * i as f64 * h).sin()]);
            let spline = Spline::new(2, h, values.collect(), Ends::Free);
            let off = |t: f64| (at(&spline, t, Order::Value) - (3.0 * t).sin()).abs();
            let offs = (0..=1000).map(|i| off(2.0 * f64::from(i) / 1000.0));
            offs.fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse / fine > 12.0, "{coarse} {fine}");
    }
}
