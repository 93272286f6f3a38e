//! What a user would otherwise write by hand for a robot: contacts, SRDF, a standing posture.

pub mod standing;

use anyhow::{Result, bail};
use robot_model::Robot;
use robot_model::propose::{self, Kinds, LimbKind, Proposed, Surface};
use serde_json::{Value, json};

use crate::template::render;

/// What to do where nothing can be proposed.
const BY_HAND: &str = "write a contacts file (docs/formats.md) and give it by --contacts";

/// The texts of the files that are proposed for a robot.
pub struct Proposal {
    /// Contacts file.
    pub contacts: String,
    /// SRDF.
    pub srdf: String,
    /// What was found and what was not, for the user.
    pub notes: Vec<String>,
}

/// Proposes contacts and SRDF for a robot that was loaded without the one, the other or both.
///
/// Patches that it has already are kept: only the SRDF is then of use.
///
/// # Errors
/// A robot without two legs that end in something to stand on.
pub fn propose(
    robot: &Robot,
    rsdf: &[Surface],
    kinds: Kinds,
    config: &posture::Config,
) -> Result<Proposal> {
    let mut robot = robot.clone();
    let limbs = propose::limbs(&robot);
    let legs = limbs.iter().filter(|l| l.kind == LimbKind::Leg).count();
    if legs < 2 {
        bail!(
            "{}: no two legs were found, left and right of a base with x ahead and z up, to propose \
             contacts for: {BY_HAND}",
            robot.name
        );
    }
    let mut notes = Vec::new();
    // What always meets is not to stop a posture.
    let neutral = robot.neutral();
    for pair in propose::excepted(&robot, &neutral) {
        robot
            .collision
            .disable(|a, b| (a, b) == (&pair.link_a, &pair.link_b));
    }
    // Feet as they are with legs stretched, then as they are where the robot stands.
    let given = !robot.patches.is_empty();
    let mut backward = false;
    let mut at = standing::stretched(&robot, &limbs);
    let mut found = Vec::new();
    let mut stands = None;
    for _ in 0..2 {
        let (patches, missing) = propose::patches(&robot, &limbs, &at, rsdf, kinds);
        notes = missing;
        if !given {
            robot.set_patches(patches.iter().map(|p| p.patch.clone()).collect());
        }
        found = patches;
        backward = propose::looks_backward(&robot);
        // Some ankles are nearer to the ground than is asked for, wherever the foot stands.
        let nearer = posture::Config {
            clearance_m: 0.5 * config.clearance_m,
            ..config.clone()
        };
        let stand = standing::stand(&robot, &limbs, config);
        let stand = stand.or_else(|why| {
            let posture = standing::stand(&robot, &limbs, &nearer)?;
            notes.push(format!(
                "warning: it stands only with a smaller posture.clearance_m (--set posture.clearance_m={}): {why:#}",
                nearer.clearance_m
            ));
            anyhow::Ok(posture)
        });
        match stand {
            Ok(posture) => {
                at = posture.clone();
                stands = Some(posture);
            }
            Err(why) => {
                notes.push(format!("no standing posture was found: {why:#}"));
                break;
            }
        }
    }
    if backward {
        // Sides were told as if its x were ahead.
        for Proposed { patch, .. } in &mut found {
            patch.name = other_side(&patch.name);
        }
        notes.push(
            "its soles reach farther behind the ankles than ahead: the base's x looks backward, and where nothing else \
             is said of the start the robot stands with x aback"
                .to_owned(),
        );
    }
    let feet = robot.patches.iter().filter(|p| p.has_role("foot")).count();
    if feet < 2 {
        bail!("{}: {}: {BY_HAND}", robot.name, notes.join("; "));
    }
    let resting = stands.clone().unwrap_or(neutral);
    let pairs = propose::excepted(&robot, &resting);
    let pairs: Vec<Value> = pairs
        .iter()
        .map(|p| json!([p.link_a, p.link_b, format!("{:?}", p.reason)]))
        .collect();
    // What is held is no joint of the robot that the files make.
    let held: Vec<&str> = (found.iter().filter(|_| !given))
        .flat_map(|of| of.held.iter().map(|(joint, _)| joint.as_str()))
        .collect();
    let joints = robot.joint_names().zip(resting.joints.iter());
    let joints = joints.filter(|(name, _)| !held.contains(name));
    let srdf = json!({
        "name": robot.name,
        "joints": joints.map(|(name, value)| json!([name, value])).collect::<Vec<_>>(),
        "stands": stands.is_some(),
        "about": standing::ABOUT,
        "pairs": pairs,
    });
    Ok(Proposal {
        contacts: contacts(&robot, &found)?,
        srdf: render("robot.srdf", include_str!("propose/robot.srdf.jinja"), srdf)?,
        notes,
    })
}

/// The name of a patch with left for right and front for rear.
fn other_side(name: &str) -> String {
    let part = |part| match part {
        "left" => "right",
        "right" => "left",
        "front" => "rear",
        "rear" => "front",
        part => part,
    };
    let parts: Vec<&str> = name.split('_').map(part).collect();
    parts.join("_")
}

/// The text of a contacts file.
fn contacts(robot: &Robot, found: &[Proposed]) -> Result<String> {
    let patches = found.iter().map(|p| {
        let [x, y, z]: [f64; 3] = p.X_LC.translation.vector.into();
        let (roll, pitch, yaw) = p.X_LC.rotation.euler_angles();
        let (position_m, rpy_rad) = ([x, y, z].map(rounded), [roll, pitch, yaw].map(rounded));
        let patch = &p.patch;
        let polygon = patch.polygon.iter().map(|v| [v.x, v.y].map(rounded));
        json!({
            "name": patch.name,
            "link": patch.link,
            "why": p.why,
            "radius_m": patch.point_radius_m(),
            "position_m": position_m,
            "rpy_rad": rpy_rad,
            "polygon_m": polygon.collect::<Vec<_>>(),
            "roles": patch.roles,
            "friction": patch.friction,
        })
    });
    let held = found.iter().flat_map(|of| &of.held);
    let held = held.map(|(joint, value)| json!([joint, value]));
    let said = json!({
        "name": robot.name,
        "patches": patches.collect::<Vec<_>>(),
        "held": held.collect::<Vec<_>>(),
    });
    render(
        "contacts.toml",
        include_str!("propose/contacts.toml.jinja"),
        said,
    )
}

/// To a hundredth of a millimetre or milliradian.
fn rounded(value: f64) -> f64 {
    // Without a negative zero.
    (value * 1e5).round() / 1e5 + 0.0
}
