//! Segments, one after the other, as the motion that is written.
#![allow(non_snake_case)]

use nalgebra::Vector3;
use plan::{MOTION_FORMAT, Motion, Phase, PhaseKind, Sample};
use posture::{Contact, force_points};

use crate::problem::MotionContext;
use crate::sampling::Instance;
use crate::segment::Segment;

/// The motion of a plan: its segments in order, `segments[k]` from stance k to stance k + 1.
pub fn assemble(context: &MotionContext, segments: &[&Segment]) -> Motion {
    let config = context.config;
    let mut motion = Motion {
        format: MOTION_FORMAT.to_owned(),
        robot: context.robot.name.clone(),
        dt_s: config.dt_s,
        phases: Vec::new(),
        samples: Vec::new(),
    };
    for (k, segment) in segments.iter().enumerate() {
        for phase in &segment.phases {
            let contacts = contacts(context, &phase.closed);
            let swing = phase.swing.map(|p| context.robot.patches[p].name.clone());
            let samples = phase.samples.iter();
            append(
                &mut motion,
                (phase.kind, k, k + 1),
                contacts,
                swing,
                samples,
            );
            let rest = (config.settle_s / config.dt_s).round() as usize;
            if let (Some(landed), Some(last)) = (&phase.landed, phase.samples.last())
                && rest > 0
            {
                // The patch that has landed is closed, and carries nothing yet.
                let mut closed = phase.closed.clone();
                closed.push(landed.clone());
                let polygon = &context.robot.patches[landed.patch].polygon;
                let points = force_points(polygon, context.posture.com_margin_m).len();
                let mut still = last.clone();
                still.forces_W.push(vec![Vector3::zeros(); points]);
                let contacts = self::contacts(context, &closed);
                let samples = std::iter::repeat_n(&still, rest + 1);
                let holds = (PhaseKind::Hold, k + 1, k + 1);
                append(&mut motion, holds, contacts, None, samples);
            }
        }
    }
    motion
}

/// Appends a phase; its first sample takes the place of the last phase's last one.
fn append<'a>(
    motion: &mut Motion,
    (kind, from_stance, to_stance): (PhaseKind, usize, usize),
    contacts: Vec<plan::Contact>,
    swing: Option<String>,
    samples: impl Iterator<Item = &'a Instance>,
) {
    motion.samples.pop();
    let begin = motion.samples.len();
    let time = |i: usize| i as f64 * motion.dt_s;
    let forces = |contact: &Vec<Vector3<f64>>| contact.iter().map(|f| (*f).into()).collect();
    let samples = samples.enumerate().map(|(i, s)| Sample {
        t_s: time(begin + i),
        q: s.q.clone(),
        com_W: s.com_W.into(),
        forces_W: s.forces_W.iter().map(forces).collect(),
    });
    let samples: Vec<Sample> = samples.collect();
    let (t_start_s, t_end_s) = (time(begin), time(begin + samples.len() - 1));
    motion.phases.push(Phase {
        kind,
        t_start_s,
        t_end_s,
        from_stance,
        to_stance,
        contacts,
        swing,
    });
    motion.samples.extend(samples);
}

fn contacts(context: &MotionContext, closed: &[Contact]) -> Vec<plan::Contact> {
    let record = |contact: &Contact| {
        let patch = &context.robot.patches[contact.patch];
        let face = contact
            .face
            .map(|face| context.environment[face].id.clone());
        plan::Contact {
            patch: patch.name.clone(),
            link: patch.link.clone(),
            face: face.unwrap_or_default(),
            X_WC: (&contact.X_WC).into(),
            friction: patch.friction,
            loaded: true,
            vertices_W: Vec::new(),
            force_points_W: Vec::new(),
            forces_W: Vec::new(),
        }
    };
    closed.iter().map(record).collect()
}
