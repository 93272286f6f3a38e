//! Forces: the stated ones carry the robot inside their cones and the joints' torques, and such
//! forces are found again from nothing but the contacts.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use crate::balance::{self, Failure, Support};
use crate::findings::{Findings, exceeds};
use crate::polygon;
use crate::posture::{Load, Posture, column, inverse_point};
use crate::scene::{Scene, Touch};
use crate::{Check, Options};

/// Number of horizontal directions in which the centre of mass is moved.
const DIRECTIONS: usize = 8;

/// Smallest upward part of the normals under balls of which a margin is promised.
const UPWARD_MIN: f64 = 0.71;

/// The parts of friction and torque that the stated forces use.
pub(crate) struct Used {
    pub friction: f64,
    pub torque: f64,
}

/// Everything about the forces of one stance.
pub(crate) fn check(
    scene: &Scene,
    index: usize,
    posture: &Posture,
    touches: &[Touch],
    findings: &mut Findings,
) -> Used {
    let weight = posture.weight();
    for touch in touches {
        points(scene, index, touch, findings);
        unloaded(scene, index, touch, weight, findings);
    }
    let friction = cones(scene, index, touches, weight, findings);
    balanced(scene, index, posture, touches, weight, findings);
    let torque = torques(scene, index, posture, touches, findings);
    found_again(scene, index, posture, touches, findings);
    Used { friction, torque }
}

/// By how much the patch is shrunk where forces act: the margin of the centre of mass, less on a
/// narrow patch and not at all on a ball, m.
fn shrunk_by(touch: &Touch, com_m: f64, options: &Options) -> f64 {
    if touch.patch.point_radius_m().is_some() {
        return 0.0;
    }
    let polygon: Vec<[f64; 2]> = touch.patch.polygon.iter().map(|v| [v.x, v.y]).collect();
    let half_width = -polygon::outside(&polygon, polygon::centroid(&polygon));
    com_m.min(options.shrink * half_width)
}

/// Forces act in the patch, away from its edge; on a ball where it touches.
fn points(scene: &Scene, index: usize, touch: &Touch, findings: &mut Findings) {
    let options = scene.options;
    let polygon: Vec<[f64; 2]> = touch.patch.polygon.iter().map(|v| [v.x, v.y]).collect();
    let ball = touch.patch.point_radius_m().and(touch.vertices_W.first());
    let off = |p: &[f64; 3]| ball.map(|touched| (Vector3::from(*p) - touched).norm());
    // Distance from the edge, or below zero the distance from the patch's plane.
    let inside = |p: &[f64; 3]| {
        if let Some(off) = off(p) {
            return -off;
        }
        let p = inverse_point(&touch.X_WC, &Vector3::from(*p));
        let edge = -polygon::outside(&polygon, [p.x, p.y]);
        let in_plane = p.z.abs() <= options.closure_m;
        if in_plane { edge } else { edge.min(-p.z.abs()) }
    };
    let points = touch.stated.force_points_W.iter();
    let least = points.map(inside).fold(f64::INFINITY, f64::min);
    let bound = shrunk_by(touch, scene.plan.required.com_m, options) - options.closure_m;
    let (at, patch) = (Some(index), &touch.stated.patch);
    findings.value(at, Check::ForcePoint, patch, least, bound);
}

/// A contact that is made or broken bears nothing.
fn unloaded(scene: &Scene, index: usize, touch: &Touch, weight: f64, findings: &mut Findings) {
    if touch.stated.loaded {
        return;
    }
    let forces = touch.stated.forces_W.iter();
    let most = forces.map(|f| Vector3::from(*f).norm()).fold(0.0, f64::max);
    let bound = scene.options.force * weight;
    let (at, patch) = (Some(index), &touch.stated.patch);
    findings.value(at, Check::Unloaded, patch, most, bound);
}

/// Contacts push, inside the round friction cone; what part of the friction they use.
fn cones(
    scene: &Scene,
    index: usize,
    touches: &[Touch],
    weight: f64,
    findings: &mut Findings,
) -> f64 {
    let rounding = scene.options.force * weight;
    let mut most = 0.0_f64;
    for touch in touches.iter().filter(|t| t.stated.loaded) {
        let normal = column(&touch.face.X_WF.to_homogeneous(), 2);
        let mut push = f64::INFINITY;
        let mut used = 0.0_f64;
        for f in touch.stated.forces_W.iter().map(|f| Vector3::from(*f)) {
            let along = f.dot(&normal);
            let across = (f - normal * along).norm();
            push = push.min(along);
            // A force that pulls is the other check's.
            if along >= -rounding && across > rounding {
                let part = (across - rounding) / (touch.stated.friction * along.max(0.0));
                used = used.max(part);
            }
        }
        most = most.max(used);
        let name = &touch.stated.patch;
        let bound = scene.plan.required.friction_use + scene.options.part;
        findings.value(Some(index), Check::Unilateral, name, push, -rounding);
        findings.value(Some(index), Check::Friction, name, used, bound);
    }
    most
}

/// Where each stated force acts and on which body; only loaded contacts bear.
fn loads(touches: &[Touch]) -> Vec<Load> {
    let loaded = touches.iter().filter(|t| t.stated.loaded);
    let loads = loaded.flat_map(|t| {
        let body = t.patch.body;
        let pairs = t.stated.force_points_W.iter().zip(&t.stated.forces_W);
        pairs.map(move |(p, f)| (body, Vector3::from(*p), Vector3::from(*f)))
    });
    loads.collect()
}

