//! How the contacts share what accelerates the robot.
//!
//! Forces of standing still carry the weight; what is needed beyond them is shared by the points in
//! proportion to what each bears at rest, and along its normal rather than across it, where it might slip:
//!
//!   f = f₀ + W Gᵀ (G W Gᵀ)⁻¹ w,   W = diag(f₀·n (n nᵀ + μ² (1 − n nᵀ))),   w: force and moment about the
//!                                                                              centre of mass
//!
//! so that a contact that bears nothing takes nothing, and forces are continuous where contacts change.
//! The points are those of the patches shrunk by less than at rest: the zero-moment point may use a part
//! of the margin of the centre of mass.

use std::ops::AddAssign;

use nalgebra::{Cholesky, Matrix3, Matrix6, Point2, Vector3, Vector6};
use posture::{Contact, Rolling, patch_inset_m};
use robot_model::Kinematics;

use crate::problem::MotionContext;

/// One point at which a force acts.
pub(crate) struct ForcePoint {
    /// Index of the contact.
    pub contact: usize,
    /// Where, in W, m; of a ball where it touches at the place that it rolls from.
    pub p_W: Vector3<f64>,
}

/// The points of closed contacts, and how they take over the forces of the postures' points.
pub(crate) struct LoadShares {
    pub points: Vec<ForcePoint>,
    /// For each contact, for each of the postures' points: the parts of each own point.
    parts: Vec<Vec<Vec<f64>>>,
    /// The body of each contact, and how its ball rolls where it does.
    rolling: Vec<(usize, Option<Rolling>)>,
    /// Normal of each contact, and how much sooner it bears along that than across it.
    normals: Vec<Vector3<f64>>,
    bearing: Vec<Matrix3<f64>>,
}

