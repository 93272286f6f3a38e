//! How the contacts share what accelerates the robot.
//!
//! Forces of standing still carry the weight; what is needed beyond them is shared by the points in
//! proportion to what each bears at rest:
//!
//!   f = f₀ + W Gᵀ (G W Gᵀ)⁻¹ w,   W = diag(f₀·n),   w: force and moment about the centre of mass
//!
//! so that a contact that bears nothing takes nothing, and forces are continuous where contacts change.
//! The points are those of the patches shrunk by less than at rest: the zero-moment point may use a part
//! of the margin of the centre of mass.
#![allow(non_snake_case)]

use std::ops::AddAssign;

use nalgebra::{Cholesky, Matrix3, Matrix6, Point2, Vector3, Vector6};
use posture::{Contact, patch_inset_m};

use crate::problem::MotionContext;

/// One point at which a force acts.
pub(crate) struct ForcePoint {
    /// Index of the contact.
    pub contact: usize,
    /// Where, in W, m.
    pub p_W: Vector3<f64>,
}

/// The points of closed contacts, and how they take over the forces of the postures' points.
pub(crate) struct LoadShares {
    pub points: Vec<ForcePoint>,
    /// For each contact, for each of the postures' points: the parts of each own point.
    parts: Vec<Vec<Vec<f64>>>,
    normals: Vec<Vector3<f64>>,
}

impl LoadShares {
    pub fn new(context: &MotionContext, closed: &[Contact]) -> Self {
        let mut shares = Self {
            points: Vec::new(),
            parts: Vec::new(),
            normals: closed.iter().map(Contact::normal_W).collect(),
        };
        for (k, contact) in closed.iter().enumerate() {
            let patch = &context.robot.patches[contact.patch];
            let touched = patch.touched_W(&contact.X_WC);
            let still = posture::force_points(&patch.polygon, context.posture.com_margin_m);
            let own = points(&patch.polygon, context);
            let parts = still.iter().map(|p| coordinates(&own, p));
            shares.parts.push(parts.collect());
            let place = |p: &Point2<f64>| ForcePoint {
                contact: k,
                p_W: contact.X_WC.rotation * p.coords.push(0.0) + touched,
            };
            shares.points.extend(own.iter().map(place));
        }
        shares
    }

    /// The forces of a posture's points as forces at the own ones, N.
    pub fn at_rest(&self, forces_W: &[Vec<Vector3<f64>>]) -> Vec<Vector3<f64>> {
        let mut own = Vec::with_capacity(self.points.len());
        for (parts, forces) in self.parts.iter().zip(forces_W) {
            let begin = own.len();
            let count = parts.first().map_or(0, Vec::len);
            own.resize(begin + count, Vector3::zeros());
            for (parts, force) in parts.iter().zip(forces) {
                for (sum, part) in own[begin..].iter_mut().zip(parts) {
                    *sum += force * *part;
                }
            }
        }
        own
    }

    /// Force and moment about `com_W` of forces at the points.
    pub fn resultant(&self, com_W: &Vector3<f64>, forces_W: &[Vector3<f64>]) -> Vector6<f64> {
        let each = self.points.iter().zip(forces_W);
        each.fold(Vector6::zeros(), |sum, (p, f)| {
            let moment = (p.p_W - com_W).cross(f);
            sum + Vector6::new(f.x, f.y, f.z, moment.x, moment.y, moment.z)
        })
    }

    /// How much of what is needed beyond rest each point takes, by how hard it presses at rest.
    pub fn weights(&self, loads: &[f64]) -> Vec<f64> {
        let mut weights = loads.to_vec();
        let mut sums = vec![0.0; self.normals.len()];
        for (load, p) in weights.iter().zip(&self.points) {
            sums[p.contact] += load;
        }
        for (load, p) in weights.iter_mut().zip(&self.points) {
            *load *= sums[p.contact];
        }
        weights
    }

