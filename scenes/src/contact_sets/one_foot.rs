//! One foot and two hands.

use nalgebra::Isometry3;

use super::Maker;
use super::draw::Draws;
use super::limbs::Limb;
use super::place::{Under, tilt};
use super::record::ProblemRecord;

/// Largest tilt of the foot's surface, rad.
const FOOT_MAX: f64 = 25.0_f64.to_radians();

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let feet: Vec<&Limb> = maker.limbs.feet.iter().collect();
    let mut limbs = draws.some(&feet, 1);
    limbs.extend(maker.limbs.some_hands(2, 2, draws));
    let mu = draws.between(0.5, 0.9);
    #[allow(non_snake_case)]
    let fits = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let patch = &maker.robot.patches[limb.patch];
        let most = if patch.has_role("foot") {
            FOOT_MAX
        } else {
            std::f64::consts::FRAC_PI_2
        };
        patch.point_radius_m().is_some() || tilt(X_WC) <= most
    };
    maker.plausible(
        &limbs,
        [0.35, 0.6],
        &fits,
        Under::Any([0.0, FOOT_MAX]),
        mu,
        draws,
    )
}
