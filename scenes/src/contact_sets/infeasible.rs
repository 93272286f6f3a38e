//! Problems without a solution, each with a proof of it.
//!
//! - *out of reach*: two contacts are farther apart than the links between them are long;
//! - *no equilibrium*: all surfaces face one side or down, and no friction of up to
//!   [`FRICTION_MAX`] gives forces that carry a weight, wherever the centre of mass may be;
//! - *friction*: the same at the problem's friction, while twice as much would do.
//!
//! The friction cone is replaced by a pyramid around it, so that what no forces of the pyramid
//! carry, none of the cone do.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Unit, Vector3};

use super::Maker;
use super::draw::Draws;
use super::easy::{self, TILT_MAX};
use super::forces::{self, Pyramid};
use super::place::{Touch, Under, decimals};
use super::record::{Expected, ProblemRecord};

/// Largest coefficient of friction of any pair.
const FRICTION_MAX: f64 = 1.0;

pub(super) fn draw(maker: &Maker, draws: &mut Draws, number: usize) -> Option<ProblemRecord> {
    let (reason, problem) = match number % 3 {
        0 => ("out_of_reach", out_of_reach(maker, draws)?),
        1 => ("no_equilibrium", no_equilibrium(maker, draws)?),
        _ => ("friction", friction(maker, draws)?),
    };
    Some(ProblemRecord {
        expected: Some(Expected::Infeasible),
        reason: Some(reason.to_owned()),
        ..problem
    })
}

/// The contacts of a configuration, turned over about a level axis by between `turn` rad.
fn turned<'a>(maker: &'a Maker, turn: [f64; 2], draws: &mut Draws) -> Option<Vec<Touch<'a>>> {
    let mut limbs = maker.limbs.some_feet(draws);
    limbs.extend(maker.limbs.some_hands([0, 2], draws));
    let mut q = easy::level(maker, &limbs, 0.1, draws)?;
    if !maker.is_clear_of_itself(&q, 0.0) {
        return None;
    }
    maker.set_down(&mut q, &limbs, draws);
    let mut touches = maker.touches(&q, &limbs, Under::Any([0.0, TILT_MAX]), draws);
    let azimuth = draws.between(0.0, TAU);
    let axis = Unit::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
    let turn = Isometry3::rotation(axis.into_inner() * draws.between(turn[0], turn[1]));
    for touch in &mut touches {
        touch.X_WS = turn * touch.X_WS;
    }
    Some(touches)
}

/// Whether it is certain that these contacts carry nothing at this friction.
fn carries_nothing(maker: &Maker, touches: &[Touch], mu: f64) -> bool {
    let supports = maker.supports(touches, 0.0);
    forces::carry_somewhere(&supports, mu, Pyramid::Circumscribed) == Some(false)
}

fn no_equilibrium(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let touches = turned(maker, [1.3, std::f64::consts::PI], draws)?;
    carries_nothing(maker, &touches, FRICTION_MAX)
        .then(|| maker.fixed(&touches, draws.between(0.4, FRICTION_MAX)))
}

fn friction(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let touches = turned(maker, [0.5, 0.9], draws)?;
    let mu = decimals(draws.between(0.15, 0.5), 3);
    let supports = maker.supports(&touches, 0.0);
    let more = forces::carry_somewhere(&supports, 2.0 * mu, Pyramid::Inscribed) == Some(true);
    // A little above the problem's own friction, so that no rounding decides.
    (more && carries_nothing(maker, &touches, 1.02 * mu)).then(|| maker.fixed(&touches, mu))
}

fn out_of_reach(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let mut touches = turned(maker, [0.0, 0.0], draws)?;
    let last = touches.len().checked_sub(1)?;
    let [a, b] = [&touches[0], &touches[last]].map(|t| (t.limb, t.X_WS.translation.vector));
    let longest = maker.reach_m(a.0) + maker.trunk_m() + maker.reach_m(b.0);
    let way = Unit::try_new((b.1 - a.1).xy().push(0.0), 1e-3)?;
    let far = a.1 + way.into_inner() * longest * draws.between(1.1, 1.8);
    touches[last].X_WS.translation.vector = far + Vector3::z() * draws.between(0.0, 0.3);
    let mu = draws.between(0.5, 0.9);
    Some(maker.fixed(&touches, mu))
}
