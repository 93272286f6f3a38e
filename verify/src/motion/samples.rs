//! The samples of one phase.

use std::iter::repeat;

use nalgebra::{Matrix4, Vector3};
use plan::{Contact, Motion, Phase};
use robot_model::ContactPatch;
use surfaces::Face;

use crate::clearance::{Bounds, Pairs};
use crate::extremes::Extremes;
use crate::forces::{least_inside, shrunk_by};
use crate::motion::dynamics::exerted;
use crate::motion::joints;
use crate::posture::{Load, Posture, column, inverse_point, point, pose};
use crate::rolling;
use crate::scene::{Scene, Touch};
use crate::step::{Moment, Step, bends_m, between};
use crate::{Check, TOLERANCES};

/// A closed contact of the phase, with what it refers to.
struct Closed<'a> {
    stated: &'a Contact,
    /// Where its forces act in motion, in W.
    points_W: &'a [[f64; 3]],
    patch: &'a ContactPatch,
    face: &'a Face,
}

/// The worst of every check over the samples of a phase, both ends included.
pub(super) fn check(scene: &Scene, motion: &Motion, index: usize) -> Extremes {
    let mut worst = Extremes::default();
    let phase = &motion.phases[index];
    let sample_at = |t: f64| (t / motion.dt_s).round() as usize;
    let (first, last) = (sample_at(phase.t_start_s), sample_at(phase.t_end_s));
    let closed = closed(scene, phase);
    let swung = swung(scene, phase);
    let mut postures: Vec<Posture> = Vec::new();
    for i in first..=last.min(motion.samples.len() - 1) {
        let sample = &motion.samples[i];
        let at = |what: &str| format!("{what} at {:.2} s", sample.t_s);
        let Some(posture) = Posture::new(scene.robot, &sample.q) else {
            worst.add(Check::MotionRate, f64::NAN, 0.0, || at("q"));
            return worst;
        };
        let com = (Vector3::from(sample.com_W) - posture.com_W).norm();
        worst.add(Check::Com, com, TOLERANCES.com_m, || at("motion"));
        joints::limits(scene, motion, i, &mut worst);
        if i > first {
            joints::rates(motion, i, &mut worst);
        }
        if i >= first + joints::JUMP_STEPS {
            joints::jumps(motion, i, &mut worst);
        }
        if i == first {
            points(scene, motion, &closed, &posture, &mut worst);
        }
        contacts(phase, &closed, &posture, sample.t_s, &mut worst);
        // The forces of the border belong to the next phase's contacts.
        let own = i < last || last + 1 == motion.samples.len();
        if own && sample.forces_W.len() == closed.len() {
            forces(scene, motion, &closed, &posture, sample, &mut worst);
        }
        postures.push(posture);
    }
    distances(
        scene,
        motion,
        first,
        &postures,
        &[closed, swung],
        &mut worst,
    );
    worst
}

/// The phase's contacts, which the phases' check has found in its stances.
fn closed<'a>(scene: &Scene<'a>, phase: &'a Phase) -> Vec<Closed<'a>> {
    let from = scene.plan.stances[phase.from_stance].contacts.iter();
    let contacts = phase.contacts.iter().filter_map(|contact| {
        let stated = from.clone().find(|c| c.patch == contact.patch)?;
        let points_W = &contact.force_points_W;
        refer(scene, stated).map(|closed| Closed { points_W, ..closed })
    });
    contacts.collect()
}

fn refer<'a>(scene: &Scene<'a>, stated: &'a Contact) -> Option<Closed<'a>> {
    let (patch, face) = scene.named(stated)?;
    Some(Closed {
        stated,
        points_W: &[],
        patch,
        face,
    })
}

/// What the patch in the air leaves and lands on.
fn swung<'a>(scene: &Scene<'a>, phase: &Phase) -> Vec<Closed<'a>> {
    let plan: &'a _ = scene.plan;
    let Some(patch) = &phase.swing else {
        return Vec::new();
    };
    let stances = [phase.from_stance, phase.to_stance].map(|k| &plan.stances[k]);
    let contacts = stances.into_iter().flat_map(|stance| &stance.contacts);
    let own = contacts.filter(|c| &c.patch == patch);
    own.filter_map(|stated| refer(scene, stated)).collect()
}

