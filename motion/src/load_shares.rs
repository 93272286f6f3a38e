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

use nalgebra::{Matrix6, Point2, Vector3, Vector6};
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

    /// Forces at the points that have each of these resultants: force and moment about `com_W`.
    pub fn shared<const N: usize>(
        &self,
        at_rest: &[Vector3<f64>],
        com_W: &Vector3<f64>,
        resultants: [Vector6<f64>; N],
    ) -> [Vec<Vector3<f64>>; N] {
        let loads = at_rest.iter().zip(&self.points);
        let loads = loads.map(|(f, p)| f.dot(&self.normals[p.contact]).max(0.0));
        let mut loads: Vec<f64> = loads.collect();
        let mut sums = vec![0.0; self.normals.len()];
        for (load, p) in loads.iter().zip(&self.points) {
            sums[p.contact] += load;
        }
        for (load, p) in loads.iter_mut().zip(&self.points) {
            *load *= sums[p.contact];
        }
        let most = loads.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(*b));
        let arms: Vec<Vector3<f64>> = self.points.iter().map(|p| p.p_W - com_W).collect();
        let mut square = Matrix6::zeros();
        for (load, r) in loads.iter().zip(&arms) {
            let (w, R) = (load / most, r.cross_matrix());
            let turned = R * w;
            for i in 0..3 {
                square[(i, i)] += w;
            }
            let mut low = square.fixed_view_mut::<3, 3>(3, 0);
            low += turned;
            let mut right = square.fixed_view_mut::<3, 3>(0, 3);
            right -= turned;
            let mut corner = square.fixed_view_mut::<3, 3>(3, 3);
            corner -= R * turned;
        }
        // Points on one line bear no moment about it; nothing is asked of them there.
        let inverse = square.try_inverse();
        let inverse = inverse.or_else(|| square.pseudo_inverse(1e-9).ok());
        let inverse = inverse.unwrap_or_else(Matrix6::zeros);
        resultants.map(|resultant| {
            let y = inverse * resultant;
            let (force, moment) = (y.fixed_rows::<3>(0), y.fixed_rows::<3>(3));
            let each = loads.iter().zip(&arms);
            each.map(|(load, r)| (force + moment.cross(r)) * (load / most))
                .collect()
        })
    }
}

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
        let (before, at, after) = (&polygon[(j + n - 1) % n], &polygon[j], &polygon[(j + 1) % n]);
        let beside = area(p, before, at).max(AREA_MIN) * area(p, at, after).max(AREA_MIN);
        area(before, at, after) / beside
    };
    let weights: Vec<f64> = (0..n).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

/// Areas beside a point on an edge are taken as no smaller, m².
const AREA_MIN: f64 = 1e-10;
