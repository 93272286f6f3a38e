//! Feet on opposed walls, and up to two hands on walls or ledges beside the robot.
//!
//! A wall is opposed when its normal points across the robot's middle.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Vector3};
use robot_model::Kinematics;

use super::Maker;
use super::draw::Draws;
use super::limbs::Limb;
use super::place::{Under, tilt};
use super::record::ProblemRecord;

/// Tilt of the walls under the feet, rad.
const FEET: [f64; 2] = [25.0_f64.to_radians(), 60.0_f64.to_radians()];
/// Tilt of the walls under the hands, rad.
const HANDS: [f64; 2] = [30.0_f64.to_radians(), 110.0_f64.to_radians()];
/// Largest angle between a wall's horizontal normal and the direction to the middle, rad.
const OFF_MIDDLE: f64 = 35.0_f64.to_radians();

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let mut limbs = maker.limbs.some_feet(draws);
    limbs.extend(maker.limbs.some_hands(0, 2, draws));
    let mu = draws.between(0.6, 1.0);
    let rest = Kinematics::new(maker.robot, &maker.rest);
    let opposed = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let patch = &maker.robot.patches[limb.patch];
        if patch.point_radius_m().is_some() {
            return true;
        }
        let angle = tilt(X_WC);
        let [least, most] = if patch.has_role("foot") { FEET } else { HANDS };
        let z = X_WC.rotation * Vector3::z();
        // Across the robot: the side of the limb decides where the wall must look.
        let side = rest.X_WC(patch).translation.y.signum();
        let across = Vector3::new(0.0, -side, 0.0);
        let level = Vector3::new(z.x, z.y, 0.0);
        (least..=most).contains(&angle) && level.angle(&across) <= OFF_MIDDLE
    };
    maker.plausible(
        &limbs,
        [0.6, 0.7],
        &opposed,
        Under::Inward(FEET, OFF_MIDDLE),
        mu,
        draws,
    )
}