/// Forces act inside the patches, away from their edges.
fn points(
    scene: &Scene,
    motion: &Motion,
    closed: &[Closed],
    posture: &Posture,
    worst: &mut Extremes,
) {
    for contact in closed {
        let name = || format!("{} in motion", contact.patch.name);
        if let Some(stood_W) = rolling::stood_W(contact.stated, contact.patch, contact.face) {
            let off = |p: &[f64; 3]| (Vector3::from(*p) - stood_W).norm();
            let off = contact.points_W.iter().map(off).fold(0.0, f64::max);
            worst.add(Check::ForcePoint, -off, -TOLERANCES.closure_m, name);
            continue;
        }
        let touch = touch(contact, posture);
        let least = least_inside(&touch, contact.points_W);
        let kept = 1.0 - motion.limits.margin_use;
        let shrunk = shrunk_by(touch.patch, scene.plan.required.com_m) * kept;
        worst.add(
            Check::ForcePoint,
            least,
            shrunk - TOLERANCES.closure_m,
            name,
        );
    }
}

/// Closed contacts stay where they were made.
fn contacts(phase: &Phase, closed: &[Closed], posture: &Posture, t_s: f64, worst: &mut Extremes) {
    for (contact, recorded) in closed.iter().zip(&phase.contacts) {
        let X_WB = &posture.X_WB[contact.patch.body];
        let X_WC = X_WB * contact.patch.X_BC.to_homogeneous();
        if contact.stated.rolls_from.is_some() {
            let off = [recorded, contact.stated].map(|c| {
                let centre_W = rolling::centre_W(c, contact.patch, contact.face, X_WB);
                centre_W.map_or(f64::NAN, |p| (p - column(&X_WC, 3)).norm())
            });
            let name = || format!("{} at {t_s:.2} s", contact.patch.name);
            let worse = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
            let off = off.into_iter().fold(0.0, worse);
            worst.add(Check::Kept, off, TOLERANCES.closure_m, name);
            continue;
        }
        for X in [&recorded.X_WC, &contact.stated.X_WC] {
            let stated = pose(&X.p, &X.quat_xyzw);
            let vertices = contact.patch.polygon.iter();
            let vertices = vertices.map(|v| Vector3::new(v.x, v.y, 0.0));
            let apart = vertices.map(|v| (point(&stated, &v) - point(&X_WC, &v)).norm());
            let off = apart.fold(0.0, f64::max);
            worst.add(Check::Kept, off, TOLERANCES.closure_m, || {
                format!("{} at {t_s:.2} s", contact.patch.name)
            });
        }
    }
}

/// The forces lie in their cones, accelerate the robot as it is stated and ask no joint for too much.
fn forces(
    scene: &Scene,
    motion: &Motion,
    closed: &[Closed],
    posture: &Posture,
    sample: &plan::Sample,
    worst: &mut Extremes,
) {
    let limits = &motion.limits;
    let weight = posture.weight();
    let rounding = TOLERANCES.force * weight;
    let mut loads: Vec<Load> = Vec::new();
    for (contact, forces) in closed.iter().zip(&sample.forces_W) {
        let name = || format!("{} at {:.2} s", contact.patch.name, sample.t_s);
        let points = contact.points_W;
        if points.len() != forces.len() {
            worst.add(Check::BalanceForce, f64::NAN, 0.0, name);
            return;
        }
        let normal = column(&contact.face.X_WF.to_homogeneous(), 2);
        // A ball that rolls bears where it touches.
        let touched: Vec<[f64; 3]> = match contact.stated.rolls_from {
            Some(_) => touch(contact, posture)
                .vertices_W
                .iter()
                .map(|p| (*p).into())
                .collect(),
            None => points.to_vec(),
        };
        for (p, f) in touched.iter().zip(forces) {
            let f = Vector3::from(*f);
            let along = f.dot(&normal);
            let across = ((f - normal * along).norm() - rounding).max(0.0);
            worst.add(Check::Unilateral, along, -rounding, name);
            if along > rounding {
                let used = across / (contact.stated.friction * along);
                let bound = limits.friction_use + TOLERANCES.motion_part;
                worst.add(Check::Friction, used, bound, name);
            } else {
                worst.add(Check::Unloaded, across, rounding, name);
            }
            loads.push((contact.patch.body, Vector3::from(*p), f));
        }
    }
    let left = exerted(posture, &sample.v, &sample.a, &loads);
    let at = || format!("motion at {:.2} s", sample.t_s);
    let (force, moment) = (left.force.norm() / weight, left.moment.norm() / weight);
    worst.add(Check::BalanceForce, force, TOLERANCES.balance, at);
    worst.add(Check::BalanceMoment, moment, TOLERANCES.balance, at);
    let bodies = scene.robot.bodies.iter().skip(1);
    for ((body, tau), stated) in bodies.zip(left.tau).zip(&sample.tau) {
        let at = || format!("{} at {:.2} s", body.joint, sample.t_s);
        let off = (tau - stated).abs() / weight;
        worst.add(Check::MotionTorque, off, TOLERANCES.balance, at);
        if body.effort > 0.0 && body.effort.is_finite() {
            let bound = limits.torque_use + TOLERANCES.motion_part;
            worst.add(Check::Torque, tau.abs() / body.effort, bound, at);
        }
    }
}

