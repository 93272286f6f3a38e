//! Forces: the stated ones carry the robot inside their cones and the joints' torques, and such
//! forces are found again from nothing but the contacts.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use robot_model::ContactPatch;

use crate::balance::{self, Failure, Support};
use crate::findings::{Findings, exceeds};
use crate::polygon;
use crate::posture::{Load, column, inverse_point};
use crate::scene::{Placed, Touch};
use crate::{Check, TOLERANCES};

/// Number of horizontal directions in which the centre of mass is moved.
const DIRECTIONS: usize = 8;

/// Smallest upward part of the normals under balls of which a margin is promised.
const UPWARD_MIN: f64 = 0.71;

/// The parts of friction and torque that the stated forces use.
pub(crate) struct Used {
    pub friction: f64,
    pub torque: f64,
    /// What the stated forces leave of weight and moment, over the weight.
    pub residual: f64,
}

/// Everything about the forces of one stance.
pub(crate) fn check(placed: &Placed, findings: &mut Findings) -> Used {
    for touch in &placed.touches {
        placed.points(touch, findings);
        placed.unloaded(touch, findings);
    }
    let friction = placed.cones(findings);
    let loads = placed.loads();
    let residual = placed.balanced(&loads, findings);
    let torque = placed.torques(&loads, findings);
    placed.found_again(findings);
    Used {
        friction,
        torque,
        residual,
    }
}

/// By how much the patch is shrunk where forces act: the margin of the centre of mass, less on a
/// narrow patch and not at all on a ball, m.
pub(crate) fn shrunk_by(patch: &ContactPatch, com_m: f64) -> f64 {
    if patch.point_radius_m().is_some() {
        return 0.0;
    }
    let half_width_m = polygon::half_width(&patch.polygon);
    let [left_part, left_m] = TOLERANCES.left_of_patch;
    com_m.min(half_width_m - left_m.min(left_part * half_width_m))
}

/// How far inside the patch the outermost of these points lies, m; below zero how far it is from the
/// patch's plane, or from where a ball touches.
pub(crate) fn least_inside(touch: &Touch, points_W: &[[f64; 3]]) -> f64 {
    let ball = touch.patch.point_radius_m().and(touch.vertices_W.first());
    let inside = |p: &[f64; 3]| {
        let p_W = Vector3::from(*p);
        if let Some(touched) = ball {
            return -(p_W - touched).norm();
        }
        let p = inverse_point(&touch.X_WC, &p_W);
        let edge = -polygon::outside(&touch.patch.polygon, &p.xy().into());
        let in_plane = p.z.abs() <= TOLERANCES.closure_m;
        if in_plane { edge } else { edge.min(-p.z.abs()) }
    };
    points_W.iter().map(inside).fold(f64::INFINITY, f64::min)
}

