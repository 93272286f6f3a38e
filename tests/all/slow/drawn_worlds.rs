//! A world of every family for every robot that ships.
//!
//! Pass criteria: all are planned and pass the verifier. Seeds are those of nobody's tuning: the test
//! draws them once and for all, and a change that loses one has to say why.

use crate::support::program::{succeeds, text};

#[test]
fn every_family_is_crossed_by_every_robot() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for robot in ["hrp2", "quadruped", "hexapod"] {
        let name = format!("builtin:{robot}");
        let args = ["bench", "--count", "1", "--first", "31", "--robot", &name];
        let said = succeeds(&[&args[..], &["-o", text(folder.path())]].concat());
        let all = format!("| **all** | {robot} | 12 | 12 |");
        assert!(said.contains(&all), "{said}");
    }
}
