//! One contact at a time: every stance follows from the one before, and the last is the goal.

use std::collections::BTreeMap;

use nalgebra::Matrix4;
use plan::{Change, Contact, Plan, Stance};

use surfaces::FaceId;

use crate::findings::{Findings, exceeds};
use crate::posture::{angle_between, column, pose};
use crate::{Check, TOLERANCES};

/// Contacts that hold the robot: patch → face, and the pose in which the contact was made.
type Held<'a> = BTreeMap<&'a str, (&'a FaceId, Option<Matrix4<f64>>)>;

/// Goes through the contact sets from the start to the goal.
pub(crate) fn check(plan: &Plan, findings: &mut Findings) {
    if plan.stances.is_empty() {
        findings.flaw(None, Check::Sequence, "", "there are no stances");
        return;
    }
    let mut held = Held::new();
    for (index, stance) in plan.stances.iter().enumerate() {
        let at = Some(index);
        if stance.index != index {
            let note = format!("index {} stated", stance.index);
            findings.flaw(at, Check::Sequence, "", note);
        }
        if stance.change == Change::Goal && index + 1 != plan.stances.len() {
            let note = "the goal is reached before the last stance";
            findings.flaw(at, Check::Sequence, "", note);
        }
        kept(index, stance, &held, findings);
        held = follow(index, stance, &held, findings);
        findings.holds_unless_flawed(at, Check::Sequence);
    }
    goal(plan, &held, findings);
}

/// The contacts after the change, and whether the stance lists those that the change says.
fn follow<'a>(
    index: usize,
    stance: &'a Stance,
    held: &Held<'a>,
    findings: &mut Findings,
) -> Held<'a> {
    let mut next = held.clone();
    // What must be listed: patch → (face, loaded).
    let listed = held
        .iter()
        .map(|(patch, (face, _))| (*patch, (*face, true)));
    let mut expected: BTreeMap<&str, (&FaceId, bool)> = listed.collect();
    let mut flaw = |subject: &str, note: String| {
        findings.flaw(Some(index), Check::Sequence, subject, note);
    };
    match &stance.change {
        Change::Start if index == 0 => {
            for contact in &stance.contacts {
                let (patch, face) = (contact.patch.as_str(), &contact.face);
                expected.insert(patch, (face, true));
                next.insert(patch, (face, Some(stated_pose(contact))));
            }
            if stance.contacts.is_empty() {
                flaw("", "no contacts".to_owned());
            }
        }
        Change::Start => flaw("", "a start that is not the first stance".to_owned()),
        _ if index == 0 => flaw("", "the first stance is not the start".to_owned()),
        Change::Add { patch, face } => {
            if let Some((already, _)) = held.get(patch.as_str()) {
                flaw(patch, format!("is added, but touches {already} already"));
            }
            expected.insert(patch, (face, false));
            let made = stance.contacts.iter().find(|c| c.patch == *patch);
            next.insert(patch, (face, made.map(stated_pose)));
        }
        Change::Remove { patch, face } => {
            match held.get(patch.as_str()) {
                None => flaw(patch, "is removed, but touches nothing".to_owned()),
                Some((on, _)) if *on != face => {
                    flaw(patch, format!("is removed from {face}, but is on {on}"));
                }
                Some(_) => {}
            }
            expected.insert(patch, (face, false));
            next.remove(patch.as_str());
        }
        Change::Goal => {}
    }

    // Compare with what is listed.
    for contact in &stance.contacts {
        let patch = contact.patch.as_str();
        match expected.remove(patch) {
            None => flaw(patch, format!("touches {} unannounced", contact.face)),
            Some((face, loaded)) => {
                if contact.face != *face {
                    flaw(patch, format!("is on {}, not on {face}", contact.face));
                }
                if contact.loaded != loaded {
                    let must = if loaded { "must" } else { "must not" };
                    flaw(patch, format!("{must} be loaded here"));
                }
            }
        }
    }
    for (patch, (face, _)) in expected {
        flaw(patch, format!("is not listed on {face}"));
    }
    next
}

/// Contacts that stay are where they were made.
fn kept(index: usize, stance: &Stance, held: &Held, findings: &mut Findings) {
    for contact in &stance.contacts {
        let Some((face, Some(made))) = held.get(contact.patch.as_str()) else {
            continue;
        };
        if **face != contact.face {
            continue;
        }
        let now = stated_pose(contact);
        let moved = (column(&now, 3) - column(made, 3)).norm();
        let turned = angle_between(made, &now);
        let at = Some(index);
        findings.value(at, Check::Kept, &contact.patch, moved, TOLERANCES.closure_m);
        if turned > TOLERANCES.pose_rad {
            let note = format!("turned by {turned:.4} rad, {} allowed", TOLERANCES.pose_rad);
            findings.flaw(at, Check::Kept, &contact.patch, note);
        }
    }
}

/// Where a contact was made, as every stance that has it says.
fn stated_pose(contact: &Contact) -> Matrix4<f64> {
    let made = contact.rolls_from.unwrap_or(contact.X_WC);
    pose(&made.p, &made.quat_xyzw)
}

/// The last stance has the base and the contacts where the goal wants them.
fn goal(plan: &Plan, held: &Held, findings: &mut Findings) {
    let Some((index, last)) = plan.stances.iter().enumerate().next_back() else {
        return;
    };
    let (at, goal) = (Some(index), &plan.goal);
    let &[x, y, z, qx, qy, qz, qw, ref joints @ ..] = last.q.as_slice() else {
        findings.flaw(at, Check::Goal, "base", "the posture has no base");
        return;
    };
    if let Some(wanted) = &goal.base_position_m {
        // Over the coordinates that are wanted.
        let squares = wanted.iter().zip([x, y, z]);
        let squares = squares.filter_map(|(wanted, is)| wanted.map(|w| (w - is).powi(2)));
        let off = squares.sum::<f64>().sqrt();
        let bound = goal.tolerance_m + TOLERANCES.distance_m;
        findings.value(at, Check::Goal, "base position", off, bound);
    }
    if let Some(wanted) = goal.yaw_rad {
        let base = column(&pose(&[x, y, z], &[qx, qy, qz, qw]), 0);
        let turned = base.y.atan2(base.x) - wanted;
        let off = turned.sin().atan2(turned.cos()).abs();
        if exceeds(off, TOLERANCES.goal_yaw_rad) {
            let note = format!("off by {off:.4} rad, {} allowed", TOLERANCES.goal_yaw_rad);
            findings.flaw(at, Check::Goal, "base heading", note);
        }
    }
    if let Some(goal) = &goal.joints {
        let bound = goal.tolerance_rad + TOLERANCES.joint_rad;
        for (name, wanted) in &goal.wanted {
            let place = plan
                .robot
                .joint_names
                .iter()
                .position(|joint| joint == name);
            match place.and_then(|place| joints.get(place)) {
                Some(is) => findings.value(at, Check::Goal, name, (is - wanted).abs(), bound),
                None => findings.flaw(at, Check::Goal, name, "the robot has no such joint"),
            }
        }
    }
    for contact in &goal.contacts {
        let note = match held.get(contact.patch.as_str()) {
            Some((face, _)) if **face == contact.face => continue,
            Some((face, _)) => format!("is on {face}, not on {}", contact.face),
            None => format!("does not touch {}", contact.face),
        };
        findings.flaw(at, Check::Goal, &contact.patch, note);
    }
    findings.holds_unless_flawed(at, Check::Goal);
}
