//! Real robots load, with the masses and freedoms that they are known to have.
//!
//! They are not part of this repository: JVRC-1 and WidowX Mark IV are looked for in the shared
//! folder, the rest in example-robot-data 6.0.0; what is not there is skipped, loudly.

use std::path::{Path, PathBuf};

use robot_model::{RobotFiles, load};

use crate::support;

#[test]
fn jvrc1_loads() {
    let Some(dir) = support::shared("robots/jvrc1") else {
        return;
    };
    let robot = load(&RobotFiles::new(dir.join("jvrc1.urdf"))).unwrap();
    assert_eq!((robot.nj(), robot.nv()), (34, 40));
    assert!((robot.mass_kg - 62.4).abs() < 0.05, "{}", robot.mass_kg);
    let mimics = |n: &String| n.contains("mimic") && n.contains("L_UINDEX");
    assert!(robot.notes.iter().any(mimics));
    assert_eq!(robot.collision.shapes().len(), 35);
    // The untouched file asks for meshes that are not there.
    let untouched = load(&RobotFiles::new(dir.join("jvrc1.orig.urdf")));
    let complaint = untouched.unwrap_err().to_string();
    let named = complaint.contains("link \"") && complaint.contains(".dae");
    assert!(named, "{complaint}");
}

#[test]
fn wxmark4_loads() {
    let Some(dir) = support::shared("robots/wxmark4") else {
        return;
    };
    let robot = load(&RobotFiles::new(dir.join("wxmark4.urdf"))).unwrap();
    assert_eq!(robot.nj(), 18);
    assert!((robot.mass_kg - 3.66).abs() < 0.005, "{}", robot.mass_kg);
    // Names keep their slashes.
    assert!(robot.frame("wxmark4/base_link").is_ok());
}

#[test]
fn talos_loads_with_its_srdf() {
    let Some(data) = support::robot_data() else {
        return;
    };
    let talos = data.join("talos_data");
    let files = RobotFiles {
        srdf: Some(talos.join("srdf/talos.srdf")),
        ..RobotFiles::new(talos.join("robots/talos_reduced.urdf"))
    };
    let robot = load(&files).unwrap();
    assert_eq!(robot.nj(), 32);
    assert!((robot.mass_kg - 90.27).abs() < 0.005, "{}", robot.mass_kg);
    let standing = robot.posture("half_sitting").unwrap();
    assert!((standing.p_WB.z - 1.01927).abs() < 1e-12);
    // The posture's own height puts the soles on the ground.
    let kinematics = robot_model::Kinematics::new(&robot, &standing);
    for sole in ["left_sole_link", "right_sole_link"] {
        let height = kinematics.X_WL(&robot, sole).unwrap().translation.z;
        assert!(height.abs() < 2e-3, "{sole} at {height}");
    }
    assert_eq!(robot.colliding_pairs(&standing), []);
}

/// Of the 69 URDFs, `ur3.urdf` is an empty xacro stub, and one of romeo's has an inertia of no body
/// that only a lenient reading accepts.
#[test]
fn example_robot_data_loads() {
    let Some(data) = support::robot_data() else {
        return;
    };
    let mut urdfs = Vec::new();
    collect(&data, &mut urdfs);
    urdfs.sort();
    assert_eq!(urdfs.len(), 69);
    let refused = urdfs
        .iter()
        .filter_map(|urdf| load(&RobotFiles::new(urdf)).err());
    let refused: Vec<String> = refused.map(|error| error.to_string()).collect();
    let moments = "link \"base_link\": its inertia has the principal moments";
    let wanted = [
        ("romeo_laas_small.urdf", moments),
        ("ur3.urdf", "there is no <link>"),
    ];
    assert_eq!(refused.len(), wanted.len(), "{refused:#?}");
    for (complaint, (file, cause)) in refused.iter().zip(wanted) {
        let named = complaint.contains(file) && complaint.contains(cause);
        assert!(named, "{complaint}");
    }
    urdfs.retain(|urdf| urdf.to_string_lossy().contains("romeo"));
    for urdf in urdfs {
        let mut files = RobotFiles::new(urdf);
        files.config.lenient = true;
        assert!(load(&files).unwrap().nj() >= 31);
    }
}

fn collect(folder: &Path, urdfs: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, urdfs);
        } else if path.extension().is_some_and(|e| e == "urdf") {
            urdfs.push(path);
        }
    }
}
