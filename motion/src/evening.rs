//! Knots of a path that bend less sharply.

/// Evens knots out where they bend at once, as where a limit begins to bind: a spline through them bends 1.7 times as
/// sharply there as they do, and half as sharply as that once they are evened out.
///
///   δ_i − (δ_{i−2} − 4 δ_{i−1} + 6 δ_i − 4 δ_{i+1} + δ_{i+2})/16
///
/// Cubic curves stay as they are, and so do two knots at either end.
///
/// Shapes: deltas, n coordinates a knot.
pub(crate) fn even_out(deltas: &mut [f64], n: usize) {
    let before = deltas.to_vec();
    let inside = before.len().saturating_sub(4 * n);
    let beside = before.iter().zip(&before[n..]).zip(&before[2 * n..]);
    let beside = beside.zip(&before[3 * n..]).zip(&before[4 * n..]);
    let inner = deltas[2 * n..].iter_mut().take(inside);
    for (delta, ((((a, b), c), d), e)) in inner.zip(beside) {
        *delta -= (a - 4.0 * b + 6.0 * c - 4.0 * d + e) / 16.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::{Ends, Order, Spline};

    const PIECES: usize = 40;

    /// Knots that bend at once in the middle, as where a clearance begins to bind, beside a cubic curve.
    #[test]
    fn knots_that_bend_at_once_bend_the_spline_half_as_sharply() {
        let along = |i: usize| i as f64 / PIECES as f64 - 0.5;
        let knots = (0..=PIECES).map(along);
        let plain: Vec<f64> = knots.flat_map(|t| [t.max(0.0), t * t * t]).collect();
        let sharpest = |knots: &[f64]| {
            let spline = Spline::new(2, 1.0 / PIECES as f64, knots.to_vec(), Ends::Free);
            let mut bend = [0.0; 2];
            let bends = (0..=PIECES).map(|i| {
                spline.evaluate(i as f64 / PIECES as f64, Order::Second, &mut bend);
                bend[0]
            });
            bends.fold(0.0, f64::max)
        };
        let mut even = plain.clone();
        even_out(&mut even, 2);
        assert!(sharpest(&even) < 0.5 * sharpest(&plain));
        let both = || even.chunks_exact(2).zip(plain.chunks_exact(2));
        for (even, plain) in both() {
            assert!((even[1] - plain[1]).abs() < 1e-12 && (even[0] - plain[0]).abs() < 0.004);
        }
    }
}
