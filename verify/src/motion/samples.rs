//! The samples of one phase.

use std::iter::repeat;

use nalgebra::{Matrix4, Vector3};
use plan::{Contact, Motion, Phase};
use robot_model::ContactPatch;
use surfaces::Face;

use crate::Check;
use crate::clearance::{Bounds, Pairs};
use crate::extremes::Extremes;
use crate::forces::{least_inside, shrunk_by};
use crate::motion::dynamics::exerted;
use crate::posture::{Load, Posture, column, inverse_point, point, pose};
use crate::scene::{Scene, Touch};
use crate::step::{Moment, Step, bends_m, between};

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
        worst.add(Check::Com, com, scene.options.com_m, || at("motion"));
        joints(scene, motion, i, &mut worst);
        if i > first {
            rates(scene, motion, i, &mut worst);
        }
        if i >= first + JUMP_STEPS {
            jumps(scene, motion, i, &mut worst);
        }
        if i == first {
            points(scene, motion, &closed, &posture, &mut worst);
        }
        contacts(scene, phase, &closed, &posture, sample.t_s, &mut worst);
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

/// Joints are inside their limits, and within their speeds and accelerations.
fn joints(scene: &Scene, motion: &Motion, i: usize, worst: &mut Extremes) {
    let sample = &motion.samples[i];
    let limits = &motion.limits;
    let bodies = scene.robot.bodies.iter().enumerate().skip(1);
    for (b, body) in bodies {
        let q = sample.q[6 + b];
        let room = (q - body.lower).min(body.upper - q);
        let at = || format!("{} at {:.2} s", body.joint, sample.t_s);
        let kept = body.kept_margin(scene.plan.required.joint_rad);
        worst.add(
            Check::JointLimit,
            room,
            kept - scene.options.motion_joint_rad,
            at,
        );
        if body.velocity.is_finite() && body.velocity > 0.0 {
            let speed = sample.v[5 + b].abs() / body.velocity;
            let bound = limits.joint_speed_use + scene.options.motion_part;
            worst.add(Check::MotionSpeed, speed, bound, at);
        }
        let bound = limits.joint_acceleration_rad_s2 * (1.0 + scene.options.motion_part);
        worst.add(Check::MotionAcceleration, sample.a[5 + b].abs(), bound, at);
    }
    let quaternion: f64 = sample.q[3..7].iter().map(|x| x * x).sum();
    let off = (quaternion.sqrt() - 1.0).abs();
    worst.add(Check::Quaternion, off, scene.options.quaternion, || {
        format!("motion at {:.2} s", sample.t_s)
    });
}

/// Stated velocities are those of the samples:
///
///   Δq = h (v + v')/2 − h² (a' − a)/12      over the time h between two samples
fn rates(scene: &Scene, motion: &Motion, i: usize, worst: &mut Extremes) {
    let (before, now, h) = (&motion.samples[i - 1], &motion.samples[i], motion.dt_s);
    let turn = rotation_vector(&before.q[3..7], &now.q[3..7]);
    let most = scene.options.motion_rate * motion.limits.joint_acceleration_rad_s2 * h;
    for k in 0..now.v.len() {
        let moved = match k {
            0..3 => now.q[k] - before.q[k],
            3..6 => turn[k - 3],
            _ => now.q[k + 1] - before.q[k + 1],
        };
        let bend = h * (now.a[k] - before.a[k]) / 12.0;
        let off = moved / h - 0.5 * (before.v[k] + now.v[k]) + bend;
        worst.add(Check::MotionRate, off.abs(), most, || {
            format!("motion at {:.2} s", now.t_s)
        });
    }
}

/// Samples over which accelerations are summed up: what they do between two of them is not known.
const JUMP_STEPS: usize = 4;

/// Stated accelerations are those of the velocities:
///
///   Δv = h Σ (a + a')/2      over some steps of the time h
fn jumps(scene: &Scene, motion: &Motion, i: usize, worst: &mut Extremes) {
    let steps = &motion.samples[i - JUMP_STEPS..=i];
    let most = scene.options.motion_jump * motion.limits.joint_acceleration_rad_s2;
    for k in 0..steps[0].v.len() {
        let means = steps
            .windows(2)
            .map(|pair| 0.5 * (pair[0].a[k] + pair[1].a[k]));
        let change = (steps[JUMP_STEPS].v[k] - steps[0].v[k]) / motion.dt_s;
        let off = (change - means.sum::<f64>()) / JUMP_STEPS as f64;
        worst.add(Check::MotionJump, off.abs(), most, || {
            format!("motion at {:.2} s", motion.samples[i].t_s)
        });
    }
}

/// The rotation from one unit quaternion to the next in W, where it is small: 2 (q' q*), the vector part.
fn rotation_vector(from: &[f64], to: &[f64]) -> Vector3<f64> {
    let part = |q: &[f64]| (Vector3::new(q[0], q[1], q[2]), q[3]);
    let ((a, s), (b, t)) = (part(from), part(to));
    let sign = (a.dot(&b) + s * t).signum();
    (b * s - a * t + a.cross(&b)) * (2.0 * sign)
}

