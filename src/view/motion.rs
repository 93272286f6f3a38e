//! The motion in the page: the poses of all bodies, a few times a second; the page goes smoothly from
//! the one to the next.

use anyhow::Result;
use base64ct::{Base64, Encoding};
use nalgebra::Vector3;
use plan::{Contact, Motion, Phase, Sample};
use robot_model::Robot;
use serde_json::{Value, json};

use super::number::{metres, newtons, seconds, unit};
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
    let mut moments = Vec::new();
    for frame in 0..frames {
        let sample = &motion.samples[(frame * every).min(last)];
        let phase = motion.phase_at(sample.t_s).map(|i| &motion.phases[i]);
        moments.push(moment(sample, phase, robot));
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
            "contacts": phase.contacts.iter().map(|c| [c.patch.as_str(), c.face.as_str()]).collect::<Vec<_>>(),
        })
    };
    let phases: Vec<Value> = motion.phases.iter().map(phase).collect();
    Ok(json!({
        "frames": frames,
        "step_s": every as f64 * motion.dt_s,
        "duration_s": seconds(motion.duration_s()),
        "phases": phases,
        "poses": Base64::encode_string(&bytes),
        "moments": moments,
    }))
}

/// What holds the robot at a sample: the centre of mass, the part of the torques that is used, and of each contact
/// of the phase the force with where it acts, N and m in W.
fn moment(sample: &Sample, phase: Option<&Phase>, robot: &Robot) -> Value {
    let joints = robot.bodies.iter().skip(1).zip(&sample.tau);
    let limited = joints.filter(|(body, _)| body.effort > 0.0 && body.effort.is_finite());
    let used = limited.map(|(body, tau)| tau.abs() / body.effort);
    let contacts = phase.map_or(&[][..], |phase| &phase.contacts);
    let forces = contacts.iter().zip(&sample.forces_W);
    json!({
        "com_W": sample.com_W.map(metres),
        "torque_use": unit(used.fold(0.0, f64::max)),
        "contacts": forces.map(|(contact, forces)| resultant(contact, forces)).collect::<Vec<_>>(),
    })
}

/// The sum of a contact's forces and the point at which they act together, weighted by their sizes.
fn resultant(contact: &Contact, forces_W: &[[f64; 3]]) -> [f64; 6] {
    let forces = || forces_W.iter().map(|&force| Vector3::from(force));
    let force: Vector3<f64> = forces().sum();
    let size = forces().map(|force| force.norm()).sum::<f64>();
    let points = contact.force_points_W.iter().map(|&p| Vector3::from(p));
    let weighted = points.zip(forces()).map(|(p, force)| p * force.norm());
    let point = weighted.sum::<Vector3<f64>>() / size.max(f64::MIN_POSITIVE);
    let ([fx, fy, fz], [px, py, pz]): ([f64; 3], [f64; 3]) = (force.into(), point.into());
    [
        newtons(fx),
        newtons(fy),
        newtons(fz),
        metres(px),
        metres(py),
        metres(pz),
    ]
}
