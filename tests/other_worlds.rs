//! The same program on a robot and on a scan that are not its own.
//!
//! Pass criteria: exit code 0, a plan that its own `verify` passes (the program writes none as a
//! success otherwise), on TALOS with its own URDF, SRDF and meshes, and on a real staircase scanned
//! by a Kinect v2. Both skip, loudly, where the files are not there.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Real scans and robots beside the checkout, or where SCANDENT_SHARED says.
fn shared() -> PathBuf {
    std::env::var_os("SCANDENT_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from)
}

/// The robots of example-robot-data, as `scripts/fetch-robots` leaves them.
fn robot_data() -> PathBuf {
    std::env::var_os("SCANDENT_ROBOT_DATA").map_or_else(
        || root().join("third_party/example-robot-data/robots"),
        PathBuf::from,
    )
}

fn scandent(args: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_scandent"))
        .args(args)
        .arg("-o")
        .arg(folder)
        .output()
        .expect("the program starts")
}

/// The plan is there and passes the verifier's command.
fn assert_planned(output: &Output, plan: &Path, robot: &[&str]) {
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}{complained}");
    let verified = Command::new(env!("CARGO_BIN_EXE_scandent"))
        .arg("verify")
        .arg(plan)
        .args(robot)
        .output()
        .expect("the program starts");
    assert!(
        verified.status.success(),
        "{}",
        String::from_utf8_lossy(&verified.stdout)
    );
}

#[test]
fn talos_climbs_the_irregular_stairs() {
    let data = robot_data().join("talos_data");
    let urdf = data.join("robots/talos_reduced.urdf");
    if !urdf.exists() {
        eprintln!(
            "SKIPPED: {} is not there (scripts/fetch-robots)",
            urdf.display()
        );
        return;
    }
    let srdf = data.join("srdf/talos.srdf");
    let contacts = root().join("scenes/robots/talos/contacts.toml");
    let robot = [
        "--robot",
        urdf.to_str().expect("UTF-8"),
        "--srdf",
        srdf.to_str().expect("UTF-8"),
        "--contacts",
        contacts.to_str().expect("UTF-8"),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut args = vec!["plan", "irregular-stairs", "--start", "half_sitting"];
    args.extend(robot);
    let output = scandent(&args, folder.path());
    assert_planned(&output, &folder.path().join("plan.json"), &robot);
}

#[test]
fn a_real_staircase_is_climbed_from_its_scan() {
    let scan = shared().join("scans/rgbd/k2_stairs_0000_depth.png");
    if !scan.exists() {
        eprintln!("SKIPPED: {} is not there", scan.display());
        return;
    }
    // The scene that ships names the scan beside the checkout; here it is where it was found.
    let text = std::fs::read_to_string(root().join("scenes/scenes/real-stairs.toml"))
        .expect("the scene ships");
    let named = text
        .lines()
        .find(|line| line.starts_with("depth = "))
        .expect("the scene has a scan");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("real-stairs.toml");
    let here = format!("depth = {:?}", scan.canonicalize().expect("it is there"));
    std::fs::write(&scene, text.replace(named, &here)).expect("writable");
    let output = scandent(&["run", scene.to_str().expect("UTF-8")], folder.path());
    assert_planned(&output, &folder.path().join("real-stairs/plan.json"), &[]);
}
