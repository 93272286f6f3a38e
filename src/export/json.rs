//! The contact sequence for any controller: what touches where, from when to when, how hard.

use anyhow::{Context, Result};
use plan::{Change, Plan, Pose};
use robot_model::Robot;
use serde::Serialize;

use super::limbs::Limbs;
use super::timeline::{Move, phases};
use super::{Config, frames};

/// The format's name and version.
const FORMAT: &str = "scandent-contacts/1";

#[derive(Serialize)]
struct Document<'a> {
    format: &'static str,
    scene: &'a str,
    robot: &'a str,
    /// Order of the joints in `q`, which begins with `[p_WB, quat_xyzw]`.
    joint_names: &'a [String],
    patches: Vec<Patch<'a>>,
    /// The motion in order.
    phases: Vec<Phase<'a>>,
    /// The postures, start first.
    stances: Vec<Stance<'a>>,
}

/// A contact patch: frame C on a link, z out of the environment; polygon in C, m.
#[derive(Serialize)]
struct Patch<'a> {
    name: &'a str,
    limb: &'a str,
    link: &'a str,
    X_LC: Pose,
    polygon_m: Vec<[f64; 2]>,
    /// Of a ball: its frame is at the centre, and so is its one vertex.
    #[serde(skip_serializing_if = "Option::is_none")]
    radius_m: Option<f64>,
}

#[derive(Serialize)]
struct Phase<'a> {
    start_s: f64,
    end_s: f64,
    /// `shift`, `step`, `make` or `release`.
    kind: &'static str,
    /// The patch that moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    patch: Option<&'a str>,
    /// The stance whose posture is reached at the end.
    stance: usize,
}

#[derive(Serialize)]
struct Stance<'a> {
    index: usize,
    change: &'a Change,
    q: &'a [f64],
    com_W: [f64; 3],
    contacts: Vec<Contact<'a>>,
}

#[derive(Serialize)]
struct Contact<'a> {
    patch: &'a str,
    face: &'a str,
    X_WC: Pose,
    loaded: bool,
    /// The coefficient of the pair, and the part of it that the plan uses at most.
    friction: f64,
    friction_use: f64,
    /// Force (N) and moment about C's origin (N·m) on the robot, in W.
    wrench_W: [f64; 6],
}

/// The plan as a contact sequence with times.
pub(super) fn write<'a>(
    plan: &'a Plan,
    motion: Option<&plan::Motion>,
    robot: &Robot,
    config: &Config,
) -> Result<String> {
    let limbs = Limbs::new(robot, config)?;
    let patches = robot.patches.iter().map(|patch| {
        let link = robot.frame(&patch.link)?;
        Ok(Patch {
            name: &patch.name,
            limb: limbs.of(&patch.name)?,
            link: &patch.link,
            X_LC: (&(link.X_BL.inverse() * patch.X_BC)).into(),
            polygon_m: patch.polygon.iter().map(|v| [v.x, v.y]).collect(),
            radius_m: patch.point_radius_m(),
        })
    });
    let phases = phases(plan, motion, config).into_iter().map(|phase| {
        let stance = plan.stances.get(phase.stance).context("no such stance")?;
        let kind = match phase.kind {
            Move::Shift => "shift",
            Move::Step { .. } => "step",
            Move::Make => "make",
            Move::Release => "release",
        };
        let patch = match &stance.change {
            Change::Add { patch, .. } | Change::Remove { patch, .. } => Some(patch.as_str()),
            _ => None,
        };
        Ok(Phase {
            start_s: phase.start_s,
            end_s: phase.end_s,
            kind,
            patch: patch.filter(|_| phase.kind != Move::Shift),
            stance: phase.stance,
        })
    });
    let contact = |contact: &'a plan::Contact| Contact {
        patch: &contact.patch,
        face: contact.face.as_str(),
        X_WC: contact.X_WC,
        loaded: contact.loaded,
        friction: contact.friction,
        friction_use: plan.required.friction_use,
        wrench_W: frames::wrench(contact),
    };
    let stances = plan.stances.iter().map(|stance| Stance {
        index: stance.index,
        change: &stance.change,
        q: &stance.q,
        com_W: stance.com_W,
        contacts: stance.contacts.iter().map(contact).collect(),
    });
    let document = Document {
        format: FORMAT,
        scene: &plan.scene,
        robot: &plan.robot.name,
        joint_names: &plan.robot.joint_names,
        patches: patches.collect::<Result<_>>()?,
        phases: phases.collect::<Result<_>>()?,
        stances: stances.collect(),
    };
    Ok(serde_json::to_string_pretty(&document)? + "\n")
}
