//! A world of every family that is feasible by construction, for every robot that ships.
//!
//! Pass criteria: all are planned and pass the verifier. Seeds are those of nobody's tuning: the test
//! draws them once and for all, and a change that loses one has to say why.

use serde_json::Value;
use urdf_rs::{Geometry, Pose};

use crate::support::program::{read, root, succeeds};

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

/// A search that told places 6 cm apart as one, on a lattice of 10 cm, had no notion of strides of 5 cm: 1,141 nodes for
/// 307 stances.
#[test]
fn a_tiny_robot_walks_as_a_large_one_does() {
    let place = tempfile::tempdir().unwrap();
    let urdf = place.path().join("tiny.urdf");
    let large = urdf_rs::read_file(root("scenes/robots/hexapod/hexapod.urdf")).unwrap();
    let tiny = urdf_rs::write_to_string(&shrunk(large, 0.15)).unwrap();
    std::fs::write(&urdf, tiny).unwrap();
    let line = "bench --count 1 --first 31 --family wall --robot @ -o @";
    succeeds(line, &[&urdf, place.path()]);
    let row: Value = serde_json::from_str(&read(place.path().join("results.jsonl"))).unwrap();
    assert_eq!(row["ended"], "solved", "{row}");
    let [nodes, stances] = ["nodes", "stances"].map(|key| row[key].as_f64().unwrap());
    assert!(nodes < 1.5 * stances, "{row}");
}

/// The robot with lengths `k` times as long, of the same density and strength for its weight.
fn shrunk(mut robot: urdf_rs::Robot, k: f64) -> urdf_rs::Robot {
    let place = |pose: &mut Pose| pose.xyz.0 = pose.xyz.0.map(|x| k * x);
    let size = |geometry: &mut Geometry| match geometry {
        Geometry::Box { size } => size.0 = size.0.map(|x| k * x),
        Geometry::Sphere { radius } => *radius *= k,
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            (*radius, *length) = (k * *radius, k * *length);
        }
        Geometry::Mesh { .. } => unreachable!("the robot has no meshes"),
    };
    for link in &mut robot.links {
        let inertial = &mut link.inertial;
        place(&mut inertial.origin);
        inertial.mass.value *= k.powi(3);
        let i = &mut inertial.inertia;
        for entry in [
            &mut i.ixx, &mut i.ixy, &mut i.ixz, &mut i.iyy, &mut i.iyz, &mut i.izz,
        ] {
            *entry *= k.powi(5);
        }
        for visual in &mut link.visual {
            place(&mut visual.origin);
            size(&mut visual.geometry);
        }
        for collision in &mut link.collision {
            place(&mut collision.origin);
            size(&mut collision.geometry);
        }
    }
    for joint in &mut robot.joints {
        place(&mut joint.origin);
        joint.limit.effort *= k.powi(4);
    }
    robot
}