impl Placed<'_> {
    /// Forces smaller than this are rounding, N.
    fn rounding_n(&self) -> f64 {
        TOLERANCES.force * self.posture.weight()
    }

    /// The contacts that bear.
    fn loaded(&self) -> impl Iterator<Item = &Touch<'_>> {
        self.touches.iter().filter(|t| t.stated.loaded)
    }

    /// Forces act in the patch, away from its edge; on a ball where it touches.
    fn points(&self, touch: &Touch, findings: &mut Findings) {
        let least = least_inside(touch, &touch.stated.force_points_W);
        let bound = shrunk_by(touch.patch, self.scene.plan.required.com_m) - TOLERANCES.closure_m;
        let patch = &touch.stated.patch;
        findings.value(self.at, Check::ForcePoint, patch, least, bound);
    }

    /// A contact that is made or broken bears nothing.
    fn unloaded(&self, touch: &Touch, findings: &mut Findings) {
        if touch.stated.loaded {
            return;
        }
        let forces = touch.stated.forces_W.iter();
        let most = forces.map(|f| Vector3::from(*f).norm()).fold(0.0, f64::max);
        let patch = &touch.stated.patch;
        findings.value(self.at, Check::Unloaded, patch, most, self.rounding_n());
    }

    /// Contacts push, inside the round friction cone; what part of the friction they use.
    fn cones(&self, findings: &mut Findings) -> f64 {
        let rounding = self.rounding_n();
        let mut most = 0.0_f64;
        for touch in self.loaded() {
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
            let bound = self.scene.plan.required.friction_use + TOLERANCES.part;
            findings.value(self.at, Check::Unilateral, name, push, -rounding);
            findings.value(self.at, Check::Friction, name, used, bound);
        }
        most
    }

    /// Where each stated force acts and on which body; only loaded contacts bear.
    fn loads(&self) -> Vec<Load> {
        let loads = self.loaded().flat_map(|t| {
            let body = t.patch.body;
            let pairs = t.stated.force_points_W.iter().zip(&t.stated.forces_W);
            pairs.map(move |(p, f)| (body, Vector3::from(*p), Vector3::from(*f)))
        });
        loads.collect()
    }

    /// The stated forces carry the weight and have no moment about the centre of mass.
    fn balanced(&self, loads: &[Load], findings: &mut Findings) -> f64 {
        let weight = self.posture.weight();
        let mut force = Vector3::new(0.0, 0.0, -weight);
        let mut moment = Vector3::zeros();
        for (_, p, f) in loads {
            force += f;
            moment += (p - self.posture.com_W).cross(f);
        }
        let (at, bound) = (self.at, TOLERANCES.balance);
        let (force, moment) = (force.norm() / weight, moment.norm() / weight);
        findings.value(at, Check::BalanceForce, "", force, bound);
        findings.value(at, Check::BalanceMoment, "", moment, bound);
        force.max(moment)
    }

    /// The joint that uses most of its torque, and every one that uses too much.
    fn torques(&self, loads: &[Load], findings: &mut Findings) -> f64 {
        let bound = self.scene.plan.required.torque_use + TOLERANCES.part;
        let bodies = self.posture.robot.bodies.iter().enumerate().skip(1);
        let uses = bodies.map(|(i, body)| {
            let torque = self.posture.holding_torque(i, loads).abs();
            // No effort, no torque; nothing to hold is held by nothing.
            let part = torque / body.effort;
            (if torque == 0.0 { 0.0 } else { part }, body.joint.as_str())
        });
        let uses: Vec<(f64, &str)> = uses.collect();
        let too_much = |part| exceeds(part, bound);
        let most = uses.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let failed = uses.iter().filter(|(part, _)| too_much(*part));
        for (part, joint) in failed.chain(most.filter(|(part, _)| !too_much(*part))) {
            findings.value(self.at, Check::Torque, *joint, *part, bound);
        }
        most.map_or(0.0, |(part, _)| *part)
    }

    /// Forces from scratch: that some exist, and how far the centre of mass may be elsewhere.
    fn found_again(&self, findings: &mut Findings) {
        let (at, com) = (self.at, &self.posture.com_W);
        let required = &self.scene.plan.required;
        let with_friction = |part: f64| -> Vec<Support> {
            let support = |t: &Touch| Support {
                vertices: t.vertices_W.clone(),
                axes: Matrix3::from_columns(&[0, 1, 2].map(|k| column(&t.X_WC, k))),
                friction: part * t.stated.friction,
            };
            self.loaded().map(support).collect()
        };

        // Inside the friction that the plan allows itself.
        let planned = with_friction(required.friction_use);
        match balance::equilibrium(&planned, com, TOLERANCES.cone_edges) {
            Ok(share) => findings.value(at, Check::Equilibrium, "", share, -TOLERANCES.part),
            Err(failure) => findings.flaw(at, Check::Equilibrium, "", failure.to_string()),
        }

        // With all the friction and the whole patches there are.
        let whole = with_friction(1.0);
        let bound = self.promised_reach() - TOLERANCES.distance_m;
        let mut least = (f64::INFINITY, String::new());
        for k in 0..DIRECTIONS {
            let angle = TAU * k as f64 / DIRECTIONS as f64;
            let direction = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let name = format!("toward {:.0}°", angle.to_degrees());
            match balance::reach(&whole, com, TOLERANCES.cone_edges, &direction) {
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
    fn promised_reach(&self) -> f64 {
        let required = &self.scene.plan.required;
        let upward = |t: &Touch| column(&t.face.X_WF.to_homogeneous(), 2).z;
        if self
            .loaded()
            .all(|t| t.patch.point_radius_m().is_some() && upward(t) > UPWARD_MIN)
        {
            return required.com_m;
        }
        let reach = |t: &Touch| {
            let normal = column(&t.face.X_WF.to_homogeneous(), 2);
            let (cos, sin) = (normal.z.abs(), normal.x.hypot(normal.y));
            let lever = (cos + required.friction_use * t.stated.friction * sin).max(1.0);
            shrunk_by(t.patch, required.com_m) / lever
        };
        self.loaded().map(reach).fold(f64::INFINITY, f64::min)
    }
}
