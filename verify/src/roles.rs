//! A patch touches faces that its roles allow, and those that it touches at the start.
//!
//! Source: the roles that a face lists, else what the plan's settings ask of faces by their shape
//! ([`surfaces::role`]).

use std::collections::BTreeMap;

use plan::{Contact, Plan};
use robot_model::{ContactPatch, Robot};
use serde::Deserialize;
use surfaces::Face;
use surfaces::role::Config;

use crate::Check;
use crate::findings::Findings;

/// Goes through the contacts of all stances; names that mean nothing are other checks' to tell.
pub(crate) fn check(plan: &Plan, robot: &Robot, findings: &mut Findings) {
    // Settings that are no settings are told by the world's check.
    let asked = Config::deserialize(&plan.config["surfaces"]["roles"]).ok();
    let is_at_start = |contact: &Contact| {
        let mut first = plan.stances.iter().take(1).flat_map(|s| &s.contacts);
        first.any(|c| c.patch == contact.patch && c.face == contact.face)
    };
    let edge_sigmas = plan.required.edge_sigmas;
    let ground = asked
        .as_ref()
        .map(|asked| asked.ground_m(&plan.faces, edge_sigmas));
    let asked = asked.as_ref().zip(ground);
    // What a face serves takes its whole region: it is asked once a patch and face.
    let mut asked_of = BTreeMap::new();
    for (index, stance) in plan.stances.iter().enumerate() {
        for contact in stance.contacts.iter().filter(|c| !is_at_start(c)) {
            let patch = robot.patches.iter().find(|p| p.name == contact.patch);
            let face = plan.faces.iter().find(|f| f.id == contact.face);
            let (Some(patch), Some(face)) = (patch, face) else {
                continue;
            };
            let entry = asked_of.entry((contact.patch.as_str(), contact.face.as_str()));
            let may = entry.or_insert_with(|| may_touch(patch, face, asked, edge_sigmas));
            if !*may {
                let note = format!("{} is not for {}", contact.face, patch.roles.join(", "));
                findings.flaw(Some(index), Check::Role, contact.patch.as_str(), note);
            }
        }
    }
    findings.holds_unless_flawed(None, Check::Role);
}

fn may_touch(
    patch: &ContactPatch,
    face: &Face,
    asked: Option<(&Config, [f64; 2])>,
    edge_sigmas: f64,
) -> bool {
    patch.roles.iter().any(|role| match (&face.roles, asked) {
        (Some(listed), _) => listed.contains(role),
        // A role without a filter asks for nothing.
        (None, Some((asked, ground_m))) => match asked.filter(role) {
            Ok(filter) => filter.serves(face, edge_sigmas, ground_m).is_ok(),
            Err(_) => true,
        },
        (None, None) => true,
    })
}
