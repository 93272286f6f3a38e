//! Feet on surfaces tilted by 20° to 40°, and a hand where the robot has one.

use nalgebra::Isometry3;

use super::Maker;
use super::draw::Draws;
use super::limbs::Limb;
use super::place::{Under, tilt};
use super::record::ProblemRecord;

/// Tilt of the feet's surfaces, rad.
const FEET: [f64; 2] = [20.0_f64.to_radians(), 40.0_f64.to_radians()];

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let mut limbs = maker.limbs.some_feet(draws);
    limbs.extend(maker.limbs.some_hands(1, 1, draws));
    let mu = draws.between(0.5, 0.9);
    #[allow(non_snake_case)]
    let steep = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let patch = &maker.robot.patches[limb.patch];
        let angle = tilt(X_WC);
        if patch.has_role("foot") {
            patch.point_radius_m().is_some() || (FEET[0]..=FEET[1]).contains(&angle)
        } else {
            angle <= std::f64::consts::FRAC_PI_2
        }
    };
    maker.plausible(&limbs, [0.4, 0.6], &steep, Under::Any(FEET), mu, draws)
}
