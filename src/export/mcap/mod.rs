//! Plan and motion as a recording (MCAP) that Foxglove and others play.
//!
//! | topic | schema | when |
//! |---|---|---|
//! | `/world` | `foxglove.SceneUpdate` | once: faces and bodies to avoid, in `world` |
//! | `/robot` | `foxglove.SceneUpdate` | once: the collision shapes of each body, in its frame |
//! | `/tf` | `foxglove.FrameTransforms` | 20 times a second: the bodies in `world` |
//! | `/contacts` | `foxglove.SceneUpdate` | as often: patches, their forces (1 m for 1 kN), the centre of mass |
//! | `/joint_states` | `sensor_msgs/JointState` | every sample: positions, velocities, torques |
//! | `/phase` | `scandent.Phase` | where one begins: what moves, from which stance to which |
//!
//! Messages are JSON, their times those of the motion. The plan is attached as `plan.json`.

mod drawn;
mod schema;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::{Context, Result};
use mcap::records::MessageHeader;
use mcap::{Attachment, WriteOptions, Writer};
use plan::{Motion, Plan, Sample};
use robot_model::{Configuration, Kinematics, Robot};
use serde_json::{Value, json};

use super::frames::{self, rounded};

/// Time between two pictures of the robot, s.
const STEP_S: f64 = 0.05;
/// The frame of all poses.
const WORLD: &str = "world";

/// The recording.
///
/// # Errors
/// A motion that contradicts itself or is another robot's.
pub(super) fn write(plan: &Plan, motion: &Motion, robot: &Robot) -> Result<Vec<u8>> {
    frames::check_motion(motion, robot)?;
    let mut log = Log::new()?;
    let scene = schema::scene_update();
    let world = log.channel("/world", "foxglove.SceneUpdate", &scene)?;
    let shapes = log.channel("/robot", "foxglove.SceneUpdate", &scene)?;
    let contacts = log.channel("/contacts", "foxglove.SceneUpdate", &scene)?;
    let tf = log.channel(
        "/tf",
        "foxglove.FrameTransforms",
        &schema::frame_transforms(),
    )?;
    let states = schema::joint_state();
    let joints = log.channel("/joint_states", "sensor_msgs/JointState", &states)?;
    let phases = log.channel("/phase", "scandent.Phase", &schema::phase())?;

    log.write(world, 0.0, &drawn::world(plan))?;
    log.write(shapes, 0.0, &drawn::robot(robot))?;
    let every = (STEP_S / motion.dt_s).round().max(1.0) as usize;
    let last = motion.samples.len() - 1;
    let mut begun = None;
    for (i, sample) in motion.samples.iter().enumerate() {
        let phase = motion.phase_at(sample.t_s);
        if phase != begun
            && let Some(phase) = phase
        {
            let phase = &motion.phases[phase];
            let message = json!({
                "kind": phase.kind, "swing": phase.swing.as_deref().unwrap_or_default(),
                "from_stance": phase.from_stance, "to_stance": phase.to_stance,
            });
            log.write(phases, sample.t_s, &message)?;
        }
        begun = phase;
        log.write(joints, sample.t_s, &joint_state(sample, robot))?;
        if i % every == 0 || i == last {
            let kinematics = Kinematics::new(robot, &Configuration::from_q(&sample.q)?);
            log.write(tf, sample.t_s, &transforms(sample, robot, &kinematics))?;
            let closed = phase.map_or(&[][..], |phase| &motion.phases[phase].contacts);
            log.write(
                contacts,
                sample.t_s,
                &drawn::contacts(sample, closed, robot),
            )?;
        }
    }
    log.0.attach(&Attachment {
        log_time: 0,
        create_time: 0,
        name: "plan.json".to_owned(),
        media_type: "application/json".to_owned(),
        data: Cow::Owned(crate::output::json(plan)?),
    })?;
    log.0.finish()?;
    Ok(log.0.into_inner().into_inner())
}

/// Where the bodies are.
fn transforms(sample: &Sample, robot: &Robot, kinematics: &Kinematics) -> Value {
    let bodies = robot.bodies.iter().zip(&kinematics.X_WB);
    let transforms = bodies.map(|(body, X_WB)| {
        let pose = drawn::pose(X_WB);
        json!({
            "timestamp": time(sample.t_s), "parent_frame_id": WORLD, "child_frame_id": body.name,
            "translation": pose["position"], "rotation": pose["orientation"],
        })
    });
    json!({ "transforms": transforms.collect::<Vec<_>>() })
}

fn joint_state(sample: &Sample, robot: &Robot) -> Value {
    let all = |values: &[f64]| values.iter().map(|x| rounded(*x)).collect::<Vec<_>>();
    json!({
        "header": { "stamp": time(sample.t_s), "frame_id": "" },
        "name": robot.joint_names().collect::<Vec<_>>(),
        "position": all(&sample.q[7..]), "velocity": all(&sample.v[6..]), "effort": all(&sample.tau),
    })
}

/// A time or duration as messages have it.
fn time(t_s: f64) -> Value {
    let ns = nanoseconds(t_s);
    json!({ "sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000 })
}

fn nanoseconds(t_s: f64) -> u64 {
    (t_s * 1e9).round() as u64
}

/// The file in the making.
struct Log(Writer<Cursor<Vec<u8>>>);

impl Log {
    fn new() -> Result<Self> {
        let options = WriteOptions::new().compression(None).profile("");
        Ok(Self(options.create(Cursor::new(Vec::new()))?))
    }

    fn channel(&mut self, topic: &str, name: &str, schema: &Value) -> Result<u16> {
        let text = serde_json::to_vec(schema)?;
        let schema = self.0.add_schema(name, "jsonschema", &text)?;
        let none = BTreeMap::new();
        Ok(self.0.add_channel(schema, topic, "json", &none)?)
    }

    fn write(&mut self, channel_id: u16, t_s: f64, message: &Value) -> Result<()> {
        let at = nanoseconds(t_s);
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: at,
            publish_time: at,
        };
        let text = serde_json::to_vec(message)?;
        self.0
            .write_to_known_channel(&header, &text)
            .context("mcap")
    }
}
