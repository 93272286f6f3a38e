//! Real robots load, with the masses and freedoms that they are known to have.
//!
//! They are not part of this repository: JVRC-1 and WidowX Mark IV are looked for in the shared
//! folder, the rest in example-robot-data 6.0.0; what is not there is skipped, loudly.

use std::path::{Path, PathBuf};

use robot_model::{Config, RobotFiles, load};

use crate::support;

#[test]
fn jvrc1_loads() {
    let Some(dir) = support::shared("robots/jvrc1") else {
        return;
    };
    let robot = load(&RobotFiles::new(dir.join("jvrc1.urdf"))).unwrap();
    assert_eq!((robot.nj(), robot.nv()), (34, 40));
    assert!((robot.mass_kg - 62.4).abs() < 0.05, "{}", robot.mass_kg);
    assert!(
        robot
            .notes
            .iter()
            .any(|n| n.contains("mimic") && n.contains("L_UINDEX"))
    );
    assert_eq!(robot.collision.shapes().len(), 35);
    // The untouched file asks for meshes that are not there.
    let complaint = load(&RobotFiles::new(dir.join("jvrc1.orig.urdf")))
        .unwrap_err()
        .to_string();
    assert!(
        complaint.contains("link \"") && complaint.contains(".dae"),
        "{complaint}"
    );
}

#[test]
fn wxmark4_loads() {
    let Some(dir) = support::shared("robots/wxmark4") else {
        return;
    };
    let robot = load(&RobotFiles::new(dir.join("wxmark4.urdf"))).unwrap();
    assert_eq!(robot.nj(), 18);
    assert!((robot.mass_kg - 3.66).abs() < 0.005, "{}", robot.mass_kg);
    assert!(
        robot.frame("wxmark4/base_link").is_ok(),
        "names keep their slashes"
    );
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

/// Of the 69 URDFs, `ur3.urdf` is an empty xacro stub, and romeo's two have massless grippers
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
    let refused: Vec<String> = urdfs
        .iter()
        .filter_map(|urdf| load(&RobotFiles::new(urdf)).err())
        .map(|error| error.to_string())
        .collect();
    let wanted = [
        ("romeo.urdf", "link \"LFinger11Link\": it is massless"),
        (
            "romeo_laas_small.urdf",
            "link \"base_link\": its inertia has the principal moments",
        ),
        ("ur3.urdf", "there is no <link>"),
    ];
    assert_eq!(refused.len(), wanted.len(), "{refused:#?}");
    for (complaint, (file, cause)) in refused.iter().zip(wanted) {
        assert!(
            complaint.contains(file) && complaint.contains(cause),
            "{complaint}"
        );
    }
    let config = Config {
        lenient: true,
        ..Config::default()
    };
    for urdf in urdfs
        .iter()
        .filter(|u| u.to_string_lossy().contains("romeo"))
    {
        let config = config.clone();
        let robot = load(&RobotFiles {
            config,
            ..RobotFiles::new(urdf)
        })
        .unwrap();
        assert!(robot.nj() >= 31);
    }
}

fn collect(folder: &Path, urdfs: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder)
        .unwrap()
        .flatten()
        .map(|entry| entry.path())
    {
        if path.is_dir() {
            collect(&path, urdfs);
        } else if path.extension().is_some_and(|e| e == "urdf") {
            urdfs.push(path);
        }
    }
}
