//! The step commands: each swing of the motion as the controller will play it.
#![allow(non_snake_case)]

use anyhow::Result;
use nalgebra::Isometry3;
use plan::{Change, Plan};
use robot_model::{Kinematics, Robot};
use serde_json::{Value, json};

use super::cubic_swing::CubicSwing;
use super::{centroidal_pose, friction, pose, triple};
use crate::export::limbs::Limbs;
use crate::export::timeline::{Move, Phase, START_S, phases};
use crate::export::{Config, frames, swing};

/// Part of a swing in which a limb leaves, and part in which it approaches, without a motion.
const APPROACH_PART: f64 = 0.3;

/// What the template says of the way.
pub(super) struct Steps {
    pub commands: Vec<Value>,
    /// The centres of mass and postures that go with them.
    pub nominals: Vec<Value>,
    /// How far a swing strays from that of the motion at most, m.
    pub strays_m: f64,
}

/// The step commands and all that goes with them.
pub(super) fn steps(
    plan: &Plan,
    motion: Option<&plan::Motion>,
    robot: &Robot,
    limbs: &Limbs,
    config: &Config,
) -> Result<Steps> {
    let (mut commands, mut nominals) = (Vec::new(), Vec::new());
    let mut strays_m = 0.0_f64;
    for phase in phases(plan, motion, config) {
        let stance = &plan.stances[phase.stance];
        let time = frames::rounded(phase.start_s);
        // A limb that is taken away leaves the posture as it is.
        if phase.kind != Move::Release {
            let joints = stance.q.iter().skip(7).map(|q| frames::rounded(*q));
            let joints = plan.robot.joint_names.iter().zip(joints);
            nominals.push(json!({
                "time_s": time,
                "pose": centroidal_pose(plan, phase.stance)?,
                "joints": joints.collect::<Vec<_>>(),
            }));
        }
        let (Change::Add { patch, .. } | Change::Remove { patch, .. }) = &stance.change else {
            continue;
        };
        let contact = frames::contact(plan, phase.stance, patch)?;
        let to = frames::isometry(&contact.X_WC);
        let swing = match phase.kind {
            Move::Shift => continue,
            Move::Step { from } => {
                let from = frames::isometry(&frames::contact(plan, from, patch)?.X_WC);
                let path = motion.map(|motion| patch_path(motion, &phase, robot, patch));
                match path.transpose()?.and_then(|path| CubicSwing::along(&path)) {
                    Some(swing) => {
                        strays_m = strays_m.max(swing.strays_m);
                        followed(&swing, &from, &to)
                    }
                    None => swing_config([APPROACH_PART; 2], &swing::between(&from, &to)),
                }
            }
            Move::Make => json!({
                "approachDurationRatio": APPROACH_PART,
                "approachOffset": triple(&swing::off_surface()),
            }),
            Move::Release => json!({ "withdrawOffset": triple(&swing::off_surface()) }),
        };
        commands.push(json!({
            "limb": limbs.of(patch)?,
            "makes": phase.kind != Move::Release,
            "start_s": time,
            "end_s": frames::rounded(phase.end_s),
            "pose": pose(&to),
            "friction": friction(plan, contact),
            "swing": swing,
        }));
    }
    Ok(Steps {
        commands,
        nominals,
        strays_m,
    })
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

/// The swing that follows the motion's; each offset in the frame that it is an offset from.
fn followed(swing: &CubicSwing, from: &Isometry3<f64>, to: &Isometry3<f64>) -> Value {
    let offset = |frame: &Isometry3<f64>, place: usize| {
        let off_W = swing.places_W[place] - frame.translation.vector;
        frame.rotation.inverse() * off_W
    };
    let offsets = swing::Swing {
        withdraw: offset(from, 1),
        middle: offset(&from.lerp_slerp(to, 0.5), 2),
        approach: offset(to, 3),
    };
    swing_config(swing.parts, &offsets)
}

fn swing_config([withdraw, approach]: [f64; 2], offsets: &swing::Swing) -> Value {
    json!({
        "withdrawDurationRatio": withdraw,
        "withdrawOffset": triple(&offsets.withdraw),
        "approachDurationRatio": approach,
        "approachOffset": triple(&offsets.approach),
        "swingOffset": triple(&offsets.middle),
    })
}
