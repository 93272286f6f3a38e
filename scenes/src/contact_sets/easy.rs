//! Feet, and up to two hands, on surfaces tilted by at most 20°; solvable by a witness.

use nalgebra::Isometry3;
use robot_model::Configuration;

use super::Maker;
use super::draw::Draws;
use super::limbs::{Limb, Wanted};
use super::place::{Touch, Under, decimals, tilt};
use super::record::ProblemRecord;

/// Largest tilt of a surface, rad.
pub(super) const TILT_MAX: f64 = 20.0 * std::f64::consts::PI / 180.0;

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let (q, touches, mu) = witness(maker, draws)?;
    Some(maker.witnessed(maker.fixed(&touches, mu), &q))
}

/// A configuration with those limbs' patches tilted by at most [`TILT_MAX`], the base by `base_tilt` rad.
pub(super) fn level(
    maker: &Maker,
    limbs: &[&Limb],
    base_tilt: f64,
    draws: &mut Draws,
) -> Option<Configuration> {
    let fits = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let ball = maker.robot.patches[limb.patch].point_radius_m().is_some();
        ball || tilt(X_WC) <= TILT_MAX
    };
    let wanted = Wanted {
        limbs: limbs.to_vec(),
        range: [0.25, 0.6],
        base_tilt,
        fits: &fits,
    };
    maker.configuration(&wanted, draws)
}

/// A configuration that holds on level or little tilted surfaces, and its friction.
pub(super) fn witness<'a>(
    maker: &'a Maker,
    draws: &mut Draws,
) -> Option<(Configuration, Vec<Touch<'a>>, f64)> {
    let mut limbs = maker.limbs.some_feet(draws);
    limbs.extend(maker.limbs.some_hands([0, 2], draws));
    let mu = decimals(draws.between(0.5, 0.9), 3);
    let mut q = level(maker, &limbs, 0.2, draws)?;
    maker.set_down(&mut q, &limbs, draws);
    let touches = maker.touches(&q, &limbs, Under::Any([0.0, TILT_MAX]), draws);
    maker.holds(&q, &touches, mu).then_some((q, touches, mu))
}
