//! Robots to test on, and where they are.

use std::path::{Path, PathBuf};

use nalgebra::{DVector, UnitQuaternion, Vector3};
use proptest::prelude::*;
use robot_model::{Configuration, Robot, RobotFiles, load};

/// A file beside the golden values.
pub fn golden(name: &str) -> PathBuf {
    let crate_ = Path::new(env!("CARGO_MANIFEST_DIR"));
    crate_.join("tests/golden").join(name)
}

/// The robot of `tests/golden/test_tree.urdf`.
pub fn test_tree() -> Robot {
    load(&RobotFiles::new(golden("test_tree.urdf"))).unwrap()
}

/// The `robots` folder of example-robot-data: `SCANDENT_ROBOT_DATA`, or under `third_party`.
pub fn robot_data() -> Option<PathBuf> {
    let own = workspace().join("third_party/example-robot-data");
    let named = std::env::var_os("SCANDENT_ROBOT_DATA").map(PathBuf::from);
    let places = [named, Some(own.join("robots")), Some(own)];
    let mut places = places.into_iter().flatten();
    let found = places.find(|dir| dir.join("talos_data").is_dir());
    if found.is_none() {
        eprintln!("SKIPPED: example-robot-data is not there (SCANDENT_ROBOT_DATA or third_party/)");
    }
    found
}

/// A folder of the shared data: `SCANDENT_SHARED`, or beside the workspace.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("SCANDENT_SHARED")
        .map_or_else(|| workspace().join("../shared"), PathBuf::from);
    let found = Some(root.join(folder)).filter(|dir| dir.is_dir());
    if found.is_none() {
        eprintln!("SKIPPED: shared/{folder} is not there (SCANDENT_SHARED)");
    }
    found
}

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// That many cases; a failure prints its input and leaves no file behind.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Any configuration of a robot, joints within their limits.
pub fn configuration(robot: &Robot) -> impl Strategy<Value = Configuration> + use<> {
    let joints = robot.joint_bodies().iter();
    let ranges: Vec<(f64, f64)> = joints.map(|b| (b.lower, b.upper)).collect();
    let parts = prop::collection::vec(0.0..1.0_f64, ranges.len());
    let axis_angle = prop::array::uniform3(-3.0..3.0_f64);
    (prop::array::uniform3(-2.0..2.0_f64), axis_angle, parts).prop_map(move |(p, turn, parts)| {
        let joints = parts.iter().zip(&ranges);
        let joints = joints.map(|(t, (low, high))| low + t * (high - low));
        Configuration {
            p_WB: Vector3::from(p),
            R_WB: UnitQuaternion::new(Vector3::from(turn)),
            joints: DVector::from_iterator(ranges.len(), joints),
        }
    })
}
