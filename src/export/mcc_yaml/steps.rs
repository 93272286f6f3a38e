//! The step commands: each swing of the motion as the controller will play it.
#![allow(non_snake_case)]

use anyhow::Result;
use nalgebra::Isometry3;
use plan::{Change, Plan};
use robot_model::{Kinematics, Robot};

use super::cubic_swing::CubicSwing;
use super::document::*;
use super::{centroidal_pose, constraint, pose, triple};
use crate::export::limbs::Limbs;
use crate::export::timeline::{Move, Phase, START_S, phases};
use crate::export::{Config, frames, swing};

/// Part of a swing in which a limb leaves, and part in which it approaches, without a motion.
const APPROACH_PART: f64 = 0.3;

/// The step commands, and the centres of mass and postures that go with them; how far a swing strays
/// from that of the motion at most, m.
pub(super) fn steps(
    plan: &Plan,
    motion: Option<&plan::Motion>,
    robot: &Robot,
    limbs: &Limbs,
    config: &Config,
) -> Result<(Motion, f64)> {
    let mut steps = Vec::new();
    let mut poses: Vec<TimedPose> = Vec::new();
    let mut postures = Vec::new();
    let mut strays_m = 0.0_f64;
    for phase in phases(plan, motion, config) {
        let stance = &plan.stances[phase.stance];
        let time = frames::rounded(phase.start_s);
        // A limb that is taken away leaves the posture as it is.
        if phase.kind != Move::Release {
            poses.push(TimedPose {
                time,
                pose: centroidal_pose(plan, phase.stance)?,
            });
            let joints = stance.q.iter().skip(7).map(|q| frames::rounded(*q));
            let target = plan.robot.joint_names.iter().cloned().zip(joints).collect();
            postures.push(TimedPosture {
                time,
                target: Target(target),
            });
        }
        let (Change::Add { patch, .. } | Change::Remove { patch, .. }) = &stance.change else {
            continue;
        };
        let contact = frames::contact(plan, phase.stance, patch)?;
        let to = frames::isometry(&contact.X_WC);
        let swing_config = match phase.kind {
            Move::Shift => continue,
            Move::Step { from } => {
                let from = frames::isometry(&frames::contact(plan, from, patch)?.X_WC);
                let path = motion.map(|motion| patch_path(motion, &phase, robot, patch));
                match path.transpose()?.and_then(|path| CubicSwing::along(&path)) {
                    Some(swing) => {
                        strays_m = strays_m.max(swing.strays_m);
                        followed(&swing, &from, &to)
                    }
                    None => assumed(&swing::between(&from, &to)),
                }
            }
            Move::Make => SwingConfig {
                approach_duration_ratio: Some(APPROACH_PART),
                approach_offset: Some(triple(&swing::off_surface())),
                ..SwingConfig::default()
            },
            Move::Release => SwingConfig {
                withdraw_offset: Some(triple(&swing::off_surface())),
                ..SwingConfig::default()
            },
        };
        let makes = phase.kind != Move::Release;
        steps.push(StepCommand {
            limb: limbs.of(patch)?.to_owned(),
            kind: if makes { "Add" } else { "Remove" },
            start_time: time,
            end_time: frames::rounded(phase.end_s),
            pose: makes.then(|| pose(&to)),
            constraint: makes.then(|| constraint(plan, contact)),
            swing_config,
        });
    }
    let motion = Motion {
        base_time: "Relative",
        step_command_list: steps,
        nominal_centroidal_pose_list: poses,
        nominal_posture_list: postures,
    };
    Ok((motion, strays_m))
}

/// Where a patch is in a phase of the motion, at equal steps of time.
fn patch_path(
    motion: &plan::Motion,
    phase: &Phase,
    robot: &Robot,
    patch: &str,
) -> Result<Vec<Isometry3<f64>>> {
    let patch = robot.patch(patch)?;
    let [begin, end] = [phase.start_s, phase.end_s].map(|t| t - START_S);
    let slack = 0.5 * motion.dt_s;
    let samples = motion.samples.iter();
    let samples = samples.filter(|s| s.t_s > begin - slack && s.t_s < end + slack);
    let place = |sample: &plan::Sample| {
        let q = robot.configuration(&sample.q)?;
        Ok(Kinematics::new(robot, &q).X_WC(patch))
    };
    samples.map(place).collect()
}

/// The offsets of a swing that follows the motion's, each in the frame that it is an offset from.
fn followed(swing: &CubicSwing, from: &Isometry3<f64>, to: &Isometry3<f64>) -> SwingConfig {
    let offset = |frame: &Isometry3<f64>, place: usize| {
        let off_W = swing.places_W[place] - frame.translation.vector;
        Some(triple(&(frame.rotation.inverse() * off_W)))
    };
    let [withdraw, approach] = swing.parts;
    SwingConfig {
        withdraw_duration_ratio: Some(withdraw),
        withdraw_offset: offset(from, 1),
        approach_duration_ratio: Some(approach),
        approach_offset: offset(to, 3),
        swing_offset: offset(&from.lerp_slerp(to, 0.5), 2),
    }
}

/// The offsets of a swing where there is no motion.
fn assumed(swing: &swing::Swing) -> SwingConfig {
    let part = Some(APPROACH_PART);
    SwingConfig {
        withdraw_duration_ratio: part,
        withdraw_offset: Some(triple(&swing.withdraw)),
        approach_duration_ratio: part,
        approach_offset: Some(triple(&swing.approach)),
        swing_offset: Some(triple(&swing.middle)),
    }
}