/// Forces act inside the patches, away from their edges.
fn points(
    scene: &Scene,
    motion: &Motion,
    closed: &[Closed],
    posture: &Posture,
    worst: &mut Extremes,
) {
    let options = scene.options;
    for contact in closed {
        let touch = touch(contact, posture);
        let least = least_inside(&touch, contact.points_W, options);
        let kept = 1.0 - motion.limits.margin_use;
        let shrunk = shrunk_by(&touch, scene.plan.required.com_m, options) * kept;
        worst.add(Check::ForcePoint, least, shrunk - options.closure_m, || {
            format!("{} in motion", contact.patch.name)
        });
    }
}

/// Closed contacts stay where they were made.
fn contacts(
    scene: &Scene,
    phase: &Phase,
    closed: &[Closed],
    posture: &Posture,
    t_s: f64,
    worst: &mut Extremes,
) {
    for (contact, recorded) in closed.iter().zip(&phase.contacts) {
        let X_WC = posture.X_WB[contact.patch.body] * contact.patch.X_BC.to_homogeneous();
        for X in [&recorded.X_WC, &contact.stated.X_WC] {
            let stated = pose(&X.p, &X.quat_xyzw);
            let vertices = contact.patch.polygon.iter();
            let vertices = vertices.map(|v| Vector3::new(v.x, v.y, 0.0));
            let apart = vertices.map(|v| (point(&stated, &v) - point(&X_WC, &v)).norm());
            let off = apart.fold(0.0, f64::max);
            worst.add(Check::Kept, off, scene.options.closure_m, || {
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
    let (limits, options) = (&motion.limits, scene.options);
    let weight = posture.weight();
    let rounding = options.force * weight;
    let mut loads: Vec<Load> = Vec::new();
    for (contact, forces) in closed.iter().zip(&sample.forces_W) {
        let name = || format!("{} at {:.2} s", contact.patch.name, sample.t_s);
        let points = contact.points_W;
        if points.len() != forces.len() {
            worst.add(Check::BalanceForce, f64::NAN, 0.0, name);
            return;
        }
        let normal = column(&contact.face.X_WF.to_homogeneous(), 2);
        for (p, f) in points.iter().zip(forces) {
            let f = Vector3::from(*f);
            let along = f.dot(&normal);
            let across = ((f - normal * along).norm() - rounding).max(0.0);
            worst.add(Check::Unilateral, along, -rounding, name);
            if along > rounding {
                let used = across / (contact.stated.friction * along);
                let bound = limits.friction_use + options.motion_part;
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
    worst.add(Check::BalanceForce, force, options.balance, at);
    worst.add(Check::BalanceMoment, moment, options.balance, at);
    let bodies = scene.robot.bodies.iter().skip(1);
    for ((body, tau), stated) in bodies.zip(left.tau).zip(&sample.tau) {
        let at = || format!("{} at {:.2} s", body.joint, sample.t_s);
        let off = (tau - stated).abs() / weight;
        worst.add(Check::MotionTorque, off, options.balance, at);
        if body.effort > 0.0 && body.effort.is_finite() {
            let bound = limits.torque_use + options.motion_part;
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
    let touching: Vec<(usize, &Face)> = touching.map(|c| (c.patch.body, c.face)).collect();
    let all: Vec<&Moment> = moments.iter().collect();
    let mut pairs = Pairs::new(scene, &touching, Bounds::of_motion(scene), &all);
    let near = |posture: &Posture| {
        let near = swung.iter().map(|contact| is_near(scene, contact, posture));
        closed
            .iter()
            .map(|_| true)
            .chain(near)
            .collect::<Vec<bool>>()
    };
    let mut touched = Vec::new();
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
        let touches = near(posture);
        let either = touches.iter().zip(touched.iter().chain(repeat(&false)));
        let either: Vec<bool> = either.map(|(a, b)| *a || *b).collect();
        let at = format!(" at {:.2} s", pair[1].t_s);
        pairs.look(&step, &either, &at, worst);
        touched = touches;
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

/// Whether the patch in the air is near to a place that it leaves or lands on.
fn is_near(scene: &Scene, contact: &Closed, posture: &Posture) -> bool {
    let touch = touch(contact, posture);
    let X_WF = touch.face.X_WF.to_homogeneous();
    let radius = touch.patch.point_radius_m().unwrap_or(0.0);
    let height = inverse_point(&X_WF, &column(&touch.X_WC, 3)).z - radius;
    let place = Vector3::from(touch.stated.X_WC.p);
    height < scene.options.motion_touch_m
        && (column(&touch.X_WC, 3) - place).norm() < 2.0 * scene.options.motion_touch_m
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
