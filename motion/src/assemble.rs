//! Segments, one after the other, as the motion that is written.

use nalgebra::{DVector, Vector3};
use plan::{Limits, MOTION_FORMAT, Motion, Phase, PhaseKind, Sample};
use posture::Contact;
use rayon::prelude::*;

use crate::Config;
use crate::load_shares::LoadShares;
use crate::pace::{self, Paced};
use crate::passage;
use crate::problem::MotionContext;
use crate::segment::{PhaseTrajectory, Segment};

/// Pieces of a phase at whose ends its limits are looked at for the time from rest to rest: the fewer, the less
/// that is.
const LOOKED_AT: [usize; 2] = [pace::PLACES / 8, pace::PLACES];

/// What motions of these settings keep to.
pub fn limits(config: &Config, posture: &posture::Config) -> Limits {
    Limits {
        joint_speed_use: config.joint_speed_use,
        joint_acceleration_rad_s2: config.joint_acceleration_rad_s2,
        torque_use: config.torque_use.max(posture.torque_use),
        friction_use: config.friction_use.max(posture.friction_use),
        margin_use: config.margin_use,
    }
}

/// The motion of a plan: its segments in order, `segments[k]` from stance k to stance k + 1, in the
/// shortest time that the limits allow.
pub fn assemble(context: &MotionContext, segments: &[&Segment]) -> Motion {
    let config = context.config;
    let mut motion = Motion {
        format: MOTION_FORMAT.to_owned(),
        robot: context.robot.name.clone(),
        dt_s: config.dt_s,
        limits: limits(config, context.posture),
        phases: Vec::new(),
        samples: Vec::new(),
    };
    let all = segments.iter().enumerate();
    let all = all.flat_map(|(k, segment)| segment.phases.iter().map(move |phase| (k, phase)));
    let all: Vec<_> = all.collect();
    let rest = (config.settle_s / config.dt_s).round() as usize;
    let stops: Vec<&PhaseTrajectory> = all.iter().map(|(_, phase)| *phase).collect();
    let passing = passage::through(context, &stops, |phase| rest == 0 || phase.landed.is_none());
    let paced = passing
        .into_par_iter()
        .flat_map(|run| paced(context, &run, &stops));
    for ((k, phase), (shares, samples)) in all.into_iter().zip(paced.collect::<Vec<_>>()) {
        let swing = phase
            .task
            .swing
            .as_ref()
            .map(|s| context.patch_name(s.patch));
        let contacts = contacts(context, &phase.task.closed, &shares);
        let kind = (phase.kind, k, k + 1);
        append(&mut motion, kind, contacts, swing, samples.iter());
        if let (Some(landed), Some(last)) = (&phase.landed, samples.into_iter().next_back())
            && rest > 0
        {
            // The patch that has landed is closed, and carries nothing yet.
            let mut closed = phase.task.closed.clone();
            closed.push(landed.clone());
            let shares = LoadShares::new(context, &closed);
            let points = shares
                .points
                .iter()
                .filter(|p| p.contact + 1 == closed.len());
            let mut still = last;
            still.forces_W.push(vec![Vector3::zeros(); points.count()]);
            let contacts = self::contacts(context, &closed, &shares);
            let samples = std::iter::repeat_n(&still, rest + 1);
            let holds = (PhaseKind::Hold, k + 1, k + 1);
            append(&mut motion, holds, contacts, None, samples);
        }
    }
    motion
}

/// The samples of phases that are gone through without a stop, or from rest to rest where that is faster
/// even before forces suit it.
fn paced(
    context: &MotionContext,
    run: &[(usize, PhaseTrajectory)],
    stops: &[&PhaseTrajectory],
) -> Vec<(LoadShares, Vec<Paced>)> {
    let bent: Vec<&PhaseTrajectory> = run.iter().map(|(_, phase)| phase).collect();
    let own = || run.par_iter().map(|(k, _)| stops[*k]);
    let through = pace::samples(context, &bent);
    let steps: usize = through.iter().map(|(_, samples)| samples.len() - 1).sum();
    let slow = |pieces: &usize| {
        let least = own().map(|phase| pace::least_s(context, phase, *pieces));
        steps as f64 * context.config.dt_s > least.collect::<Vec<f64>>().iter().sum()
    };
    if run.len() > 1 && (through.is_empty() || LOOKED_AT.iter().all(slow)) {
        return own()
            .flat_map(|phase| pace::samples(context, &[phase]))
            .collect();
    }
    through
}

/// Appends a phase; its first sample takes the place of the last phase's last one.
fn append<'a>(
    motion: &mut Motion,
    (kind, from_stance, to_stance): (PhaseKind, usize, usize),
    contacts: Vec<plan::Contact>,
    swing: Option<String>,
    samples: impl Iterator<Item = &'a Paced>,
) {
    motion.samples.pop();
    let begin = motion.samples.len();
    let time = |i: usize| i as f64 * motion.dt_s;
    let forces = |contact: &Vec<Vector3<f64>>| contact.iter().map(|f| (*f).into()).collect();
    let rates = |v: &DVector<f64>| v.as_slice().to_vec();
    let samples = samples.enumerate().map(|(i, s)| Sample {
        t_s: time(begin + i),
        q: s.q.to_q(),
        v: rates(&s.v),
        a: rates(&s.a),
        tau: s.tau.clone(),
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

fn contacts(
    context: &MotionContext,
    closed: &[Contact],
    shares: &LoadShares,
) -> Vec<plan::Contact> {
    let record = |(k, contact): (usize, &Contact)| {
        let patch = &context.robot.patches[contact.patch];
        let face = contact
            .face
            .map(|face| context.environment[face].id.clone());
        let points = shares.points.iter().filter(|p| p.contact == k);
        plan::Contact {
            patch: patch.name.clone(),
            link: patch.link.clone(),
            face: face.unwrap_or_default(),
            X_WC: (&contact.X_WC).into(),
            rolls_from: contact.rolls_from_W().as_ref().map(Into::into),
            friction: contact.friction,
            loaded: true,
            vertices_W: Vec::new(),
            force_points_W: points.map(|p| p.p_W.into()).collect(),
            forces_W: Vec::new(),
        }
    };
    closed.iter().enumerate().map(record).collect()
}
