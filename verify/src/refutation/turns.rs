//! The least value of a form of the rotations of all bodies, and of the place of the base.
//!
//! From the leaves on, with R_J = R_P X the frame of a joint and R_b = R_J Rot(a, q):
//!
//!   ⟨G_b, R_b⟩ ≥ ⟨H_b, R_P⟩ + c_b,    c_b = min over q in its limits, R_P ∈ SO(3) of ⟨G_b, R_b⟩ − ⟨H_b, R_P⟩
//!
//! for whatever H_b is given, which then counts as the parent's. For one q the least over R_P is −(σ₁ + σ₂ ± σ₃) of
//! a matrix that is affine in Rot(a, q), and concave in that: over an arc it is at least the least at the corners
//! of a polygon around the arc. Rounding is 1e-12 of what must be left.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, Vector3};
use robot_model::{Body, JointKind, Robot};

use super::CERTAIN;

/// How often the range of a joint is halved at most, and to which part of what must be left.
const HALVINGS: usize = 500;
const FINE: f64 = 1e-3;

/// The form: ⟨G_b, R_b⟩ of every body, and by where its origin is.
pub(super) struct Turns<'a> {
    robot: &'a Robot,
    margin_rad: f64,
    turn: Vec<Matrix3<f64>>,
    place: Vec<Vector3<f64>>,
    /// The rotations in W that are known.
    pub known: Vec<Option<Matrix3<f64>>>,
}

impl<'a> Turns<'a> {
    pub fn new(robot: &'a Robot, margin_rad: f64) -> Self {
        let n = robot.bodies.len();
        Self {
            robot,
            margin_rad,
            turn: vec![Matrix3::zeros(); n],
            place: vec![Vector3::zeros(); n],
            known: vec![None; n],
        }
    }

    /// Adds `by` times the place of a point of a body.
    pub fn add(&mut self, body: usize, by: &Vector3<f64>, point_B: &Vector3<f64>) {
        self.turn[body] += by * point_B.transpose();
        self.place[body] += by;
    }

    /// A lower bound, and what is left by the place of the base.
    pub fn least(mut self, forms: &[[[f64; 3]; 3]]) -> (f64, Vector3<f64>) {
        let mut sum = 0.0;
        for (b, body) in self.robot.bodies.iter().enumerate().skip(1).rev() {
            let Some(parent) = body.parent else { continue };
            let (turn, place) = (self.turn[b], self.place[b]);
            self.add(parent, &place, &body.X_PJ.translation.vector);
            let R_PJ = body.X_PJ.rotation.to_rotation_matrix().into_inner();
            if body.kind == JointKind::Prismatic {
                self.turn[parent] += turn * R_PJ.transpose();
                sum -= place.norm() * body.lower.abs().max(body.upper.abs());
                continue;
            }
            let form = Matrix3::from_fn(|r, c| forms[b - 1][r][c]);
            self.turn[parent] += form;
            let known = [self.known[parent], self.known[b]];
            // The least for a joint's rotation, or a corner beside it.
            let least = |rotation: &Matrix3<f64>| match known {
                [Some(parent), Some(own)] => turn.dot(&own) - form.dot(&parent),
                [Some(parent), None] => turn.dot(&(parent * R_PJ * rotation)) - form.dot(&parent),
                [None, Some(own)] => {
                    turn.dot(&own) - (form * R_PJ).dot(&(own * rotation.transpose()))
                }
                [None, None] => least_turned(&(turn * rotation.transpose() - form * R_PJ)),
            };
            sum += over_arc(body, body.kept_margin(self.margin_rad), least);
        }
        sum += match &self.known[0] {
            Some(base) => self.turn[0].dot(base),
            None => least_turned(&self.turn[0]),
        };
        (sum, self.place[0])
    }
}

/// min over R ∈ SO(3) of ⟨M, R⟩.
fn least_turned(m: &Matrix3<f64>) -> f64 {
    let sigma = m.singular_values();
    let least = sigma.min();
    // The best R mirrors where −M does.
    let mirrored = if m.determinant() > 0.0 {
        2.0 * least
    } else {
        0.0
    };
    mirrored - sigma.sum()
}

