//! The motion between the stances: the record, its phases beside the stances, and its samples.
//!
//! | file | what it checks |
//! |---|---|
//! | `phases` | phases lead from stance to stance, on contacts that both have; ends are the stances |
//! | `samples` | every sample: contacts, forces; distances at every time |
//! | `joints` | the joints of a sample: limits, speeds, accelerations |
//! | `dynamics` | what accelerates every body and what the joints must exert for it |
//!
//! Rows carry the stance that a phase leads to, and the time in their subject.

mod dynamics;
mod joints;
mod phases;
mod samples;

use plan::Motion;
use rayon::prelude::*;

use crate::extremes::Extremes;
use crate::findings::{Findings, exceeds};
use crate::scene::Scene;
use crate::{Check, TOLERANCES};

/// Goes through a motion.
pub(crate) fn check(scene: &Scene, motion: &Motion, findings: &mut Findings) {
    if !record(scene, motion, findings) || !phases::check(scene, motion, findings) {
        return;
    }
    let worst: Vec<Extremes> = (0..motion.phases.len())
        .into_par_iter()
        .map(|phase| samples::check(scene, motion, phase))
        .collect();
    for (phase, worst) in motion.phases.iter().zip(worst) {
        worst.report(Some(phase.to_stance), findings);
    }
}

/// Whether the record can be gone through at all.
fn record(scene: &Scene, motion: &Motion, findings: &mut Findings) -> bool {
    let mut flaw = |note: String| findings.flaw(None, Check::MotionRecord, "motion", note);
    if let Err(error) = motion.validate() {
        flaw(error.to_string());
        return false;
    }
    if motion.robot != scene.robot.name {
        let (meant, given) = (&motion.robot, &scene.robot.name);
        flaw(format!("made for {meant}, not {given}"));
    }
    let wanted = scene.robot.bodies.len() + 6;
    let extent = TOLERANCES.extent_m;
    let sane = motion.samples.iter().all(|s| {
        let forces = s.forces_W.iter().flatten().flatten();
        s.q.len() == wanted
            && s.q.iter().chain(&s.com_W).all(|x| x.abs() <= extent)
            && s.q[3..7].iter().any(|x| x.abs() > 1e-3)
            && forces.into_iter().all(|x| x.abs() <= 1e7)
    });
    if !sane {
        let what = format!("a sample has not {wanted} values, or one out of all proportion");
        flaw(what);
    }
    if let Some(stated) = &scene.plan.motion {
        let (real, samples) = (motion.duration_s(), motion.samples.len());
        if stated.samples != samples || exceeds((stated.duration_s - real).abs(), 1e-9 * real) {
            let (s, n) = (stated.duration_s, stated.samples);
            flaw(format!(
                "the plan says {s} s in {n} samples, it has {real} s in {samples}"
            ));
        }
    }
    let limits = &motion.limits;
    let uses = [
        limits.joint_speed_use,
        limits.torque_use,
        limits.friction_use,
    ];
    let shares = uses.iter().all(|part| (0.0..=1.0).contains(part));
    let most = TOLERANCES.motion_acceleration;
    let acceleration = (0.0..=most).contains(&limits.joint_acceleration_rad_s2);
    if !(shares && acceleration && (0.0..1.0).contains(&limits.margin_use)) {
        flaw("it promises itself more than there is".to_owned());
    }
    if motion.dt_s > TOLERANCES.motion_step_s {
        flaw(format!("samples {} s apart are too few", motion.dt_s));
    }
    findings.holds_unless_flawed(None, Check::MotionRecord);
    !findings.flawed(None, Check::MotionRecord)
}