/// Nothing comes nearer than it may, at any time: closed contacts touch, and the patch in the air where
/// it is near to the face that it leaves or lands on.
fn distances(
    scene: &Scene,
    motion: &Motion,
    first: usize,
    postures: &[Posture],
    [closed, swung]: &[Vec<Closed>; 2],
    worst: &mut Extremes,
) {
    let mut moments: Vec<Moment> = Vec::with_capacity(postures.len());
    for posture in postures {
        moments.push(Moment::new(scene, posture, moments.last()));
    }
    let touching = closed.iter().chain(swung);
    let touching: Vec<(&ContactPatch, &Face)> = touching.map(|c| (c.patch, c.face)).collect();
    let all: Vec<&Moment> = moments.iter().collect();
    let mut pairs = Pairs::new(scene, &touching, Bounds::of_motion(scene), &all);
    let heights_m = |posture: &Posture| {
        let swung = swung.iter().map(|contact| height_m(contact, posture));
        let closed = closed.iter().map(|_| f64::NEG_INFINITY);
        closed.chain(swung).collect::<Vec<f64>>()
    };
    let mut before_m = Vec::new();
    for (k, (now, posture)) in moments.iter().zip(postures).enumerate() {
        let before = k.checked_sub(1).map(|k| &moments[k]);
        let pair = [first + k - before.iter().count(), first + k].map(|i| &motion.samples[i]);
        let h = motion.dt_s;
        let at = |part: f64| {
            let posture = Posture::new(scene.robot, &between(pair, h, part))?;
            Some(Moment::new(scene, &posture, None))
        };
        let step = Step {
            before,
            now,
            bends_m: &bends_m(scene, posture, pair, h),
            at: &at,
        };
        // During a step that may touch which touches at one of its ends.
        let now_m = heights_m(posture);
        let either = now_m
            .iter()
            .zip(before_m.iter().chain(repeat(&f64::INFINITY)));
        let either: Vec<f64> = either.map(|(a, b)| a.min(*b)).collect();
        let at = format!(" at {:.2} s", pair[1].t_s);
        pairs.look(&step, &either, &at, worst);
        before_m = now_m;
    }
}

/// A contact where the posture puts it.
fn touch<'a>(contact: &Closed<'a>, posture: &Posture) -> Touch<'a> {
    let X_WC = posture.X_WB[contact.patch.body] * contact.patch.X_BC.to_homogeneous();
    Touch {
        stated: contact.stated,
        patch: contact.patch,
        face: contact.face,
        vertices_W: touching_W(contact, &X_WC),
        X_WC,
    }
}

/// How far the patch in the air is over the face of a place that it leaves or lands on, m; infinite where it is not near.
fn height_m(contact: &Closed, posture: &Posture) -> f64 {
    let touch = touch(contact, posture);
    let X_WF = touch.face.X_WF.to_homogeneous();
    let radius = touch.patch.point_radius_m().unwrap_or(0.0);
    let height = inverse_point(&X_WF, &column(&touch.X_WC, 3)).z - radius;
    let place = Vector3::from(touch.stated.X_WC.p);
    match (column(&touch.X_WC, 3) - place).norm() < 2.0 * TOLERANCES.motion_touch_m {
        true => height,
        false => f64::INFINITY,
    }
}

/// The patch's vertices in W; of a ball its point that is nearest to the face.
fn touching_W(contact: &Closed, X_WC: &Matrix4<f64>) -> Vec<Vector3<f64>> {
    let normal = column(&contact.face.X_WF.to_homogeneous(), 2);
    let below = normal * -contact.patch.point_radius_m().unwrap_or(0.0);
    let vertices = contact.patch.polygon.iter();
    vertices
        .map(|v| point(X_WC, &Vector3::new(v.x, v.y, 0.0)) + below)
        .collect()
}
