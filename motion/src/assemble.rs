//! Segments, one after the other, as the motion that is written.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Vector3};

use crate::force_points::force_points;
use crate::problem::{Closed, Setting};
use crate::record::{MOTION_FORMAT, Motion, Phase, PhaseContact, PhaseKind, Pose, Sample};
use crate::segment::Segment;
use crate::track::Instance;

/// The motion of a plan: its segments in order, `segments[k]` from stance k to stance k + 1.
pub fn assemble(setting: &Setting, segments: &[&Segment]) -> Motion {
    let config = setting.config;
    let mut motion = Motion {
        format: MOTION_FORMAT.to_owned(),
        robot: setting.robot.name.clone(),
        dt_s: config.dt_s,
        phases: Vec::new(),
        samples: Vec::new(),
    };
    for (k, segment) in segments.iter().enumerate() {
        for stretch in &segment.stretches {
            let contacts = contacts(setting, &stretch.closed);
            let swing = stretch.swing.map(|p| setting.robot.patches[p].name.clone());
            append(
                &mut motion,
                (stretch.kind, k, k + 1),
                contacts,
                swing,
                stretch.samples.iter(),
            );
            let rest = (config.settle_s / config.dt_s).round() as usize;
            if let (Some(landed), Some(last)) = (&stretch.landed, stretch.samples.last())
                && rest > 0
            {
                // The patch that has landed is closed, and carries nothing yet.
                let mut closed = stretch.closed.clone();
                closed.push(landed.clone());
                let polygon = &setting.robot.patches[landed.patch].polygon;
                let points = force_points(polygon, setting.posture.com_margin_m).len();
                let mut still = last.clone();
                still.forces_W.push(vec![Vector3::zeros(); points]);
                append(
                    &mut motion,
                    (PhaseKind::Hold, k + 1, k + 1),
                    self::contacts(setting, &closed),
                    None,
                    std::iter::repeat_n(&still, rest + 1),
                );
            }
        }
    }
    motion
}

/// Appends a phase; its first sample takes the place of the last phase's last one.
fn append<'a>(
    motion: &mut Motion,
    (kind, from_stance, to_stance): (PhaseKind, usize, usize),
    contacts: Vec<PhaseContact>,
    swing: Option<String>,
    samples: impl Iterator<Item = &'a Instance>,
) {
    motion.samples.pop();
    let begin = motion.samples.len();
    let time = |i: usize| i as f64 * motion.dt_s;
    let samples: Vec<Sample> = samples
        .enumerate()
        .map(|(i, s)| Sample {
            t_s: time(begin + i),
            q: s.q.clone(),
            com_W: s.com_W.into(),
            forces_W: s
                .forces_W
                .iter()
                .map(|contact| contact.iter().map(|f| (*f).into()).collect())
                .collect(),
        })
        .collect();
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

fn contacts(setting: &Setting, closed: &[Closed]) -> Vec<PhaseContact> {
    closed
        .iter()
        .map(|c| {
            let patch = &setting.robot.patches[c.patch];
            let surface = setting.environment.surfaces.get(c.surface);
            PhaseContact {
                patch: patch.name.clone(),
                surface: surface.map_or_else(String::new, |s| s.id.clone()),
                X_WC: pose(&c.X_WC),
                friction: patch.friction,
            }
        })
        .collect()
}

fn pose(X: &Isometry3<f64>) -> Pose {
    Pose {
        p: X.translation.vector.into(),
        quat_xyzw: X.rotation.coords.into(),
    }
}
