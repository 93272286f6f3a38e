//! Proofs that no posture exists: contacts too far apart for the robot, and contacts at fixed places
//! whose forces cannot hold the weight wherever the centre of mass may be.
//!
//!   ‖p_a − p_b‖ ≤ Σ lengths of the links between a and b
//!   ∃ f ∈ K_μ, c :  Σ f = (0, 0, 1),  Σ p × f = c × (0, 0, 1)
//!
//! Both are convex in what is free, so that a failure is a proof; they cost a part of one SQP
//! iteration. Source: the support region of [bretl2008], which is empty where the second fails.
//! Where the search has found nothing there are two more: links that collide where contacts put them
//! (`colliding`), and contacts that cannot be reached and balanced on at once (`convex`).

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, Vector2, Vector3};
use robot_model::{Configuration, Kinematics};

use crate::contact::Freedom;
use crate::iterate::Context;
use crate::least_load::least_load;
use crate::outcome::Violation;
use crate::qp::{self, Program};
use crate::rows::{Constraint, Rows, Tag};

mod colliding;
mod convex;
#[cfg(test)]
mod tests;
mod written;

pub(crate) use convex::Answer;
pub use written::refutation;

/// Smallest violation that counts as a proof, beyond the engine's accuracy; `verify` asks for a third of it.
const CERTAIN: f64 = 1e-4;
/// Curvature that makes the program strictly convex, small against the price of violations.
const CURVATURE: f64 = 1e-4;

/// Sides of the pyramid around the friction cone: what it does not hold, the cone does not; the other way
/// round it is 0.5 % larger.
const SIDES: usize = 32;

/// The constraint that no posture fulfils, and by how much; nothing where none is found.
pub(crate) fn infeasible(ctx: &Context) -> Option<Violation> {
    let apart = apart(ctx).map(|(amount, [_, i])| Violation {
        constraint: Constraint::Closure(i),
        amount,
    });
    apart.or_else(|| if rolls(ctx) { None } else { unbalanced(ctx) })
}

/// The same by proofs that cost as much as attempts of the search; or where one more may begin.
pub(crate) fn after_all(ctx: &Context) -> Option<Answer> {
    if rolls(ctx) {
        let answer = convex::answer(ctx, &ranges(ctx), None);
        return answer.filter(|answer| matches!(answer, Answer::Seed(_)));
    }
    let colliding = colliding::worst(ctx).map(|(tag, amount)| {
        let constraint = ctx.constraint(tag);
        Answer::Refuted(Violation { constraint, amount })
    });
    colliding.or_else(|| convex::answer(ctx, &ranges(ctx), None))
}

/// Where one more may begin that keeps every joint within a part of its range about that of a configuration.
pub(crate) fn seed_near(ctx: &Context, q: &Configuration, part: f64) -> Option<Configuration> {
    let mut ranges = ranges(ctx);
    for (range, q) in ranges.iter_mut().skip(1).zip(q.joints.iter()) {
        let (lower, upper) = *range;
        let (at, reach) = (q.max(lower).min(upper), 0.5 * part * (upper - lower));
        *range = ((at - reach).max(lower), (at + reach).min(upper));
    }
    let near = Kinematics::new(ctx.robot(), q);
    match convex::answer(ctx, &ranges, Some(&near))? {
        Answer::Seed(q) => Some(q),
        Answer::Refuted(_) => None,
    }
}

/// Whether a contact's place depends on the posture, which most of the proofs do not know of.
fn rolls(ctx: &Context) -> bool {
    let mut contacts = ctx.problem.contacts.iter();
    contacts.any(|contact| contact.rolling(ctx.robot()).is_some())
}

/// The bounds of the joint of every body.
fn ranges(ctx: &Context) -> Vec<(f64, f64)> {
    let bodies = 0..ctx.robot().bodies.len();
    bodies.map(|b| ctx.joint_bounds(b)).collect()
}

/// Two contacts at fixed places that are farther apart than the robot is long between them, and by how much, m.
fn apart(ctx: &Context) -> Option<(f64, [usize; 2])> {
    let robot = ctx.robot();
    let contacts = ctx.problem.contacts.iter().enumerate();
    let fixed: Vec<_> = contacts.filter(|(_, c)| c.area().is_none()).collect();
    let mut worst: Option<(f64, [usize; 2])> = None;
    for (k, (j, a)) in fixed.iter().enumerate() {
        for (i, b) in &fixed[k + 1..] {
            let patches = [a, b].map(|contact| &robot.patches[contact.patch]);
            let [to_a, to_b] = patches.map(|patch| patch.X_BC.translation.vector.norm());
            // A ball rolls by half its rim at most.
            let rolls_m = [a, b].map(|c| c.rolling(robot).map_or(0.0, |r| PI * r.radius_m));
            let reach = span_m(ctx, patches[0].body, patches[1].body) + to_a + to_b;
            let reach = reach + rolls_m[0] + rolls_m[1];
            let way = a.X_WC.translation.vector - b.X_WC.translation.vector;
            let amount = way.norm() - reach;
            if amount > CERTAIN && worst.is_none_or(|w| amount > w.0) {
                worst = Some((amount, [*j, *i]));
            }
        }
    }
    worst
}

