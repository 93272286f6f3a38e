//! What isri-aist/MultiContactController reads: a configuration of its states.
//!
//! Conventions, found in its sources and samples and in mc_rtc's:
//! - a pose is `translation` in m and `rotation` as roll, pitch, yaw in rad of the frame in the
//!   world, R = R_z R_y R_x. (mc_rtc keeps the transpose of R, and reads matrices and quaternions
//!   as that transpose; three angles mean R itself.)
//! - a limb's pose is that of the frame its task controls, z out of the environment; contact
//!   vertices are given in it. Frames at our patches are declared, so that both are ours.
//! - an `Add` takes the limb off the place it is at, if it is at one, swings it and makes the
//!   contact at `endTime`; a `Remove` takes it off and leaves it in the air.
//! - nominal poses and postures hold from their time on; a nominal pose is the centre of mass with
//!   the orientation of the base.
//! - swing offsets are in the frame of the place that they are offsets from.

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector3};
use plan::{Contact, Plan};
use robot_model::{ContactPatch, Robot};
use serde_json::{Value, json};

use super::limbs::Limbs;
use super::{Config, frames};
use crate::template::render;
use steps::steps;

mod cubic_swing;
mod steps;

/// When the controller takes over, s after it was started; without it, it waits for a click.
const AUTO_START_S: f64 = 2.0;
/// The controller's own force of a touch down, N.
const TOUCH_DOWN_N: f64 = 50.0;
/// Part of the least load that a limb comes to bear at which it has touched down, and the least that
/// a force sensor's noise lets it be, N.
const TOUCH_DOWN_PART: f64 = 0.5;
const NOISE_N: f64 = 5.0;

/// The plan as a configuration of the controller.
pub(super) fn write(
    plan: &Plan,
    motion: Option<&plan::Motion>,
    robot: &Robot,
    config: &Config,
) -> Result<String> {
    if let Some(ball) = balls_touched(plan, robot).next() {
        bail!(
            "mcc-yaml has no contact of a ball, and {} touches with one: write json or csv",
            ball.name
        );
    }
    let limbs = Limbs::new(robot, config)?;
    let start = plan.stances.first().context("the plan has no stances")?;
    let initial = start.contacts.iter();
    let initial = initial.map(|c| Ok((limbs.of(&c.patch)?, friction(plan, c))));
    let corner = |v: &Point2<f64>| [frames::rounded(v.x), frames::rounded(v.y), 0.0];
    let patch = |patch: &ContactPatch| {
        let link = robot.frame(&patch.link)?;
        Ok(json!({
            "limb": limbs.of(&patch.name)?,
            "link": patch.link,
            "pose": pose(&(link.X_BL.inverse() * patch.X_BC)),
            "vertices": patch.polygon.iter().map(corner).collect::<Vec<_>>(),
            "touch_down_n": frames::rounded(touch_down_n(plan, patch)),
        }))
    };
    let areas = || {
        robot
            .patches
            .iter()
            .filter(|p| p.point_radius_m().is_none())
    };
    let steps = steps(plan, motion, robot, &limbs, config)?;
    let said = json!({
        "scene": plan.scene,
        "program": format!("{} {}", plan.program.name, plan.program.version),
        "stances": plan.stances.len(),
        "robot": plan.robot.name,
        "controlled": config.robot.as_ref().unwrap_or(&plan.robot.name),
        "base": robot.bodies.first().map_or("", |body| &body.name),
        "friction_use": plan.required.friction_use,
        "auto_start_s": AUTO_START_S,
        "strays_mm": 1e3 * steps.strays_m,
        "initial": initial.collect::<Result<Vec<_>>>()?,
        "start": centroidal_pose(plan, 0)?,
        "steps": steps.commands,
        "nominals": steps.nominals,
        "patches": areas().map(patch).collect::<Result<Vec<_>>>()?,
    });
    render("mcc.yaml", include_str!("mcc.yaml"), said)
}

/// The balls that a plan touches with: the controller's tasks turn the limbs' frames, and its surface contacts need an
/// area.
pub fn balls_touched<'a>(
    plan: &'a Plan,
    robot: &'a Robot,
) -> impl Iterator<Item = &'a ContactPatch> {
    let contacts = plan.stances.iter().flat_map(|s| &s.contacts);
    let patches = contacts.filter_map(|c| robot.patch(&c.patch).ok());
    patches.filter(|patch| patch.point_radius_m().is_some())
}

/// The force by which a limb is known to have touched down, N: less than the least that it comes to
/// bear in any contact that the plan makes with it.
fn touch_down_n(plan: &Plan, patch: &ContactPatch) -> f64 {
    let mut least_N = TOUCH_DOWN_N / TOUCH_DOWN_PART;
    // The most that the present contact has borne.
    let mut borne_N: Option<f64> = None;
    for stance in &plan.stances {
        let contact = stance.contacts.iter().find(|c| c.patch == patch.name);
        let Some(contact) = contact else {
            least_N = borne_N.take().unwrap_or(least_N).min(least_N);
            continue;
        };
        let normal_W = frames::isometry(&contact.X_WC).rotation * Vector3::z();
        let forces_W = contact.forces_W.iter();
        let load_N: f64 = forces_W.map(|f| Vector3::from(*f).dot(&normal_W)).sum();
        borne_N = Some(borne_N.unwrap_or(0.0).max(load_N));
    }
    least_N = borne_N.unwrap_or(least_N).min(least_N);
    (TOUCH_DOWN_PART * least_N).max(NOISE_N)
}

/// What the plan allows itself of the friction: plan and controller then share one cone.
fn friction(plan: &Plan, contact: &Contact) -> f64 {
    frames::rounded(contact.friction * plan.required.friction_use)
}

/// Centre of mass and orientation of the base.
fn centroidal_pose(plan: &Plan, stance: usize) -> Result<Value> {
    let stance = plan.stances.get(stance).context("no such stance")?;
    let turn: UnitQuaternion<f64> = frames::base(stance)?.rotation;
    let com_W = Vector3::from(stance.com_W);
    Ok(pose(&Isometry3::from_parts(com_W.into(), turn)))
}

fn pose(X: &Isometry3<f64>) -> Value {
    let rotation = frames::roll_pitch_yaw(&X.rotation).map(frames::rounded);
    json!({ "translation": triple(&X.translation.vector), "rotation": rotation })
}

fn triple(v: &Vector3<f64>) -> [f64; 3] {
    [v.x, v.y, v.z].map(frames::rounded)
}