impl LoadShares {
    pub fn new(context: &MotionContext, closed: &[Contact]) -> Self {
        let mut shares = Self {
            points: Vec::new(),
            parts: Vec::new(),
            rolling: closed
                .iter()
                .map(|c| {
                    (
                        context.robot.patches[c.patch].body,
                        c.rolling(context.robot),
                    )
                })
                .collect(),
            normals: closed.iter().map(Contact::normal_W).collect(),
            bearing: closed
                .iter()
                .map(|c| bearing(&c.normal_W(), c.friction))
                .collect(),
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

    /// Where the points are in a configuration, in W.
    pub fn points_W(&self, kinematics: &Kinematics) -> Vec<Vector3<f64>> {
        let shift_W = self.rolling.iter().map(|(body, rolling)| {
            let R_WB = &kinematics.X_WB[*body].rotation;
            rolling.map_or_else(Vector3::zeros, |rolling| rolling.shift_W(R_WB))
        });
        let shift_W: Vec<Vector3<f64>> = shift_W.collect();
        let points = self.points.iter();
        points.map(|p| p.p_W + shift_W[p.contact]).collect()
    }

    /// The forces of a posture's points as forces at the own ones, N: each contact's points share what it bears
    /// across its normal by how hard they press, so that none of them slips first.
    ///
    ///   t_i = n_i (T/N + n × r_i M/Σ n_j |n × r_j|²),   r from the centre of pressure
    pub fn at_rest(&self, forces_W: &[Vec<Vector3<f64>>]) -> Vec<Vector3<f64>> {
        let mut own = Vec::with_capacity(self.points.len());
        for (number, (parts, forces)) in self.parts.iter().zip(forces_W).enumerate() {
            let begin = own.len();
            let count = parts.first().map_or(0, Vec::len);
            own.resize(begin + count, Vector3::zeros());
            for (parts, force) in parts.iter().zip(forces) {
                for (sum, part) in own[begin..].iter_mut().zip(parts) {
                    *sum += force * *part;
                }
            }
            let points = &self.points[begin..own.len()];
            shared_across(&self.normals[number], points, &mut own[begin..]);
        }
        own
    }

    /// Force and moment about `com_W` of each of several forces at every point, which are where they are.
    pub fn resultants<const N: usize>(
        &self,
        (points_W, com_W): (&[Vector3<f64>], &Vector3<f64>),
        forces_W: &[[Vector3<f64>; N]],
    ) -> [Vector6<f64>; N] {
        let mut sums = [Vector6::zeros(); N];
        for (p_W, forces) in points_W.iter().zip(forces_W) {
            let r = p_W - com_W;
            for (sum, f) in sums.iter_mut().zip(forces) {
                let moment = r.cross(f);
                *sum += Vector6::new(f.x, f.y, f.z, moment.x, moment.y, moment.z);
            }
        }
        sums
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
        (points_W, com_W): (&[Vector3<f64>], &Vector3<f64>),
        resultants: [Vector6<f64>; N],
    ) -> impl Iterator<Item = [Vector3<f64>; N]> + use<N> {
        let most = weights.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(*b));
        let each = self.points.iter().zip(points_W).zip(weights);
        let each = each.map(|((p, p_W), w)| (p_W - com_W, self.bearing[p.contact] * (w / most)));
        let each: Vec<(Vector3<f64>, Matrix3<f64>)> = each.collect();
        let mut square = Matrix6::zeros();
        for (r, W) in &each {
            let R = r.cross_matrix();
            let lower = R * W;
            square.fixed_view_mut::<3, 3>(0, 0).add_assign(W);
            square.fixed_view_mut::<3, 3>(3, 0).add_assign(&lower);
            square
                .fixed_view_mut::<3, 3>(0, 3)
                .add_assign(&lower.transpose());
            square
                .fixed_view_mut::<3, 3>(3, 3)
                .add_assign(&(-lower * R));
        }
        // Points on one line bear no moment about it; nothing is asked of them there.
        let factor = Cholesky::new(square);
        let inverse = match factor {
            Some(_) => None,
            None => square.pseudo_inverse(1e-9).ok(),
        };
        let solved = resultants.map(|resultant| {
            let y = match (&factor, inverse) {
                (Some(factor), _) => factor.solve(&resultant),
                (None, Some(inverse)) => inverse * resultant,
                (None, None) => Vector6::zeros(),
            };
            [y.fixed_rows::<3>(0), y.fixed_rows::<3>(3)].map(|part| part.into_owned())
        });
        let own = each.into_iter();
        own.map(move |(r, W)| solved.map(|[force, moment]| W * (force + moment.cross(&r))))
    }

    /// Forces with this resultant whose loads are near to those at rest in proportion, so that none of
    /// them changes its sign: the shares of the whole, again and again by the loads that come of it.
    pub fn leaning(
        &self,
        mut loads: Vec<f64>,
        at: (&[Vector3<f64>], &Vector3<f64>),
        resultant: Vector6<f64>,
    ) -> impl Iterator<Item = Vector3<f64>> + use<> {
        for _ in 0..LEANINGS {
            let forces = self.shared(&loads, at, [resultant]);
            let next = forces.zip(&self.points).map(|([f], p)| self.load(&f, p));
            for (load, next) in loads.iter_mut().zip(next) {
                *load = next.max(FALL_MAX * *load);
            }
        }
        self.shared(&loads, at, [resultant]).map(|[f]| f)
    }

    /// How hard each point presses, N; nothing where it pulls.
    pub fn loads(&self, forces_W: impl Iterator<Item = Vector3<f64>>) -> Vec<f64> {
        let loads = forces_W.zip(&self.points);
        loads.map(|(f, p)| self.load(&f, p)).collect()
    }

    fn load(&self, f: &Vector3<f64>, p: &ForcePoint) -> f64 {
        f.dot(&self.normals[p.contact]).max(0.0)
    }
}

/// Shares the forces of one contact across its normal `n` by how hard its points press.
fn shared_across(n: &Vector3<f64>, points: &[ForcePoint], forces_W: &mut [Vector3<f64>]) {
    let pressed = |f: &Vector3<f64>| f.dot(n).max(0.0);
    let load: f64 = forces_W.iter().map(pressed).sum();
    if load < f64::MIN_POSITIVE {
        return;
    }
    let part = |f: &Vector3<f64>| pressed(f) / load;
    let points_at = points.iter().zip(&*forces_W);
    let centre = points_at.fold(Vector3::zeros(), |sum, (p, f)| sum + p.p_W * part(f));
    let arm = |p: &ForcePoint| n.cross(&(p.p_W - centre));
    let (mut across, mut moment, mut square) = (Vector3::zeros(), 0.0, 0.0);
    for (p, f) in points.iter().zip(&*forces_W) {
        let r = arm(p);
        across += f - n * f.dot(n);
        moment += r.dot(f);
        square += r.norm_squared() * pressed(f);
    }
    let turning = if square > AREA_MIN * load {
        moment / square
    } else {
        0.0
    };
    for (f, p) in forces_W.iter_mut().zip(points) {
        *f = n * f.dot(n) + (across / load + arm(p) * turning) * pressed(f);
    }
}

/// n nᵀ + μ² (1 − n nᵀ): a force across the normal costs by the part of the friction that it takes.
fn bearing(n: &Vector3<f64>, mu: f64) -> Matrix3<f64> {
    let along = n * n.transpose();
    let mu = mu.max(MU_MIN);
    along + (Matrix3::identity() - along) * (mu * mu)
}

/// Least friction there: without any, points would bear nothing across.
const MU_MIN: f64 = 0.01;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_pushes_across_a_slippery_floor_is_borne_by_the_wall_behind() {
        // Two points on a floor and two on a wall, all at the height of the centre of mass but for moments.
        let normals = vec![Vector3::z(), Vector3::x()];
        let at = [
            (0, [0.0, 0.2, -0.8]),
            (0, [0.2, -0.2, -0.8]),
            (1, [-0.5, 0.3, 0.1]),
            (1, [-0.5, -0.3, -0.1]),
        ];
        let shares = LoadShares {
            points: at
                .map(|(contact, p)| ForcePoint {
                    contact,
                    p_W: p.into(),
                })
                .into(),
            parts: Vec::new(),
            rolling: Vec::new(),
            bearing: normals.iter().map(|n| bearing(n, 0.3)).collect(),
            normals,
        };
        let w = Vector6::new(40.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let points_W: Vec<_> = shares.points.iter().map(|p| p.p_W).collect();
        let at = (&points_W[..], &Vector3::zeros());
        let forces: Vec<_> = shares.shared(&[250.0; 4], at, [w]).collect();
        let wall = forces[2][0].x + forces[3][0].x;
        assert!(wall > 25.0, "the wall bears {wall} N of 40");
        let [sum] = shares.resultants(at, &forces);
        assert!((sum - w).norm() < 1e-9);
    }

    #[test]
    fn no_point_of_a_contact_slips_before_the_others() {
        let n = Vector3::new(0.2, 0.0, 1.0).normalize();
        let at = [
            [0.1, 0.05, -0.02],
            [0.1, -0.05, -0.02],
            [-0.1, 0.05, 0.02],
            [-0.1, -0.05, 0.02],
        ];
        let points = at.map(|p| ForcePoint {
            contact: 0,
            p_W: p.into(),
        });
        let x = n.cross(&Vector3::y());
        // All across is borne by the point that hardly presses.
        let mut forces = [200.0, 150.0, 100.0, 10.0].map(|load| n * load);
        forces[3] += x * 30.0;
        let resultant = |forces: &[Vector3<f64>]| {
            let moments = points.iter().zip(forces).map(|(p, f)| p.p_W.cross(f));
            (
                forces.iter().sum::<Vector3<f64>>(),
                moments.sum::<Vector3<f64>>(),
            )
        };
        let before = resultant(&forces);
        shared_across(&n, &points, &mut forces);
        let after = resultant(&forces);
        assert!((after.0 - before.0).norm() < 1e-9 && (after.1 - before.1).norm() < 1e-9);
        for f in &forces {
            let slips = (f - n * f.dot(&n)).norm() / f.dot(&n);
            assert!(slips < 0.15, "{slips}, 3.0 before");
        }
    }
}
