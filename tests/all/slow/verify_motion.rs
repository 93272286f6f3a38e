//! The verifier passes the motions of the scenes that ship, and catches what is changed in them.
use plan::{Change, Motion, Plan, Stance};
use verify::{Certificate, Check, verify};

use crate::support::program::robot;
use crate::support::shipped::{Shipped, shipped};

fn certify(planned: &Shipped, motion: &Motion) -> Certificate {
    // What the plan says of its motion's length is held against it elsewhere.
    let plan = Plan {
        motion: None,
        ..planned.plan.clone()
    };
    verify(&plan, Some(motion), &robot("hrp2"))
}

/// The same samples in a part of the time.
fn hurry(motion: &mut Motion, part: f64) {
    motion.dt_s *= part;
    for phase in &mut motion.phases {
        phase.t_start_s *= part;
        phase.t_end_s *= part;
    }
    motion.samples.iter_mut().for_each(|s| s.t_s *= part);
}

/// One change of a motion, and the checks of which one must fail.
type Mutation = (&'static str, fn(&mut Motion, usize), &'static [Check]);

/// Changes at a sample in the middle of the first swing.
#[rustfmt::skip]
const MUTATIONS: &[Mutation] = &[
    ("a joint of the leg that stands is turned", |m, i| m.samples[i].q[10..24].iter_mut().for_each(|q| *q += 0.02),
        &[Check::Kept]),
    ("the whole robot is lifted", |m, i| m.samples[i].q[2] += 0.005, &[Check::Kept]),
    ("the robot jumps there and back", |m, i| m.samples[i].q[0] += 0.05, &[Check::MotionRate]),
    ("the stated centre of mass is another", |m, i| m.samples[i].com_W[1] += 1e-3, &[Check::Com]),
    ("the phase's contact is on another link", |m, _| m.phases[0].contacts[0].link.push('x'),
        &[Check::MotionPhases]),
    ("a force is greater", |m, i| m.samples[i].forces_W[0][0][2] += 5.0, &[Check::BalanceForce]),
    ("forces change places", |m, i| {
        let forces = &mut m.samples[i].forces_W[0];
        forces.swap(0, 2);
        forces[1][2] += 30.0;
        forces[0][2] -= 30.0;
    }, &[Check::BalanceMoment, Check::Unilateral]),
    ("a contact pulls sideways", |m, i| {
        m.samples[i].forces_W[0][0][0] += 300.0;
        m.samples[i].forces_W[0][1][0] -= 300.0;
    }, &[Check::Friction]),
    ("the quaternion is no unit one", |m, i| m.samples[i].q[3..7].iter_mut().for_each(|q| *q *= 1.01),
        &[Check::Quaternion]),
    ("a sample is missing", |m, i| drop(m.samples.remove(i)), &[Check::MotionRecord]),
    ("a number is none", |m, i| m.samples[i].q[9] = f64::NAN, &[Check::MotionRecord]),
    ("another robot", |m, _| m.robot.push('x'), &[Check::MotionRecord]),
    ("half as many samples in the same time", |m, _| {
        m.samples = m.samples.iter().step_by(4).cloned().collect();
        m.dt_s *= 4.0;
        for (i, sample) in m.samples.iter_mut().enumerate() {
            sample.t_s = i as f64 * m.dt_s;
        }
    }, &[Check::MotionRecord]),
    ("the motion ends a stance early", |m, _| {
        let last = m.phases.pop().unwrap();
        let samples = (last.t_start_s / m.dt_s).round() as usize + 1;
        m.samples.truncate(samples);
        m.samples[samples - 1].forces_W = m.samples[samples - 2].forces_W.clone();
    }, &[Check::MotionPhases]),
    ("what swings is said to be closed", |m, _| {
        let phase = m.phases.iter_mut().find(|p| p.swing.is_some()).unwrap();
        phase.swing = Some(phase.contacts[0].patch.clone());
    }, &[Check::MotionPhases]),
    ("a closed contact is said to be elsewhere", |m, _| m.phases[0].contacts[0].X_WC.p[0] += 0.01,
        &[Check::Kept]),
    ("the motion ends beside its stance", |m, _| m.samples.last_mut().unwrap().q[7] += 1e-3,
        &[Check::MotionEnd]),
    ("everything takes 0.7 of its time", |m, _| hurry(m, 0.7), &[Check::MotionRate]),
    ("everything takes 0.7 of its time, rates told as they are", |m, _| {
        hurry(m, 0.7);
        for sample in &mut m.samples {
            sample.v.iter_mut().for_each(|v| *v /= 0.7);
            sample.a.iter_mut().for_each(|a| *a /= 0.49);
        }
    }, &[Check::BalanceMoment]),
    ("the same is promised", |m, _| {
        hurry(m, 0.7);
        m.limits.joint_speed_use = 1.2;
    }, &[Check::MotionRecord]),
    ("a velocity is another", |m, i| m.samples[i].v[8] += 0.2, &[Check::MotionRate]),
    ("an acceleration is another", |m, i| m.samples[i].a[2] += 0.1, &[Check::BalanceForce]),
    ("a torque is another", |m, i| m.samples[i].tau[3] += 3.0, &[Check::MotionTorque]),
    ("forces act at the edge of the sole", |m, _| {
        let contact = &mut m.phases[0].contacts[0];
        for point in &mut contact.force_points_W {
            for (p, centre) in point.iter_mut().zip(contact.X_WC.p) {
                *p += 0.5 * (*p - centre);
            }
        }
    }, &[Check::ForcePoint]),
];

#[test]
fn every_sample_of_the_scenes_that_ship_passes() {
    for name in ["irregular-stairs", "slope-and-hand"] {
        let planned = shipped(name);
        let motion = &planned.motion;
        let certificate = certify(planned, motion);
        assert!(certificate.pass, "{name}:\n{}", certificate.table());

        // One swing for every contact that is made, and no sample farther than 10 ms from the next.
        let adds = |s: &&Stance| matches!(s.change, Change::Add { .. });
        let made = planned.plan.stances.iter().filter(adds).count();
        let swings = motion.phases.iter().filter(|p| p.swing.is_some()).count();
        assert!(swings >= made, "{name}: {swings} for {made} contacts");
        assert!(motion.dt_s <= 0.01);
    }
}

#[test]
fn every_change_of_a_motion_is_caught() {
    let planned = shipped("irregular-stairs");
    let motion = &planned.motion;
    let swing = motion.phases.iter().find(|p| p.swing.is_some()).unwrap();
    let middle = (0.5 * (swing.t_start_s + swing.t_end_s) / motion.dt_s).round() as usize;
    for (what, change, expected) in MUTATIONS {
        let mut changed = motion.clone();
        change(&mut changed, middle);
        let certificate = certify(planned, &changed);
        let failed = certificate.failed_checks();
        assert!(
            expected.iter().any(|check| failed.contains(check)),
            "{what}: {expected:?} wanted, {failed:?} failed"
        );
    }
}
