//! The plans of the humanoid's scenes pass the verifier as the program writes them, and fail it
//! broken in every way of the table.

#[path = "support/mutations.rs"]
mod mutations;

use std::process::Command;

use planner::plan::Plan;
use scandent::verify::{Options, verify};

#[test]
fn the_plan_of_each_scene_passes_and_every_broken_one_fails() {
    let robot = scenes::builtin_robot("hrp2")
        .expect("the robot ships")
        .load(&robot_model::Config::default())
        .expect("the robot loads");
    for scene in ["irregular-stairs", "slope-and-hand"] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let output = Command::new(env!("CARGO_BIN_EXE_scandent"))
            .args(["plan", scene, "-o"])
            .arg(folder.path())
            .output()
            .expect("the program starts");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{scene}: {said}");
        let text = std::fs::read_to_string(folder.path().join("plan.json")).expect("a plan");
        let plan: Plan = serde_json::from_str(&text).expect("a plan");

        let certificate = verify(&plan, &robot, &Options::default());
        assert!(certificate.pass, "{scene}\n{}", certificate.table());
        for mutation in mutations::mutations() {
            let mut broken = plan.clone();
            (mutation.apply)(&mut broken);
            let failed = verify(&broken, &robot, &Options::default()).failed_checks();
            assert_eq!(mutation.objection(&failed), None, "{scene}");
        }
    }
}
