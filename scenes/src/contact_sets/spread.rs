//! Feet far apart on surfaces of little friction, and up to one hand.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Vector3};
use robot_model::Kinematics;

use super::Maker;
use super::draw::Draws;
use super::limbs::Limb;
use super::place::{Under, tilt};
use super::record::ProblemRecord;

/// Largest tilt of the feet's surfaces, rad.
const FEET_MAX: f64 = 12.0_f64.to_radians();
/// How much farther from the middle a foot is than at rest.
const WIDER: f64 = 1.6;

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let mut limbs = maker.limbs.some_feet(draws);
    limbs.extend(maker.limbs.some_hands(0, 1, draws));
    let mu = draws.between(0.15, 0.3);
    let rest = Kinematics::new(maker.robot, &maker.rest);
    let level = |p: Vector3<f64>| p.xy().norm();
    let wide = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let patch = &maker.robot.patches[limb.patch];
        if !patch.has_role("foot") {
            return tilt(X_WC) <= std::f64::consts::FRAC_PI_2;
        }
        let flat = patch.point_radius_m().is_some() || tilt(X_WC) <= FEET_MAX;
        let at_rest = level(rest.X_WC(patch).translation.vector);
        // Legs that already stand wide cannot stand so much wider.
        let wider = (WIDER * at_rest).min(at_rest + 0.15);
        flat && level(X_WC.translation.vector) >= wider
    };
    maker.plausible(
        &limbs,
        [0.5, 0.6],
        &wide,
        Under::Any([0.0, FEET_MAX]),
        mu,
        draws,
    )
}
