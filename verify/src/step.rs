//! The robot's shapes at one time, and what they do from one time to the next.

use nalgebra::Vector3;
use plan::Sample;
use robot_model::JointKind;

use crate::posture::{Posture, column};
use crate::scene::Scene;
use crate::solid::Placed;

/// The robot's shapes at one time.
pub(crate) struct Moment<'a> {
    pub shapes: Vec<Placed<'a>>,
    /// How far a point of each shape has come at most since the first moment, m.
    pub moved: Vec<f64>,
}

impl<'a> Moment<'a> {
    /// The shapes of a posture, after those of another.
    pub fn new(scene: &'a Scene, posture: &Posture, before: Option<&Moment>) -> Self {
        let solids = scene.shapes.iter();
        let shapes = solids.map(|(body, solid)| solid.at(&posture.X_WB[*body]));
        let shapes: Vec<Placed> = shapes.collect();
        let moved = match before {
            None => vec![0.0; shapes.len()],
            Some(before) => {
                let pairs = before.shapes.iter().zip(&shapes).zip(&before.moved);
                pairs
                    .map(|((a, b), so_far)| so_far + b.moved_from(a))
                    .collect()
            }
        };
        Self { shapes, moved }
    }
}

/// From one moment to the next.
pub(crate) struct Step<'a> {
    /// None where `now` is the first.
    pub before: Option<&'a Moment<'a>>,
    pub now: &'a Moment<'a>,
    /// How far each shape's points may be off the straight line between their two places, m.
    pub bends_m: &'a [f64],
    /// The shapes at a part of the step, by which it is looked at more closely.
    pub at: &'a dyn Fn(f64) -> Option<Moment<'a>>,
}

/// How far the points of each shape may be off the straight line between their places in two samples
/// over a time h, m, where no coordinate accelerates more between the two than in one of them:
///
///   |p(t) − line(t)|  ≤  h²/8 max |p̈|
///
/// with the largest that velocities and accelerations of all joints on the way to a point can add up to.
pub(crate) fn bends_m(scene: &Scene, posture: &Posture, pair: [&Sample; 2], h: f64) -> Vec<f64> {
    let three = |x: &[f64], k: usize| Vector3::new(x[k], x[k + 1], x[k + 2]).norm();
    let most = |of: &dyn Fn(&Sample) -> f64| of(pair[0]).max(of(pair[1]));
    let turns = most(&|s| three(&s.a, 3));
    // Of each body: acceleration of its origin, angular velocity and acceleration.
    let mut bounds = vec![[
        most(&|s| three(&s.a, 0)),
        most(&|s| three(&s.v, 3)) + 0.5 * h * turns,
        turns,
    ]];
    for (i, body) in scene.robot.bodies.iter().enumerate().skip(1) {
        let parent = body.parent.unwrap_or(0);
        let [linear, omega, alpha] = bounds[parent];
        let change = most(&|s| s.a[5 + i].abs());
        let rate = most(&|s| s.v[5 + i].abs()) + 0.5 * h * change;
        let lever = (column(&posture.X_WB[i], 3) - column(&posture.X_WB[parent], 3)).norm();
        let slides = body.kind == JointKind::Prismatic;
        let lever = lever + if slides { h * rate } else { 0.0 };
        let carried = linear + (alpha + omega * omega) * lever;
        bounds.push(match slides {
            true => [carried + change + 2.0 * omega * rate, omega, alpha],
            false => [carried, omega + rate, alpha + change + omega * rate],
        });
    }
    let shapes = scene.shapes.iter().map(|(body, solid)| {
        let [linear, omega, alpha] = bounds[*body];
        let (centre, reach) = solid.ball();
        h * h / 8.0 * (linear + (alpha + omega * omega) * (centre.norm() + reach))
    });
    shapes.collect()
}

/// The configuration at a part of the time h between two samples: the cubic of their positions and
/// velocities.
pub(crate) fn between(pair: [&Sample; 2], h: f64, part: f64) -> Vec<f64> {
    let [a, b] = pair;
    let (s, r) = (part, 1.0 - part);
    let (far, out, back) = (s * s * (3.0 - 2.0 * s), h * s * r * r, -h * s * s * r);
    let mut q: Vec<f64> =
        a.q.iter()
            .zip(&b.q)
            .map(|(x, y)| x + far * (y - x))
            .collect();
    let mut add = |k: usize, by: f64| q[k] += by;
    for k in 0..3 {
        add(k, out * a.v[k] + back * b.v[k]);
    }
    for k in 7..a.q.len() {
        add(k, out * a.v[k - 1] + back * b.v[k - 1]);
    }
    // q̇ = ω q / 2
    for (sample, by) in [(a, out), (b, back)] {
        let (x, w) = (
            Vector3::new(sample.q[3], sample.q[4], sample.q[5]),
            sample.q[6],
        );
        let omega = Vector3::new(sample.v[3], sample.v[4], sample.v[5]) * 0.5;
        let rate = omega * w + omega.cross(&x);
        for k in 0..3 {
            add(3 + k, by * rate[k]);
        }
        add(6, -by * omega.dot(&x));
    }
    q
}
