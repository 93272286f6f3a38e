//! The least value of what the multipliers add up to: see [`plan::Multipliers`].
//!
//!   L = const + Σ_b ⟨G_b, R_b⟩ + γ_0·(p_0 − o) + Σ g·f,     ⟨A, B⟩ = tr AᵀB
//!
//! A force f is in its friction cone, its g is to be in the dual of that.

use nalgebra::{Point2, Vector3};
use plan::{Multipliers, PlaceFreedom};
use robot_model::{GRAVITY_M_S2, JointKind};

use super::turns::Turns;
use super::{Claim, Place};
use crate::forces::shrunk_by;
use crate::polygon;
use crate::posture::{column, point};

/// No point bears more than so many times the weight.
const FORCE_MAX: f64 = 100.0;
/// Largest multiplier.
const MULTIPLIER_MAX: f64 = 1e6;
/// Smallest upward part of the normals under balls of which a margin is asked.
const UPWARD_MIN: f64 = 0.71;
/// More of the weight than two balls bear.
const LOAD_MAX: f64 = 2.0;

impl Claim<'_> {
    /// A lower bound of L less what torques may exert.
    ///
    /// # Errors
    /// Multipliers of what is not known.
    pub(super) fn least(&self, given: &Multipliers) -> Result<f64, String> {
        let bodies = &self.robot.bodies;
        let joints = bodies.len() - 1;
        let own = [given.force, given.moment, given.about];
        let mut all = own.iter().chain(&given.places).flatten();
        let turns = given.turns.iter().flatten().flatten();
        let sane = |x: &f64| x.abs() <= MULTIPLIER_MAX;
        let sane = all.all(sane) && turns.chain(&given.torques).all(sane);
        let counts = [given.places.len(), given.torques.len(), given.turns.len()];
        if !sane || counts != [self.places.len(), joints, joints] {
            return Err("there are not as many numbers as there must be".to_owned());
        }
        let [force, moment, about] = own.map(Vector3::from);
        let (mut turns, mut sum) = (Turns::new(self.robot, self.required.joint_rad), -force.z);

        // Places of contacts, and the centre of mass of −μ·((c − o) × ẑ).
        for (place, by) in self.places.iter().zip(&given.places) {
            let by = Vector3::from(*by);
            if place.stated.freedom == PlaceFreedom::Elsewhere && by != Vector3::zeros() {
                return Err(format!("{} may be elsewhere", place.stated.patch));
            }
            sum -= by.dot(&(place.p() - about));
            turns.add(place.patch.body, &by, &place.patch.X_BC.translation.vector);
        }
        let by_com = Vector3::new(moment.y, -moment.x, 0.0);
        for (b, body) in bodies.iter().enumerate() {
            let part = body.mass_kg / self.robot.mass_kg;
            turns.add(b, &(by_com * part), &body.com_B);
            turns.known[b] = self.put(b).map(|X| X.fixed_view::<3, 3>(0, 0).into_owned());
        }

        // Forces, and torques of joints next to bodies that are put.
        let wrench = |place: &Place, p: &Vector3<f64>| -> Vector3<f64> {
            let levers = (1..=joints).filter(|&b| given.torques[b - 1] != 0.0);
            let levers = levers.filter(|&b| self.robot.supports(b, place.patch.body));
            let turned = levers.filter_map(|b| {
                let (axis, o) = self.axis(b)?;
                Some(axis.cross(&(p - o)) * given.torques[b - 1])
            });
            force + moment.cross(&(p - about)) + turned.sum::<Vector3<f64>>()
        };
        let loaded = || self.places.iter().filter(|place| place.stated.loaded);
        let by_forces = force != Vector3::zeros() || moment != Vector3::zeros();
        if by_forces || given.torques.iter().any(|t| *t != 0.0) {
            if let Some(free) = loaded().find(|place| !place.is_settled()) {
                return Err(format!("{} may bear elsewhere", free.stated.patch));
            }
            let lift = self.least_load();
            for place in loaded() {
                let mu = place.stated.friction * self.required.friction_use;
                for p in self.bearing(place) {
                    let by = wrench(place, &p);
                    let local = place.R().tr_mul(&by);
                    let least = local.z - mu * local.x.hypot(local.y);
                    sum += FORCE_MAX * least.min(0.0) + lift * by.z;
                }
            }
        }
        for (b, by) in (1..).zip(&given.torques).filter(|(_, by)| **by != 0.0) {
            let limit_m = self.torque_m(b).ok_or_else(|| {
                let joint = &bodies[b].joint;
                format!("the torque of {joint} is not known from the contacts")
            })?;
            sum -= by.abs() * limit_m;
        }

        // Rotations, and where the base is.
        let (turned, by_base) = turns.least(&given.turns);
        let lengths = bodies.iter().map(length_m);
        let reach_m = self.places.iter().filter_map(|place| {
            let to_body = place.patch.X_BC.translation.vector.norm();
            let is_placed = place.stated.freedom != PlaceFreedom::Elsewhere;
            is_placed.then(|| (place.p() - about).norm() + to_body)
        });
        let reach_m = reach_m.fold(f64::INFINITY, f64::min) + lengths.sum::<f64>();
        sum += turned;
        if by_base != Vector3::zeros() {
            sum -= by_base.norm() * reach_m;
        }
        // Larger multipliers prove no more.
        let sizes = given.places.iter().map(|by| Vector3::from(*by).norm());
        let size = sizes.sum::<f64>() + force.norm() + moment.norm();
        Ok(sum / size.max(1.0))
    }

    /// Axis and origin in W of the joint of a body that a contact puts.
    fn axis(&self, b: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let body = &self.robot.bodies[b];
        let X_WB = self.put(b).filter(|_| body.kind == JointKind::Revolute)?;
        Some((X_WB.fixed_view::<3, 3>(0, 0) * body.axis, column(&X_WB, 3)))
    }

    /// The moment of contact forces that the joint of a body that is put bears at most, over the weight, m: its
    /// limit, and what the weights beyond may exert wherever they are.
    fn torque_m(&self, b: usize) -> Option<f64> {
        self.axis(b)?;
        let bodies = &self.robot.bodies;
        let effort = bodies[b].effort * self.required.torque_use;
        let beyond = (b..bodies.len()).filter(|&i| self.robot.supports(b, i));
        let weights = beyond.map(|i| {
            let (mut far_m, mut at) = (bodies[i].com_B.norm(), i);
            while let Some(parent) = bodies[at].parent.filter(|_| at != b) {
                far_m += length_m(&bodies[at]);
                at = parent;
            }
            bodies[i].mass_kg * far_m / self.robot.mass_kg
        });
        let limit_m = effort / (self.robot.mass_kg * GRAVITY_M_S2) + weights.sum::<f64>();
        (effort > 0.0 && limit_m.is_finite()).then_some(limit_m)
    }

    /// Points in W that hold all at which a contact bears between them.
    fn bearing(&self, place: &Place) -> Vec<Vector3<f64>> {
        if let Some(radius_m) = place.patch.point_radius_m() {
            let normal = column(&place.X_WC, 2);
            let touched =
                |v: &Point2<f64>| point(&place.X_WC, &v.coords.push(0.0)) - normal * radius_m;
            return place.patch.polygon.iter().map(touched).collect();
        }
        let outline = &place.patch.polygon;
        let inset_m = shrunk_by(place.patch, self.required.com_m);
        let shrunk = polygon::shrunk(outline, inset_m);
        let held = if shrunk.is_empty() { outline } else { &shrunk };
        let in_W = |v: &Point2<f64>| point(&place.X_WC, &v.coords.push(0.0));
        held.iter().map(in_W).collect()
    }

    /// The part of the weight that each ball bears at least where balls alone bear: with D the least sum of their
    /// distances from an edge of their hull, the margin of the centre of mass over D.
    fn least_load(&self) -> f64 {
        let loaded = || self.places.iter().filter(|place| place.stated.loaded);
        let is_ball = |p: &Place| p.patch.point_radius_m().is_some() && p.X_WC[(2, 2)] > UPWARD_MIN;
        if self.required.com_m <= 0.0 || !loaded().all(is_ball) {
            return 0.0;
        }
        let points: Vec<_> = loaded().flat_map(|p| self.bearing(p)).collect();
        let mut width_m = f64::INFINITY;
        for a in &points {
            for b in &points {
                let along = (b - a).xy();
                let length = along.norm();
                let beside = || points.iter().map(|p| along.perp(&(p - a).xy()) / length);
                if length > 1e-9 && beside().all(|d| d >= -1e-9) {
                    width_m = beside().sum::<f64>().min(width_m);
                }
            }
        }
        // One ball and balls in a line have no width, and no margin.
        let width_m = if width_m.is_finite() { width_m } else { 0.0 };
        (self.required.com_m / width_m).min(LOAD_MAX)
    }
}

/// How far the frame of a body is from its parent's at most, m.
pub(super) fn length_m(body: &robot_model::Body) -> f64 {
    let slide = match body.kind {
        JointKind::Prismatic => body.lower.abs().max(body.upper.abs()),
        _ => 0.0,
    };
    body.X_PJ.translation.vector.norm() + slide
}