/// The stated forces carry the weight and have no moment about the centre of mass.
fn balanced(
    scene: &Scene,
    index: usize,
    posture: &Posture,
    touches: &[Touch],
    weight: f64,
    findings: &mut Findings,
) {
    let mut force = Vector3::new(0.0, 0.0, -weight);
    let mut moment = Vector3::zeros();
    for (_, p, f) in loads(touches) {
        force += f;
        moment += (p - posture.com_W).cross(&f);
    }
    let (at, bound) = (Some(index), scene.options.balance);
    let (force, moment) = (force.norm() / weight, moment.norm() / weight);
    findings.value(at, Check::BalanceForce, "", force, bound);
    findings.value(at, Check::BalanceMoment, "", moment, bound);
}

/// The joint that uses most of its torque, and every one that uses too much.
fn torques(
    scene: &Scene,
    index: usize,
    posture: &Posture,
    touches: &[Touch],
    findings: &mut Findings,
) -> f64 {
    let loads = loads(touches);
    let bound = scene.plan.required.torque_use + scene.options.part;
    let bodies = posture.robot.bodies.iter().enumerate().skip(1);
    let uses = bodies.map(|(i, body)| {
        let torque = posture.holding_torque(i, &loads).abs();
        // No effort, no torque; nothing to hold is held by nothing.
        let part = torque / body.effort;
        (if torque == 0.0 { 0.0 } else { part }, body.joint.as_str())
    });
    let uses: Vec<(f64, &str)> = uses.collect();
    let too_much = |part| exceeds(part, bound);
    let most = uses.iter().max_by(|a, b| a.0.total_cmp(&b.0));
    let failed = uses.iter().filter(|(part, _)| too_much(*part));
    for (part, joint) in failed.chain(most.filter(|(part, _)| !too_much(*part))) {
        findings.value(Some(index), Check::Torque, *joint, *part, bound);
    }
    most.map_or(0.0, |(part, _)| *part)
}

/// Forces from scratch: that some exist, and how far the centre of mass may be elsewhere.
fn found_again(
    scene: &Scene,
    index: usize,
    posture: &Posture,
    touches: &[Touch],
    findings: &mut Findings,
) {
    let (at, options) = (Some(index), scene.options);
    let required = &scene.plan.required;
    let with_friction = |part: f64| -> Vec<Support> {
        let loaded = touches.iter().filter(|t| t.stated.loaded);
        let support = |t: &Touch| Support {
            vertices: t.vertices_W.clone(),
            axes: Matrix3::from_columns(&[0, 1, 2].map(|k| column(&t.X_WC, k))),
            friction: part * t.stated.friction,
        };
        loaded.map(support).collect()
    };

    // Inside the friction that the plan allows itself.
    let planned = with_friction(required.friction_use);
    match balance::equilibrium(&planned, &posture.com_W, options.cone_edges) {
        Ok(share) => findings.value(at, Check::Equilibrium, "", share, -options.part),
        Err(failure) => findings.flaw(at, Check::Equilibrium, "", failure.to_string()),
    }

    // With all the friction and the whole patches there are.
    let whole = with_friction(1.0);
    let bound = promised_reach(scene, touches) - options.distance_m;
    let mut least = (f64::INFINITY, String::new());
    for k in 0..DIRECTIONS {
        let angle = TAU * k as f64 / DIRECTIONS as f64;
        let direction = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let name = format!("toward {:.0}°", angle.to_degrees());
        match balance::reach(&whole, &posture.com_W, options.cone_edges, &direction) {
            Ok(reach) if reach < least.0 => least = (reach, name),
            Ok(_) => {}
            // Not even where it is: not held at all.
            Err(Failure::None) => least = (-1.0, name),
            Err(failure) => {
                findings.flaw(at, Check::ComMargin, name, failure.to_string());
                return;
            }
        }
    }
    findings.value(at, Check::ComMargin, least.1, least.0, bound);
}

/// How far the centre of mass may move because the forces act away from the patches' edges, m.
///
/// Moved by d, the same forces balance again when the point of each moves by d − (n·d)/(n·f) f,
/// which stays in the patch's plane and is at most (cos θ + μ' sin θ)·|d| long for a plane of tilt
/// θ and a force in the cone of μ' (and |d| across the slope).
///
/// On balls alone there is nothing to shrink: the whole margin is promised, but for steep faces.
fn promised_reach(scene: &Scene, touches: &[Touch]) -> f64 {
    let required = &scene.plan.required;
    let mut loaded = touches.iter().filter(|t| t.stated.loaded);
    let upward = |t: &Touch| column(&t.face.X_WF.to_homogeneous(), 2).z;
    if loaded.all(|t| t.patch.point_radius_m().is_some() && upward(t) > UPWARD_MIN) {
        return required.com_m;
    }
    let reach = |t: &Touch| {
        let normal = column(&t.face.X_WF.to_homogeneous(), 2);
        let (cos, sin) = (normal.z.abs(), normal.x.hypot(normal.y));
        let lever = (cos + required.friction_use * t.stated.friction * sin).max(1.0);
        shrunk_by(t, required.com_m, scene.options) / lever
    };
    let loaded = touches.iter().filter(|t| t.stated.loaded);
    loaded.map(reach).fold(f64::INFINITY, f64::min)
}
