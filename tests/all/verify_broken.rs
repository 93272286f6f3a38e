//! A plan made by hand passes the verifier; broken in every way of the table it fails, in the
//! check that is meant to notice and in no unrelated one.

use verify::{Check, verify};

use crate::support::{biped, mutations};

#[test]
fn the_hand_made_plan_passes() {
    let certificate = verify(&biped::plan(), None, &biped::robot());
    let table = certificate.table();
    println!("{table}");
    assert!(certificate.pass, "{table}");
    // Nothing passes for want of being looked at: every check has been made, but those of a motion,
    // which this plan has not.
    let made: Vec<Check> = certificate.summary.iter().map(|s| s.check).collect();
    let all = Check::ALL.iter().copied();
    let wanted: Vec<Check> = all.filter(|c| !c.name().starts_with("motion_")).collect();
    assert_eq!(made, wanted, "{table}");
}

#[test]
fn every_broken_plan_fails_where_it_is_broken() {
    mutations::assert_noticed(&biped::plan(), &biped::robot());
}

#[test]
fn a_failure_names_stance_contact_check_and_amount() {
    let (mut plan, robot) = (biped::plan(), biped::robot());
    plan.faces[1].X_WF.translation.vector.z -= 0.005;
    let certificate = verify(&plan, None, &robot);
    let first = certificate.failures().next().unwrap().sentence();
    assert_eq!(
        first,
        "stance 2, left_foot: closure 0.005000 m > 0.001000 m (by 0.004000 m)"
    );
}

/// The biped's joints at the end are what the goal wants, or the verifier says which is not.
#[test]
fn joints_of_the_goal_are_checked_at_the_last_stance() {
    let (mut plan, robot) = (biped::plan(), biped::robot());
    let joints = plan.robot.joint_names.clone();
    let last = plan.stances.last().unwrap().q[7..].to_vec();
    let mut want = |joint: &str, value: f64, tolerance_rad: f64| {
        plan.goal.joints = Some(plan::GoalJoints {
            wanted: [(joint.to_owned(), value)].into(),
            tolerance_rad,
        });
        let certificate = verify(&plan, None, &robot);
        certificate.failures().next().map(|row| row.sentence())
    };
    for (joint, value) in joints.iter().zip(&last) {
        assert_eq!(want(joint, value + 0.04, 0.05), None);
        let said = want(joint, value - 0.06, 0.05).unwrap();
        assert!(
            said.contains(joint.as_str()) && said.contains("goal"),
            "{said}"
        );
    }
    let said = want("tail", 0.0, 0.05).unwrap();
    assert!(said.contains("the robot has no such joint"), "{said}");
    let said = want(&joints[0], last[0], 1e300).unwrap();
    assert!(said.contains("goal.joints.tolerance_rad"), "{said}");
}

/// The sole holds the ankle over the ground: 7 mm are enough there, less than the clearance from all else.
#[test]
fn an_ankle_is_as_near_to_its_ground_as_parts_of_the_robot_may_be_to_each_other() {
    let plan = biped::plan();
    let too_near = |above_m: f64| {
        let certificate = verify(&plan, None, &biped::with_ankle(biped::ANKLE - above_m));
        let mut failures = certificate.failures();
        let is_ankle = |subject: &str| subject.starts_with("left_ankle_pitch_link");
        failures.any(|row| row.check == Check::ContactDepth && is_ankle(&row.subject))
    };
    let least_m = plan.required.self_clearance_m;
    assert!(plan.required.clearance_m > 0.007 && least_m < 0.007);
    assert!(!too_near(0.007));
    assert!(too_near(least_m - 0.001));
}

/// Kept contacts are compared where they roll from: a sole that claims to roll could slide unseen.
#[test]
fn a_sole_does_not_roll() {
    let (mut plan, robot) = (biped::plan(), biped::robot());
    for contact in plan.stances.iter_mut().flat_map(|s| &mut s.contacts) {
        contact.rolls_from = Some(contact.X_WC);
    }
    let certificate = verify(&plan, None, &robot);
    assert_eq!(certificate.failed_checks(), [Check::Kept]);
}