/// A lower bound of a concave function of a joint's rotation within its limits.
fn over_arc(body: &Body, margin: f64, least: impl Fn(&Matrix3<f64>) -> f64) -> f64 {
    let (along, across) = (body.axis * body.axis.transpose(), body.axis.cross_matrix());
    let at = |q: f64, far: f64| {
        let in_plane = (Matrix3::identity() - along) * q.cos() + across * q.sin();
        least(&(along + in_plane * far))
    };
    let (lower, upper) = (body.lower + margin, body.upper - margin);
    let pieces = ((upper - lower) / FRAC_PI_2).ceil().clamp(1.0, 64.0);
    let end = |k: f64| lower + (upper - lower) * k / pieces;
    // Ends, values there, and the value at the corner between the tangents.
    let arc = |a: f64, b: f64, at_a: f64, at_b: f64| {
        let half = 0.5 * (b - a);
        (a, b, at_a, at_b, at(a + half, 1.0 / half.cos()))
    };
    let mut arcs: Vec<_> = (0..pieces as usize)
        .map(|k| [end(k as f64), end(k as f64 + 1.0)])
        .map(|[a, b]| arc(a, b, at(a, 1.0), at(b, 1.0)))
        .collect();
    for _ in 0..HALVINGS {
        let lowest = (0..arcs.len()).min_by(|&i, &j| arcs[i].4.total_cmp(&arcs[j].4));
        let Some(lowest) = lowest else { break };
        let found = arcs.iter().map(|arc| arc.2.min(arc.3));
        let found = found.fold(f64::INFINITY, f64::min);
        let (a, b, at_a, at_b, corner) = arcs[lowest];
        if corner >= found - FINE * CERTAIN {
            break;
        }
        let middle = 0.5 * (a + b);
        let at_middle = at(middle, 1.0);
        arcs[lowest] = arc(a, middle, at_a, at_middle);
        arcs.push(arc(middle, b, at_middle, at_b));
    }
    let bounds = arcs.iter().map(|arc| arc.2.min(arc.3).min(arc.4));
    let bound = bounds.fold(f64::INFINITY, f64::min);
    // Numbers that overflow prove nothing.
    let all = arcs.iter().all(|arc| (arc.2 + arc.3 + arc.4).is_finite());
    if all { bound } else { f64::NEG_INFINITY }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    use super::*;
    use crate::posture::{Posture, column, point};

    type Point = (usize, [f64; 3], [f64; 3]);

    fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1.0..1.0_f64, count)
    }

    fn points(bodies: usize) -> impl Strategy<Value = Vec<Point>> {
        let vector = || prop::array::uniform3(-1.0..1.0_f64);
        prop::collection::vec((0..bodies, vector(), vector()), 1..6)
    }

    proptest! {
        /// Whatever forms are given, no configuration is below the bound; where rotations are known it is not less
        /// than without.
        #[test]
        fn no_configuration_is_below_the_bound(
            at in numbers(18 + 7),
            forms in numbers(18 * 9),
            points in points(13),
            small in 0.0..1.0_f64,
        ) {
            let robot = scenes::robot("quadruped").unwrap();
            let n = robot.bodies.len();
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(at[3], at[4], at[5]) * 3.0);
            let mut q = at[..3].to_vec();
            q.extend(turn.coords.iter());
            let ranges = robot.bodies.iter().map(|b| [b.lower, b.upper]);
            let joints = ranges.skip(1).zip(&at[6..]);
            q.extend(joints.map(|([l, u], x)| l + (u - l) * (0.5 + 0.5 * x)));
            let posture = Posture::new(&robot, &q).unwrap();
            let forms: Vec<_> = (0..n - 1)
                .map(|b| [0, 1, 2].map(|r| [0, 1, 2].map(|c| small * forms[9 * b + 3 * r + c])))
                .collect();
            let bound = |known: &[usize]| {
                let mut turns = Turns::new(&robot, 0.0);
                for (body, by, p) in &points {
                    turns.add(body % n, &Vector3::from(*by), &Vector3::from(*p));
                }
                for &b in known {
                    turns.known[b] = Some(posture.X_WB[b].fixed_view::<3, 3>(0, 0).into_owned());
                }
                let (least, by_base) = turns.least(&forms);
                least + by_base.dot(&column(&posture.X_WB[0], 3))
            };
            let there: f64 = points
                .iter()
                .map(|(body, by, p)| {
                    let p_W = point(&posture.X_WB[body % n], &Vector3::from(*p));
                    Vector3::from(*by).dot(&p_W)
                })
                .sum();
            let free = bound(&[]);
            prop_assert!(free <= there + 1e-9, "{free} {there}");
            for known in [&[n - 1][..], &[0, 1], &[2, 3, n - 1]] {
                let bound = bound(known);
                prop_assert!(bound <= there + 1e-9, "{bound} {there} {known:?}");
                prop_assert!(bound >= free - 1e-5, "{bound} {free} {known:?}");
            }
        }
    }
}
