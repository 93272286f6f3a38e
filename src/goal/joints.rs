//! The joints that a goal wants.

use anyhow::{Context, Result, bail};
use posture::JointGoal;
use robot_model::Robot;
use scenes::scene_file;

use crate::mistakes;

/// The joints that a goal wants, each within its limits by the margin that postures keep.
pub(super) fn joint_goal(
    asked: &scene_file::Goal,
    robot: &Robot,
    config: &posture::Config,
) -> Result<Option<JointGoal>> {
    let wanted = wanted_joints(asked, robot)?;
    let tolerance_rad = asked.joint_tolerance_rad;
    let joints = robot.joint_bodies().iter().zip(&wanted);
    let out_of_reach = joints.filter_map(|(body, wanted)| {
        let margin = body.kept_margin(config.joint_margin_rad);
        let (lower, upper) = (body.lower + margin, body.upper - margin);
        let wanted = (*wanted)?;
        let beyond = (lower - wanted).max(wanted - upper);
        let name = &body.joint;
        (beyond > tolerance_rad).then(|| {
            format!("{name} at {wanted:.3}: {beyond:.3} beyond what its limits and posture.joint_margin_rad leave, {lower:.3} to {upper:.3}")
        })
    });
    let out_of_reach: Vec<String> = out_of_reach.collect();
    if !out_of_reach.is_empty() {
        bail!(
            "the goal: no posture has {} (joint_tolerance_rad is {tolerance_rad})",
            out_of_reach.join(", ")
        );
    }
    let any = wanted.iter().any(Option::is_some);
    Ok(any.then_some(JointGoal {
        wanted,
        tolerance_rad,
    }))
}

/// The value of every joint that a goal names or its posture states.
pub(super) fn wanted_joints(asked: &scene_file::Goal, robot: &Robot) -> Result<Vec<Option<f64>>> {
    let mut wanted = vec![None; robot.nj()];
    if let Some(name) = &asked.posture {
        let joints = robot.posture(name).context("the goal")?.joints;
        let stated = joints.iter().zip(&robot.postures[name].is_stated);
        let stated = stated.map(|(value, is_stated)| is_stated.then_some(*value));
        wanted = stated.collect();
    }
    let named = asked.joints_rad.iter().map(|(name, value)| {
        let joint = robot.joint_index(name).context("the goal")?;
        Ok((joint, *value))
    });
    for (joint, value) in mistakes::all(named)? {
        wanted[joint] = Some(value);
    }
    Ok(wanted)
}
