//! A world of every family that is feasible by construction, for every robot that ships.
//!
//! Pass criteria: all are planned and pass the verifier. Seeds are those of nobody's tuning: the test
//! draws them once and for all, and a change that loses one has to say why.

use crate::support::program::succeeds;

/// Those that are feasible by construction.
const FAMILIES: &str = "stairs-up stairs-down tilted-blocks stones gaps ribs clutter wall door bridge \
                        turn ramp bridge-turn";

#[test]
fn every_family_is_crossed_by_every_robot() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let families = FAMILIES.split_whitespace();
    let families: String = families.map(|name| format!(" --family {name}")).collect();
    for robot in ["hrp2", "quadruped", "hexapod"] {
        let line = format!("bench --count 1 --first 31 --robot builtin:{robot}{families} -o @");
        let said = succeeds(&line, &[folder.path()]);
        assert!(
            said.contains(&format!("| **all** | {robot} | 13 | 13 |")),
            "{said}"
        );
    }
}

/// A leg that lands almost flat under a low door, and a border between phases where an acceleration jumps.
#[test]
fn what_the_planner_finds_passes_the_verifier() {
    let place = tempfile::tempdir().unwrap();
    for (family, seed) in [("low-door", 9003), ("door", 9007)] {
        let line = format!(
            "bench --count 1 --first {seed} --family {family} --robot builtin:quadruped -o @"
        );
        let said = succeeds(&line, &[place.path()]);
        assert!(said.contains("| **all** | quadruped | 1 | 1 |"), "{said}");
    }
}
