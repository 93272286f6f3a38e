//! Ramps with a person before or on them, narrow ones, and what is no ramp; the whole table is
//! `examples/judge_slopes.rs`.

use scenes::simulator::lidar::RangeNoise;

#[allow(dead_code)]
#[path = "../../examples/judge_slopes.rs"]
mod judge;

use judge::{Person, ramps, stairs};

#[test]
fn a_person_before_or_on_a_ramp_does_not_hide_it() {
    let noise = RangeNoise::default();
    for (width_m, person) in [
        (1.2, Person::OnIt),
        (1.2, Person::Before),
        (0.4, Person::Nowhere),
    ] {
        let row = ramps(40..44, 12.0, width_m, &noise, person);
        assert_eq!((row.angles.len(), row.wrong), (row.sweeps, 0));
        for [error, sigma] in row.angles {
            assert!(error.abs() < 4.0 * sigma, "{error}° ± {sigma}°");
        }
        for [error, sigma] in row.hidden {
            assert!(error.abs() < 3.0 * sigma, "hidden: {error} m ± {sigma} m");
        }
        for [error, _] in row.ends {
            assert!(error.abs() < 0.05, "seen: {error} m");
        }
    }
}

#[test]
fn stairs_are_no_slope() {
    for seed in 40..46 {
        let (riser, tread, scan) = stairs(seed, &RangeNoise::default());
        let slopes = scan.map_or(0, |scan| scan.slopes.len());
        assert_eq!(slopes, 0, "{riser} × {tread} m, seed {seed}");
    }
}
