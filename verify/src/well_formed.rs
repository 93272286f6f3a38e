//! What must be there before anything can be computed: lengths, finite numbers, known names.

use plan::{Pose, Stance};

use crate::findings::Findings;
use crate::scene::Scene;
use crate::{Check, TOLERANCES};

const INSANE: &str = "a value is not finite or out of all proportion";

/// Whether the stance can be gone through at all: lengths, finite numbers, known names.
pub(crate) fn check(scene: &Scene, index: usize, stance: &Stance, findings: &mut Findings) -> bool {
    let at = Some(index);
    let extent = TOLERANCES.extent_m;
    let sane = |values: &[f64]| values.iter().all(|x| x.is_finite() && x.abs() <= extent);
    let mut flaw = |subject: &str, note: &str| findings.flaw(at, Check::Numbers, subject, note);
    let wanted = scene.robot.bodies.len() + 6;
    if stance.q.len() != wanted {
        flaw("q", &format!("{} values, {wanted} wanted", stance.q.len()));
    } else if !sane(&stance.q) {
        flaw("q", INSANE);
    } else if stance.q[3..7].iter().all(|x| x.abs() < 1e-3) {
        flaw("q", "the quaternion is zero");
    }
    if !sane(&stance.com_W) {
        flaw("com_W", INSANE);
    }
    for (k, contact) in stance.contacts.iter().enumerate() {
        let points = contact.vertices_W.iter().chain(&contact.force_points_W);
        // Forces have no extent, but no robot here weighs 1e7 N either.
        let forces = contact.forces_W.iter().flatten().all(|x| x.abs() <= 1e7);
        let mut poses = [contact.X_WC].into_iter().chain(contact.rolls_from);
        let is_sane = |pose: &Pose| sane(&pose.p) && sane(&pose.quat_xyzw);
        if !(poses.clone().all(|pose| is_sane(&pose))
            && points.into_iter().all(|p| sane(p))
            && forces
            && contact.friction.is_finite())
        {
            findings.flaw(at, Check::Numbers, &contact.patch, INSANE);
        } else if poses.any(|pose| pose.quat_xyzw.iter().all(|x| x.abs() < 1e-3)) {
            findings.flaw(at, Check::Numbers, &contact.patch, "the quaternion is zero");
        }
        names(scene, index, stance, k, findings);
    }
    findings.holds_unless_flawed(at, Check::Numbers);
    findings.holds_unless_flawed(at, Check::Names);
    !findings.flawed(at, Check::Numbers) && !findings.flawed(at, Check::Names)
}

/// Patch, link, face and friction of one contact, and that it is described in full.
fn names(scene: &Scene, index: usize, stance: &Stance, k: usize, findings: &mut Findings) {
    let Some(contact) = stance.contacts.get(k) else {
        return;
    };
    let mut flaws = Vec::new();
    let mut flaw = |note: String| flaws.push(note);
    match scene.robot.patches.iter().find(|p| p.name == contact.patch) {
        None => {
            let known = scene.robot.patches.iter().map(|p| p.name.as_str());
            let known = known.collect::<Vec<_>>().join(", ");
            flaw(format!("the robot has no such patch; it has {known}"));
        }
        Some(patch) => {
            if patch.link != contact.link {
                let (real, stated) = (&patch.link, &contact.link);
                flaw(format!("is on link {real}, not on {stated}"));
            }
            let faces = scene.plan.faces.iter().filter(|f| f.id == contact.face);
            let real = faces
                .filter_map(|f| f.friction)
                .fold(patch.friction, f64::min);
            if real != contact.friction {
                let (stated, name) = (contact.friction, &contact.patch);
                findings.condition(format!(
                    "if {name} has friction {stated}: the robot's files say {real}"
                ));
            }
            if patch.polygon.len() != contact.vertices_W.len() {
                let (stated, real) = (contact.vertices_W.len(), patch.polygon.len());
                flaw(format!("{stated} vertices stated, the patch has {real}"));
            }
        }
    }
    match scene.plan.faces.iter().find(|s| s.id == contact.face) {
        None => flaw(format!("there is no face {}", contact.face)),
        Some(face) => {
            if let Some(own) = face.friction.filter(|own| *own < contact.friction) {
                let (stated, id) = (contact.friction, &face.id);
                flaw(format!("friction {stated}, but {id} has {own} at most"));
            }
        }
    }
    let before = &stance.contacts[..k];
    if before.iter().any(|other| other.patch == contact.patch) {
        flaw("is listed twice".to_owned());
    }
    let (points, forces) = (contact.force_points_W.len(), contact.forces_W.len());
    if points != forces {
        flaw(format!("{forces} forces at {points} points"));
    }
    if !(contact.friction > 0.0 && contact.friction <= TOLERANCES.friction_max) {
        let (friction, most) = (contact.friction, TOLERANCES.friction_max);
        flaw(format!("friction {friction} is not in (0, {most}]"));
    }
    // One pair, one coefficient, in whichever stance.
    let mut all = scene.plan.stances.iter().flat_map(|s| &s.contacts);
    let elsewhere = all.find(|other| {
        let same = other.patch == contact.patch && other.face == contact.face;
        same && other.friction != contact.friction
    });
    if let Some(other) = elsewhere {
        flaw(format!(
            "friction {} on {}, but {} in another stance",
            contact.friction, contact.face, other.friction
        ));
    }
    for note in flaws {
        findings.flaw(Some(index), Check::Names, &contact.patch, note);
    }
}
