//! Time along a path: from rest to rest with continuous acceleration.
//!
//!   σ(s) = 10 s³ − 15 s⁴ + 6 s⁵,   max σ' = 1.875,   max |σ''| = 10/√3 = 5.77

/// The part of the path after the part `s` of the time.
pub fn quintic(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_rests_at_both_ends_and_its_peaks_are_the_stated_ones() {
        let h = 1e-4;
        let rate = |s: f64| (quintic(s + h) - quintic(s - h)) / (2.0 * h);
        let acceleration = |s: f64| (quintic(s + h) - 2.0 * quintic(s) + quintic(s - h)) / (h * h);
        assert_eq!((quintic(0.0), quintic(1.0)), (0.0, 1.0));
        assert!(rate(h).abs() < 1e-5 && rate(1.0 - h).abs() < 1e-5);
        assert!(acceleration(h).abs() < 0.02 && acceleration(1.0 - h).abs() < 0.02);
        let over = |f: &dyn Fn(f64) -> f64| {
            let values = (1..1000).map(|i| f(f64::from(i) / 1000.0).abs());
            values.fold(0.0, f64::max)
        };
        assert!((over(&rate) - 1.875).abs() < 1e-4);
        assert!((over(&acceleration) - 10.0 / 3.0_f64.sqrt()).abs() < 1e-3);
    }
}