    /// Forces at the points that have each of these resultants: force and moment about `com_W`.
    pub fn shared<const N: usize>(
        &self,
        weights: &[f64],
        com_W: &Vector3<f64>,
        resultants: [Vector6<f64>; N],
    ) -> [Vec<Vector3<f64>>; N] {
        let most = weights.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(*b));
        let each = self.points.iter().zip(weights);
        let each: Vec<_> = each.map(|(p, w)| (p.p_W - com_W, w / most)).collect();
        let mut square = Matrix6::zeros();
        for (r, w) in &each {
            let R = r.cross_matrix();
            let turned = R * *w;
            let [mut upper, mut lower] = [Matrix3::identity() * *w, turned];
            square.fixed_view_mut::<3, 3>(0, 0).add_assign(&upper);
            square.fixed_view_mut::<3, 3>(3, 0).add_assign(&lower);
            lower.neg_mut();
            square.fixed_view_mut::<3, 3>(0, 3).add_assign(&lower);
            upper = R * lower;
            square.fixed_view_mut::<3, 3>(3, 3).add_assign(&upper);
        }
        // Points on one line bear no moment about it; nothing is asked of them there.
        let factor = Cholesky::new(square);
        let inverse = match factor {
            Some(_) => None,
            None => square.pseudo_inverse(1e-9).ok(),
        };
        resultants.map(|resultant| {
            let y = match (&factor, inverse) {
                (Some(factor), _) => factor.solve(&resultant),
                (None, Some(inverse)) => inverse * resultant,
                (None, None) => Vector6::zeros(),
            };
            let (force, moment) = (y.fixed_rows::<3>(0), y.fixed_rows::<3>(3));
            each.iter()
                .map(|(r, w)| (force + moment.cross(r)) * *w)
                .collect()
        })
    }

    /// Forces with this resultant whose loads are near to those at rest in proportion, so that none of
    /// them changes its sign: the shares of the whole, again and again by the loads that come of it.
    pub fn leaning(
        &self,
        at_rest: &[Vector3<f64>],
        com_W: &Vector3<f64>,
        resultant: Vector6<f64>,
    ) -> Vec<Vector3<f64>> {
        let mut loads = self.loads(at_rest);
        for _ in 0..LEANINGS {
            let [forces] = self.shared(&loads, com_W, [resultant]);
            let next = self.loads(&forces);
            for (load, next) in loads.iter_mut().zip(next) {
                *load = next.max(FALL_MAX * *load);
            }
        }
        let [forces] = self.shared(&loads, com_W, [resultant]);
        forces
    }

    /// How hard each point presses, N; nothing where it pulls.
    pub fn loads(&self, forces_W: &[Vector3<f64>]) -> Vec<f64> {
        let loads = forces_W.iter().zip(&self.points);
        let loads = loads.map(|(f, p)| f.dot(&self.normals[p.contact]).max(0.0));
        loads.collect()
    }
}

/// How often loads are sought that lean to a side, and the part to which one falls at most each time.
const LEANINGS: usize = 5;
const FALL_MAX: f64 = 0.2;

/// The points of a patch at which the forces of a motion act, in C, m.
fn points(polygon: &[Point2<f64>], context: &MotionContext) -> Vec<Point2<f64>> {
    let margin = patch_inset_m(polygon, context.posture.com_margin_m);
    posture::force_points(polygon, margin * (1.0 - context.config.margin_use))
}

/// The parts of a convex polygon's vertices whose mean is a point inside of it (Wachspress).
fn coordinates(polygon: &[Point2<f64>], p: &Point2<f64>) -> Vec<f64> {
    let n = polygon.len();
    if n < 3 {
        return vec![1.0 / n as f64; n];
    }
    let area = |a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>| (b - a).perp(&(c - a));
    let weight = |j: usize| {
        let (before, at, after) = (
            &polygon[(j + n - 1) % n],
            &polygon[j],
            &polygon[(j + 1) % n],
        );
        let beside = area(p, before, at).max(AREA_MIN) * area(p, at, after).max(AREA_MIN);
        area(before, at, after) / beside
    };
    let weights: Vec<f64> = (0..n).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Areas beside a point on an edge are taken as no smaller, m².
const AREA_MIN: f64 = 1e-10;
