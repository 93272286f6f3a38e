//! The motion in the page: the poses of all bodies, a few times a second; the page goes smoothly from
//! the one to the next.

use anyhow::Result;
use plan::{Motion, Phase};
use robot_model::Robot;
use serde_json::{Value, json};

use super::base64::base64;
use super::number::seconds;
use super::robot::poses;

/// Time between two frames, s.
const STEP_S: f64 = 0.1;

/// Phases, and poses as base64 of little-endian 32-bit floats, seven numbers a body and frame; null
/// without a motion. The last frame is the last sample.
///
/// # Errors
/// When the motion is another robot's or contradicts itself.
pub(super) fn record(motion: Option<&Motion>, robot: &Robot) -> Result<Value> {
    let Some(motion) = motion else {
        return Ok(Value::Null);
    };
    motion.validate()?;
    let every = (STEP_S / motion.dt_s).round().max(1.0) as usize;
    let last = motion.samples.len() - 1;
    let frames = last.div_ceil(every) + 1;
    let mut bytes = Vec::new();
    for frame in 0..frames {
        let sample = &motion.samples[(frame * every).min(last)];
        for x in poses(robot, &sample.q)? {
            bytes.extend((x as f32).to_le_bytes());
        }
    }
    let phase = |phase: &Phase| {
        json!({
            "kind": phase.kind,
            "start_s": seconds(phase.t_start_s),
            "end_s": seconds(phase.t_end_s),
            "from": phase.from_stance,
            "to": phase.to_stance,
            "swing": phase.swing,
        })
    };
    let phases: Vec<Value> = motion.phases.iter().map(phase).collect();
    Ok(json!({
        "frames": frames,
        "step_s": every as f64 * motion.dt_s,
        "duration_s": seconds(motion.duration_s()),
        "phases": phases,
        "poses": base64(&bytes),
    }))
}
