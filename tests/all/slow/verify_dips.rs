//! A foot in the air that dips 5 mm deeper than it may is caught, whenever and however briefly it does.
//!
//! Dips are smooth bumps of 1 to 40 samples in the joints of the leg that swings, told in velocities and
//! accelerations as they are, so that distances alone can notice.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Vector3};
use plan::{Contact, Motion, Plan};
use robot_model::{Configuration, Kinematics, Robot};
use scenes::simulator::rng::Stream;
use surfaces::Face;
use verify::{Check, TOLERANCES, verify};

use crate::support::program::robot;
use crate::support::shipped::shipped;

const DEEPER_M: f64 = 0.005;

/// How far the lowest point of a patch is over what it may come down to, m: on a face that it leaves or
/// lands on the depth of a contact, on another one the clearance, unless it is near to where it touches.
/// `None` where it is over none.
fn room(plan: &Plan, robot: &Robot, patch: usize, own: &[&Contact], q: &[f64]) -> Option<f64> {
    let kinematics = Kinematics::new(robot, &Configuration::from_q(q).unwrap());
    let X_WC = kinematics.X_WC(&robot.patches[patch]);
    let radius = robot.patches[patch].point_radius_m().unwrap_or(0.0);
    let near = own.iter().any(|c| {
        let away = X_WC.translation.vector - Vector3::from(c.X_WC.p);
        away.norm() < 2.5 * TOLERANCES.motion_touch_m
    });
    let least = |face: &Face| {
        let allowed = match own.iter().any(|c| c.face == face.id) {
            true => -TOLERANCES.contact_depth_m,
            false if near => return None,
            false => plan.required.clearance_m - TOLERANCES.motion_distance_m,
        };
        let corners = robot.patches[patch].polygon.iter();
        let heights = corners.filter_map(|c| {
            let p_W = X_WC * nalgebra::Point3::new(c.x, c.y, 0.0);
            let p = face.X_WF.inverse_transform_point(&p_W);
            let inside = (face.region.nearest(&p.xy()) - p.xy()).norm() < 1e-9;
            // Not beside a body, nor under it.
            (inside && p.z - radius > -plan.thin_body_m / 2.0).then_some(p.z - radius - allowed)
        });
        heights.min_by(f64::total_cmp)
    };
    let upward = plan.faces.iter().filter(|face| face.normal_W().z > 0.9);
    upward.filter_map(least).min_by(f64::total_cmp)
}

/// Adds a dip to a motion; `None` where this draw makes none that is 5 mm too deep.
fn dip(plan: &Plan, motion: &mut Motion, robot: &Robot, stream: &Stream) -> Option<String> {
    let draw = |k: u64, below: usize| (stream.uniform(k) * below as f64) as usize;
    let swings: Vec<_> = motion.phases.iter().filter(|p| p.swing.is_some()).collect();
    let phase = swings[draw(0, swings.len())];
    let name = phase.swing.as_deref()?;
    let patch = robot.patches.iter().position(|p| p.name == name)?;
    let stances = [phase.from_stance, phase.to_stance].map(|k| &plan.stances[k]);
    let contacts = stances.iter().flat_map(|s| &s.contacts);
    let own: Vec<&Contact> = contacts.filter(|c| c.patch == name).collect();
    let [first, last] =
        [phase.t_start_s, phase.t_end_s].map(|t| (t / motion.dt_s).round() as usize);
    let width = 1 + draw(1, 40);
    let middle = first + draw(2, last - first);
    let half = (width as f64 + 1.0) / 2.0;
    if (middle as f64) < first as f64 + half || middle as f64 + half > last as f64 {
        return None;
    }

    // Down, by the joints of the leg.
    let q = motion.samples[middle].q.clone();
    let kinematics = Kinematics::new(robot, &Configuration::from_q(&q).ok()?);
    let centre = kinematics.X_WC(&robot.patches[patch]).translation.vector;
    let mut jacobian = DMatrix::zeros(3, robot.nv());
    kinematics.point_jacobian(robot, robot.patches[patch].body, &centre, &mut jacobian);
    let legs = jacobian.columns(6, robot.nv() - 6).into_owned();
    let damped = &legs * legs.transpose() + nalgebra::Matrix3::identity() * 1e-4;
    let down = legs.transpose() * damped.try_inverse()? * -Vector3::z();
    let bent = |part: f64| {
        let joints = q[7..].iter().zip(down.iter()).map(|(q, d)| q + part * d);
        q[..7].iter().copied().chain(joints).collect::<Vec<f64>>()
    };
    let (mut low, mut high) = (0.0, 0.3);
    let deep = |part: f64| room(plan, robot, patch, &own, &bent(part)).map(|r| r + DEEPER_M);
    if deep(low)? < 0.0 {
        return None;
    }
    let steps = (1..=60).map(|k| 0.005 * f64::from(k));
    high = steps
        .into_iter()
        .find(|s| deep(*s).is_some_and(|d| d < 0.0))
        .unwrap_or(high);
    if deep(high)? >= 0.0 {
        return None;
    }
    for _ in 0..40 {
        let part = 0.5 * (low + high);
        match deep(part).is_some_and(|d| d < 0.0) {
            true => high = part,
            false => low = part,
        }
    }

    // cos² over the width.
    for i in first..=last {
        let x = (i as f64 - middle as f64) / half;
        if x.abs() >= 1.0 {
            continue;
        }
        let rate = PI / (half * motion.dt_s);
        let (sin, cos) = (PI * x).sin_cos();
        let bump = [
            0.5 * (1.0 + cos),
            -0.5 * sin * rate,
            -0.5 * cos * rate * rate,
        ];
        let sample = &mut motion.samples[i];
        for (k, d) in down.iter().enumerate() {
            sample.q[7 + k] += high * d * bump[0];
            sample.v[6 + k] += high * d * bump[1];
            sample.a[6 + k] += high * d * bump[2];
        }
    }
    Some(format!(
        "{name} over {width} samples at {:.2} s",
        motion.samples[middle].t_s
    ))
}

/// Draws dips and counts them; each must show in a distance.
fn all_caught(scene: &'static str, robot: &Robot, seed: u64, count: usize) {
    let planned = shipped(scene);
    let mut made = 0;
    for draw in 0.. {
        let mut motion = planned.motion.clone();
        let stream = Stream::new(seed, draw);
        let Some(what) = dip(&planned.plan, &mut motion, robot, &stream) else {
            assert!(
                draw < 100 * count as u64,
                "{scene}: {made} dips in {draw} draws"
            );
            continue;
        };
        let certificate = verify(&planned.plan, Some(&motion), robot);
        let failed = certificate.failed_checks();
        let seen = [Check::Clearance, Check::ContactDepth, Check::SelfClearance];
        let caught = seen.iter().any(|check| failed.contains(check));
        assert!(caught, "{scene}, {what}: {failed:?}");
        made += 1;
        if made == count {
            return;
        }
    }
}

#[test]
fn every_dip_of_a_foot_is_caught() {
    all_caught("irregular-stairs", &robot("hrp2"), 1, 12);
    all_caught("slope-15.3", &robot("quadruped"), 2, 12);
}

#[test]
#[ignore = "a thousand dips take minutes: to judge with, not to develop on"]
fn a_thousand_other_dips_are_caught() {
    all_caught("irregular-stairs", &robot("hrp2"), 4711, 400);
    all_caught("slope-15.3", &robot("quadruped"), 4712, 300);
    all_caught("hexapod-obstacles", &robot("hexapod"), 4713, 300);
}
