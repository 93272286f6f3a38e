//! Pairs of links that need no watching, with the reasons, as MoveIt's assistant finds them.
//!
//! That a pair was never seen to meet in drawn postures proves nothing, and such pairs stay watched:
//! only those are left out as `Never` whose joints are too far apart for what hangs on them.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::collision::{CollisionModel, Other, Shape};
use crate::load::{NEAR_M, are_neighbours, sampled};
use crate::{Configuration, Kinematics, Robot};

/// Postures that are drawn.
pub(super) const POSTURES: u64 = 400;
/// A pair that meets in this part of the drawn postures does so always.
const ALWAYS: f64 = 0.95;

/// Why a pair is not watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// A joint joins the two.
    Adjacent,
    /// Neighbours whose shapes meet in the standing posture.
    Default,
    /// They meet in nearly every drawn posture.
    Always,
    /// They are farther apart than the links between them are long.
    Never,
}

/// A pair of links that is not watched.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Excepted {
    /// The one link, the first in the alphabet.
    pub link_a: String,
    /// The other.
    pub link_b: String,
    /// Why.
    pub reason: Reason,
}

/// The pairs of links that need no watching, in alphabetical order. `standing` is the posture by
/// default.
pub fn excepted(robot: &Robot, standing: &Configuration) -> Vec<Excepted> {
    let shapes = robot.collision.shapes();
    let model = CollisionModel::new(shapes.to_vec(), &robot.bodies);
    let links = |i: usize, j: usize| {
        let (a, b) = (shapes[i].link.clone(), shapes[j].link.clone());
        if a < b { (a, b) } else { (b, a) }
    };
    let meeting = |q: &Configuration, within_m: f64| {
        let mut near = Vec::new();
        model.self_proximities(&Kinematics::new(robot, q), within_m, &mut near);
        let pairs = near.iter().filter_map(|p| match p.b {
            Other::Shape(b) if p.distance < within_m => Some((p.a, b)),
            _ => None,
        });
        let mut pairs: Vec<_> = pairs
            .map(|(a, b)| (links(a.shape, b.shape), [a.body, b.body]))
            .collect();
        pairs.sort();
        pairs.dedup();
        pairs
    };
    let mut reasons: BTreeMap<(String, String), Reason> = BTreeMap::new();
    // 1. Neighbours whose shapes meet where the robot stands.
    let at = Kinematics::new(robot, standing);
    for (pair, [a, b]) in meeting(standing, NEAR_M) {
        if are_neighbours(robot, &at, a, b) {
            reasons.insert(pair, Reason::Default);
        }
    }
    // 2. What meets in nearly all postures.
    let mut counts: BTreeMap<(String, String), u64> = BTreeMap::new();
    for number in 1..=POSTURES {
        for (pair, _) in meeting(&sampled(robot, number), NEAR_M) {
            *counts.entry(pair).or_default() += 1;
        }
    }
    for (pair, count) in counts {
        if count as f64 > ALWAYS * POSTURES as f64 {
            reasons.entry(pair).or_insert(Reason::Always);
        }
    }
    // 3. What joints join, and what lengths keep apart: every shape of the one from each of the other.
    let mut apart: BTreeMap<(String, String), bool> = BTreeMap::new();
    for (i, first) in shapes.iter().enumerate() {
        for (j, second) in shapes.iter().enumerate().skip(i + 1) {
            let (a, b) = (first.body, second.body);
            let parent = |k: usize| robot.bodies[k].parent;
            if a != b && (parent(a) == Some(b) || parent(b) == Some(a)) {
                reasons.insert(links(i, j), Reason::Adjacent);
            } else if a != b {
                let never = never_meet(robot, first, second);
                *apart.entry(links(i, j)).or_insert(true) &= never;
            }
        }
    }
    for (pair, never) in apart {
        if never {
            reasons.entry(pair).or_insert(Reason::Never);
        }
    }
    let found = reasons
        .into_iter()
        .map(|((link_a, link_b), reason)| Excepted {
            link_a,
            link_b,
            reason,
        });
    found.collect()
}

/// Whether two shapes are too far apart for any joint values: from the body that carries both, each is
/// within a ball about the first joint on the way to it.
fn never_meet(robot: &Robot, a: &Shape, b: &Shape) -> bool {
    let above = |body: usize| -> Vec<usize> {
        std::iter::successors(Some(body), |&k| robot.bodies[k].parent).collect()
    };
    let (of_a, of_b) = (above(a.body), above(b.body));
    let Some(shared) = of_a.iter().copied().find(|k| of_b.contains(k)) else {
        return false;
    };
    let ball = |shape: &Shape, chain: &[usize]| -> (Vector3<f64>, f64) {
        let on_the_way: Vec<usize> = chain.iter().copied().take_while(|k| *k != shared).collect();
        let about = |centre: &Vector3<f64>| {
            let (low, high) = bounds(shape);
            (low - centre).abs().sup(&(high - centre).abs()).norm()
        };
        let Some(first) = on_the_way.last() else {
            let (low, high) = bounds(shape);
            let centre = 0.5 * (low + high);
            return (centre, about(&centre));
        };
        let mut reach = about(&Vector3::zeros());
        for &k in &on_the_way {
            let body = &robot.bodies[k];
            if body.kind == crate::JointKind::Prismatic {
                reach += body.lower.abs().max(body.upper.abs());
            }
            if k != *first {
                reach += body.X_PJ.translation.vector.norm();
            }
        }
        (robot.bodies[*first].X_PJ.translation.vector, reach)
    };
    let ((p, r), (q, s)) = (ball(a, &of_a), ball(b, &of_b));
    (p - q).norm() > r + s + NEAR_M
}

/// The corners of a shape's box in its body, m.
fn bounds(shape: &Shape) -> (Vector3<f64>, Vector3<f64>) {
    let along = |axis: usize, sign: f64| {
        let d = Vector3::ith(axis, sign);
        let p = shape.X_BG * shape.geometry.support(&(shape.X_BG.rotation.inverse() * d));
        p.coords[axis]
    };
    let corner = |sign: f64| Vector3::from_fn(|axis, _| along(axis, sign));
    (corner(-1.0), corner(1.0))
}
