//! One contact at a time: every stance follows from the one before, and the last is the goal.

use std::collections::BTreeMap;

use nalgebra::Matrix4;
use planner::plan::{Change, Plan, Stance, StanceContact};

use super::findings::{Findings, exceeds};
use super::posture::{angle_between, column, pose};
use super::{Check, Options};

/// Contacts that hold the robot: patch → surface, and the pose in which the contact was made.
type Held<'a> = BTreeMap<&'a str, (&'a str, Option<Matrix4<f64>>)>;

/// Goes through the contact sets from the start to the goal.
pub(crate) fn check(plan: &Plan, options: &Options, findings: &mut Findings) {
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
            findings.flaw(
                at,
                Check::Sequence,
                "",
                "the goal is reached before the last stance",
            );
        }
        kept(index, stance, &held, options, findings);
        let next = follow(index, stance, &held, findings);
        held = next;
        findings.holds_unless_flawed(at, Check::Sequence);
    }
    goal(plan, &held, options, findings);
}

/// The contacts after the change, and whether the stance lists those that the change says.
fn follow<'a>(
    index: usize,
    stance: &'a Stance,
    held: &Held<'a>,
    findings: &mut Findings,
) -> Held<'a> {
    let mut next = held.clone();
    // What must be listed: patch → (surface, loaded).
    let mut expected: BTreeMap<&str, (&str, bool)> = held
        .iter()
        .map(|(patch, (surface, _))| (*patch, (*surface, true)))
        .collect();
    let mut flaw = |subject: &str, note: String| {
        findings.flaw(Some(index), Check::Sequence, subject, note);
    };
    match &stance.change {
        Change::Start if index == 0 => {
            for contact in &stance.contacts {
                let (patch, surface) = (contact.patch.as_str(), contact.surface.as_str());
                expected.insert(patch, (surface, true));
                next.insert(patch, (surface, Some(stated_pose(contact))));
            }
            if stance.contacts.is_empty() {
                flaw("", "no contacts".to_owned());
            }
        }
        Change::Start => flaw("", "a start that is not the first stance".to_owned()),
        _ if index == 0 => flaw("", "the first stance is not the start".to_owned()),
        Change::Add { patch, surface } => {
            if let Some((already, _)) = held.get(patch.as_str()) {
                flaw(patch, format!("is added, but touches {already} already"));
            }
            expected.insert(patch, (surface, false));
            let made = stance
                .contacts
                .iter()
                .find(|c| c.patch == *patch)
                .map(stated_pose);
            next.insert(patch, (surface, made));
        }
        Change::Remove { patch, surface } => {
            match held.get(patch.as_str()) {
                None => flaw(patch, "is removed, but touches nothing".to_owned()),
                Some((on, _)) if on != surface => {
                    flaw(patch, format!("is removed from {surface}, but is on {on}"));
                }
                Some(_) => {}
            }
            expected.insert(patch, (surface, false));
            next.remove(patch.as_str());
        }
        Change::Goal => {}
    }

    // Compare with what is listed.
    for contact in &stance.contacts {
        let patch = contact.patch.as_str();
        match expected.remove(patch) {
            None => flaw(patch, format!("touches {} unannounced", contact.surface)),
            Some((surface, loaded)) => {
                if contact.surface != surface {
                    flaw(
                        patch,
                        format!("is on {}, not on {surface}", contact.surface),
                    );
                }
                if contact.loaded != loaded {
                    let must = if loaded { "must" } else { "must not" };
                    flaw(patch, format!("{must} be loaded here"));
                }
            }
        }
    }
    for (patch, (surface, _)) in expected {
        flaw(patch, format!("is not listed on {surface}"));
    }
    next
}

/// Contacts that stay are where they were made.
fn kept(index: usize, stance: &Stance, held: &Held, options: &Options, findings: &mut Findings) {
    for contact in &stance.contacts {
        let Some((surface, Some(made))) = held.get(contact.patch.as_str()) else {
            continue;
        };
        if *surface != contact.surface {
            continue;
        }
        let now = stated_pose(contact);
        let moved = (column(&now, 3) - column(made, 3)).norm();
        let turned = angle_between(made, &now);
        let at = Some(index);
        findings.value(at, Check::Kept, &contact.patch, moved, options.closure_m);
        if turned > options.pose_rad {
            let note = format!("turned by {turned:.4} rad, {} allowed", options.pose_rad);
            findings.flaw(at, Check::Kept, &contact.patch, note);
        }
    }
}

fn stated_pose(contact: &StanceContact) -> Matrix4<f64> {
    pose(&contact.X_WC.p, &contact.X_WC.quat_xyzw)
}

/// The last stance has the base and the contacts where the goal wants them.
fn goal(plan: &Plan, held: &Held, options: &Options, findings: &mut Findings) {
    let Some((index, last)) = plan.stances.iter().enumerate().next_back() else {
        return;
    };
    let (at, goal) = (Some(index), &plan.goal);
    let [x, y, z, qx, qy, qz, qw, ..] = *last.q.as_slice() else {
        findings.flaw(at, Check::Goal, "base", "the posture has no base");
        return;
    };
    if let Some(wanted) = &goal.base_position_m {
        // Coordinate by coordinate, as the tolerance is meant.
        let off = wanted
            .iter()
            .zip([x, y, z])
            .filter_map(|(wanted, is)| wanted.map(|w| (w - is).abs()))
            .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
        let bound = goal.tolerance_m + options.distance_m;
        findings.value(at, Check::Goal, "base position", off, bound);
    }
    if let Some(wanted) = goal.yaw_rad {
        let base = column(&pose(&[x, y, z], &[qx, qy, qz, qw]), 0);
        let turned = base.y.atan2(base.x) - wanted;
        let off = turned.sin().atan2(turned.cos()).abs();
        if exceeds(off, options.goal_yaw_rad) {
            let note = format!("off by {off:.4} rad, {} allowed", options.goal_yaw_rad);
            findings.flaw(at, Check::Goal, "base heading", note);
        }
    }
    for contact in &goal.contacts {
        match held.get(contact.patch.as_str()) {
            Some((surface, _)) if *surface == contact.surface => {}
            Some((surface, _)) => {
                let note = format!("is on {surface}, not on {}", contact.surface);
                findings.flaw(at, Check::Goal, &contact.patch, note);
            }
            None => {
                let note = format!("does not touch {}", contact.surface);
                findings.flaw(at, Check::Goal, &contact.patch, note);
            }
        }
    }
    findings.holds_unless_flawed(at, Check::Goal);
}
