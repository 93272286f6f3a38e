//! A world of every family for every robot that ships.
//!
//! Pass criteria: all are planned and pass the verifier. Seeds are those of nobody's tuning: the test
//! draws them once and for all, and a change that loses one has to say why.

use crate::support::program::succeeds;

#[test]
fn every_family_is_crossed_by_every_robot() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for robot in ["hrp2", "quadruped", "hexapod"] {
        let line = format!("bench --count 1 --first 31 --robot builtin:{robot} -o @");
        let said = succeeds(&line, &[folder.path()]);
        assert!(
            said.contains(&format!("| **all** | {robot} | 12 | 12 |")),
            "{said}"
        );
    }
}
