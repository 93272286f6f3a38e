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
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use anyhow::{Context, Result, bail};
use nalgebra::{Isometry3, Point2, UnitQuaternion, Vector3};
use plan::{Contact, Plan};
use robot_model::{ContactPatch, Robot};
use serde_saphyr::FlowSeq;

use super::limbs::Limbs;
use super::{Config, frames};
use document::*;
use steps::steps;

mod cubic_swing;
mod document;
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
    // Its tasks turn the limbs' frames, and its surface contacts need an area.
    if let Some(ball) = robot.patches.iter().find(|p| p.point_radius_m().is_some()) {
        bail!(
            "mcc-yaml has no contact of a ball, and {} touches with one: write json or csv",
            ball.name
        );
    }
    let limbs = Limbs::new(robot, config)?;
    let start = plan.stances.first().context("the plan has no stances")?;
    let initial_contacts = start.contacts.iter().map(|contact| {
        Ok(InitialContact {
            limb: limbs.of(&contact.patch)?.to_owned(),
            constraint: constraint(plan, contact),
        })
    });
    let initial_contacts = initial_contacts.collect::<Result<_>>()?;
    let name = config.robot.as_ref().unwrap_or(&plan.robot.name).clone();
    let base = robot.bodies.first().map(|b| b.name.clone());
    let (configs, strays_m) = steps(plan, motion, robot, &limbs, config)?;
    let document = Document {
        states: States {
            initial: State {
                base: "MCC::Initial",
                configs: Initial {
                    auto_start_time: AUTO_START_S,
                    initial_contacts,
                },
            },
            motion: State {
                base: "MCC::ConfigMotion",
                configs,
            },
            main: Parallel {
                base: "Parallel",
                states: FlowSeq(["MCC::ConfigMotion_"]),
            },
        },
        limb_tasks: limb_tasks(robot, &limbs)?,
        limb_managers: LimbManagers {
            limb_manager: limb_managers(plan, robot, &limbs)?,
        },
        contacts: Contacts {
            surface: vertices(robot, &limbs)?,
        },
        robots: BTreeMap::from([(
            name,
            RobotConfig {
                frames: contact_frames(robot, &limbs)?,
                base_orientation: BaseOrientation {
                    frame: base.unwrap_or_default(),
                },
                centroidal: Centroidal {
                    nominal_centroidal_pose_base_frame: "World",
                    nominal_centroidal_pose: centroidal_pose(plan, 0)?,
                },
            },
        )]),
    };
    let header = format!(
        "# {} by {} {}: {} stances of {}.\n\
         # For isri-aist/MultiContactController: merge it over the controller's own configuration.\n\
         # Poses: m, and roll, pitch, yaw in rad. Contact frames have z out of the environment.\n\
         # Friction is what the plan uses of it ({} of the coefficient).\n\
         # Swings stray from the motion's by {:.1} mm at most.\n",
        plan.scene,
        plan.program.name,
        plan.program.version,
        plan.stances.len(),
        plan.robot.name,
        plan.required.friction_use,
        1e3 * strays_m,
    );
    Ok(header + &serde_saphyr::to_string(&document)?)
}

/// The force by which each limb is known to have touched down: less than the least that it comes to
/// bear in any contact that the plan makes with it.
fn limb_managers(
    plan: &Plan,
    robot: &Robot,
    limbs: &Limbs,
) -> Result<BTreeMap<String, LimbManager>> {
    let mut managers = BTreeMap::new();
    for patch in &robot.patches {
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
        let force = frames::rounded((TOUCH_DOWN_PART * least_N).max(NOISE_N));
        let manager = LimbManager {
            touch_down_force_z: force,
        };
        managers.insert(limbs.of(&patch.name)?.to_owned(), manager);
    }
    Ok(managers)
}

/// A surface contact with the friction that the plan allows itself: plan and controller then
/// share one cone.
fn constraint(plan: &Plan, contact: &Contact) -> Constraint {
    let fric_coeff = frames::rounded(contact.friction * plan.required.friction_use);
    Constraint {
        kind: "Surface",
        fric_coeff,
    }
}

/// Centre of mass and orientation of the base.
fn centroidal_pose(plan: &Plan, stance: usize) -> Result<Pose> {
    let stance = plan.stances.get(stance).context("no such stance")?;
    let turn: UnitQuaternion<f64> = frames::base(stance)?.rotation;
    let com_W = Vector3::from(stance.com_W);
    Ok(pose(&Isometry3::from_parts(com_W.into(), turn)))
}

fn limb_tasks(robot: &Robot, limbs: &Limbs) -> Result<Vec<LimbTask>> {
    let task = |patch: &ContactPatch| {
        let limb = limbs.of(&patch.name)?.to_owned();
        // Kind, period and weight of the controller's own samples.
        Ok(LimbTask {
            kind: "firstOrderImpedance",
            frame: frame_name(&limb),
            limb,
            cutoff_period: 0.01,
            weight: 1000.0,
        })
    };
    robot.patches.iter().map(task).collect()
}

fn vertices(robot: &Robot, limbs: &Limbs) -> Result<Vec<Vertices>> {
    let corner = |v: &Point2<f64>| [frames::rounded(v.x), frames::rounded(v.y), 0.0];
    let vertices = |patch: &ContactPatch| {
        Ok(Vertices {
            name: limbs.of(&patch.name)?.to_owned(),
            vertices: FlowSeq(patch.polygon.iter().map(corner).collect()),
        })
    };
    robot.patches.iter().map(vertices).collect()
}

/// The patches as frames on their links.
fn contact_frames(robot: &Robot, limbs: &Limbs) -> Result<Vec<Frame>> {
    let frame = |patch: &ContactPatch| {
        let link = robot.frame(&patch.link)?;
        Ok(Frame {
            name: frame_name(limbs.of(&patch.name)?),
            parent: patch.link.clone(),
            X_p_f: pose(&(link.X_BL.inverse() * patch.X_BC)),
        })
    };
    robot.patches.iter().map(frame).collect()
}

fn frame_name(limb: &str) -> String {
    format!("{limb}Contact")
}

fn pose(X: &Isometry3<f64>) -> Pose {
    let rotation = frames::roll_pitch_yaw(&X.rotation).map(frames::rounded);
    Pose {
        translation: triple(&X.translation.vector),
        rotation: FlowSeq(rotation),
    }
}

fn triple(v: &Vector3<f64>) -> Triple {
    FlowSeq([v.x, v.y, v.z].map(frames::rounded))
}