/// An upper bound of the distance between the frames of two bodies, m.
fn span_m(ctx: &Context, a: usize, b: usize) -> f64 {
    let bodies = &ctx.robot().bodies;
    // Parents have smaller numbers: the greater one climbs until both meet.
    let (mut a, mut b, mut span) = (a, b, 0.0);
    while a != b {
        let climbs = if a > b { &mut a } else { &mut b };
        span += bodies[*climbs].apart_m();
        match bodies[*climbs].parent {
            Some(parent) => *climbs = parent,
            None => break,
        }
    }
    span
}

/// The part of the weight that every point bears at least.
fn load(ctx: &Context, points: impl Iterator<Item = Vector2<f64>>) -> f64 {
    match ctx.on_balls_alone {
        true => least_load(&points.collect::<Vec<_>>(), ctx.config.com_margin_m).0,
        false => 0.0,
    }
}

/// Loaded contacts, all at fixed places, that cannot hold the weight.
fn unbalanced(ctx: &Context) -> Option<Violation> {
    // (contact, column, point), columns from 2: the first two are the centre of mass.
    let mut points: Vec<(usize, usize, Vector3<f64>)> = Vec::new();
    for (i, (contact, model)) in ctx.problem.contacts.iter().zip(&ctx.contacts).enumerate() {
        if !contact.loaded {
            continue;
        }
        // A patch that may turn offers no more than a disc around its points would: it is left
        // to the solver, as is one that may slide.
        let free = match contact.freedom {
            Freedom::Fixed => false,
            Freedom::Yaw => model.force_points.len() > 1,
            Freedom::Within(_) => true,
        };
        if free {
            return None;
        }
        for v in &model.force_points {
            let p = contact.X_WC * nalgebra::Point3::new(v.x, v.y, -model.radius.unwrap_or(0.0));
            points.push((i, 2 + 3 * points.len(), p.coords));
        }
    }
    let n = 2 + 3 * points.len();
    let middle = points.iter().map(|p| p.2).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let mut rows = Rows::new(n);
    for k in 0..3 {
        let row = rows.push(Tag::Equilibrium, if k == 2 { -1.0 } else { 0.0 }, 0.0, 0.0);
        for (contact, column, _) in &points {
            for j in 0..3 {
                row[column + j] = ctx.contacts[*contact].axes[(k, j)];
            }
        }
    }
    for k in 0..3 {
        let row = rows.push(Tag::Balance, 0.0, 0.0, 0.0);
        // −(c × z) = (−c_y, c_x, 0)
        match k {
            0 => row[1] = -1.0,
            1 => row[0] = 1.0,
            _ => {}
        }
        for (contact, column, p) in &points {
            let lever = Vector3::ith(k, 1.0).cross(&(p - middle));
            for j in 0..3 {
                row[column + j] = lever.dot(&ctx.contacts[*contact].axes.column(j));
            }
        }
    }
    let least_load = load(ctx, points.iter().map(|p| p.2.xy()));
    for (contact, column, _) in &points {
        let mu = ctx.contacts[*contact].mu;
        for side in 0..SIDES {
            let (y, x) = (TAU * side as f64 / SIDES as f64).sin_cos();
            let least = least_load * ctx.up_inside(*contact, [x, y], mu);
            let row = rows.push(Tag::Friction(*contact), 0.0, least, f64::INFINITY);
            row[*column..column + 3].copy_from_slice(&[-x, -y, mu]);
            rows.harden_last();
        }
    }
    let less = |bounds: &[f64]| -> Vec<f64> {
        bounds.iter().zip(&rows.value).map(|(b, v)| b - v).collect()
    };
    let program = Program {
        hessian: &DMatrix::from_diagonal_element(n, n, CURVATURE),
        gradient: &vec![0.0; n],
        a: &rows.a,
        names: &rows.tag,
        row_lower: &less(&rows.lower),
        row_upper: &less(&rows.upper),
        hard: &rows.hard,
        lower: &vec![f64::NEG_INFINITY; n],
        upper: &vec![f64::INFINITY; n],
    };
    let x = qp::engine(ctx.config.solver.engine).solve(&program).ok()?;
    let left = (0..6).map(|i| Violation {
        constraint: ctx.constraint(rows.tag[i]),
        amount: (rows.value[i] + rows.change(i, &x)).abs(),
    });
    let certain = left.filter(|v| v.amount > CERTAIN);
    certain.max_by(|a, b| a.amount.total_cmp(&b.amount))
}
