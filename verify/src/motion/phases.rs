//! Phases lead from stance to stance on contacts that both have, and the samples between them are
//! the stances' postures.

use plan::{Change, Motion, Phase, PhaseKind, Stance};

use surfaces::FaceId;

use crate::findings::Findings;
use crate::posture::{angle_between, column, pose};
use crate::scene::Scene;
use crate::{Check, TOLERANCES};

/// Checks the phases; whether the samples can be gone through.
pub(super) fn check(scene: &Scene, motion: &Motion, findings: &mut Findings) -> bool {
    let stances = &scene.plan.stances;
    let mut at = 0;
    for (i, phase) in motion.phases.iter().enumerate() {
        let (from, to) = (phase.from_stance, phase.to_stance);
        // On from the last stance, or another phase of the same segment.
        let rests = phase.kind == PhaseKind::Hold && from == at && to == at;
        let follows = (from == at && to == at + 1) || (from + 1 == at && to == at) || rests;
        if !follows || to >= stances.len() {
            let note = format!("phase {i} leads from stance {from} to {to} after stance {at}");
            findings.flaw(None, Check::MotionPhases, "motion", note);
            return false;
        }
        at = to;
        contacts(scene, i, phase, findings);
    }
    if at + 1 != stances.len() {
        let note = format!("ends at stance {at} of {}", stances.len());
        findings.flaw(None, Check::MotionPhases, "motion", note);
    }
    for (k, stance) in stances.iter().enumerate().skip(1) {
        swung(motion, k, stance, findings);
    }
    findings.holds_unless_flawed(None, Check::MotionPhases);
    if findings.flawed(None, Check::MotionPhases) {
        return false;
    }
    ends(scene, motion, findings);
    true
}

/// The contacts of a phase are those of the stances at its ends, and what swings is none of them.
fn contacts(scene: &Scene, index: usize, phase: &Phase, findings: &mut Findings) {
    let stances = &scene.plan.stances;
    let mut flaw = |note: String| {
        let subject = format!("phase {index}");
        findings.flaw(None, Check::MotionPhases, subject, note);
    };
    let held = |stance: &Stance, patch: &str, face: &FaceId| {
        let mut contacts = stance.contacts.iter();
        contacts.any(|c| c.patch == patch && c.face == *face)
    };
    for (k, contact) in phase.contacts.iter().enumerate() {
        let (patch, face) = (&contact.patch, &contact.face);
        let from = &stances[phase.from_stance];
        if !held(from, patch, face) || !held(&stances[phase.to_stance], patch, face) {
            flaw(format!("{patch} on {face} is no contact of its stances"));
            continue;
        }
        let stated = from.contacts.iter().find(|c| &c.patch == patch);
        if stated.is_some_and(|c| c.friction != contact.friction) {
            let friction = contact.friction;
            flaw(format!("{patch} has friction {friction}, not as stated"));
        }
        if stated.is_some_and(|c| c.link != contact.link) || !contact.loaded {
            flaw(format!(
                "{patch} is not the loaded contact that its stances have"
            ));
        }
        if phase.contacts[..k].iter().any(|c| &c.patch == patch) {
            flaw(format!("{patch} is listed twice"));
        }
        if phase.swing.as_ref() == Some(patch) {
            flaw(format!("{patch} swings and is closed"));
        }
    }
    if phase.contacts.is_empty() {
        flaw("nothing holds the robot".to_owned());
    }
    let swings = phase.kind == PhaseKind::Swing;
    if swings != phase.swing.is_some() {
        flaw("a swing moves one patch, another phase none".to_owned());
    }
}

/// A contact that a stance makes is swung there.
fn swung(motion: &Motion, k: usize, stance: &Stance, findings: &mut Findings) {
    if let Change::Add { patch, .. } = &stance.change {
        let mut phases = motion.phases.iter();
        if !phases.any(|p| p.to_stance == k && p.swing.as_ref() == Some(patch)) {
            let note = format!("{patch} is not swung to stance {k}");
            findings.flaw(None, Check::MotionPhases, "motion", note);
        }
    }
}

/// Where the phases to a stance end, the sample is the stance's posture.
fn ends(scene: &Scene, motion: &Motion, findings: &mut Findings) {
    for (k, stance) in scene.plan.stances.iter().enumerate() {
        let last = motion.phases.iter().rev().find(|p| p.to_stance == k);
        let time = last.map_or(0.0, |phase| phase.t_end_s);
        let index = (time / motion.dt_s).round() as usize;
        let off = match motion.samples.get(index) {
            Some(sample) if sample.q.len() == stance.q.len() => apart(&sample.q, &stance.q),
            _ => f64::NAN,
        };
        let subject = format!("motion at {time:.2} s");
        let bound = TOLERANCES.motion_end;
        findings.value(Some(k), Check::MotionEnd, subject, off, bound);
    }
}

/// Largest difference of two configurations, m and rad.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let base = |q: &[f64]| pose(&[q[0], q[1], q[2]], &[q[3], q[4], q[5], q[6]]);
    let (X, Y) = (base(a), base(b));
    let moved = (column(&X, 3) - column(&Y, 3)).norm();
    let turned = angle_between(&X, &Y);
    let joints = a[7..].iter().zip(&b[7..]).map(|(x, y)| (x - y).abs());
    joints.fold(moved.max(turned), f64::max)
}
