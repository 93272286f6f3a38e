//! The families of which nothing is known: steep feet and a hand, one foot and two hands, feet (and
//! hands) on opposed walls, feet far apart on surfaces of little friction.

use nalgebra::{Isometry3, Vector3};
use robot_model::Kinematics;

use super::draw::Draws;
use super::limbs::Limb;
use super::place::{Under, tilt};
use super::record::ProblemRecord;
use super::{Family, Maker};

/// What a family draws; angles in degrees.
struct Ranges {
    /// Least and greatest number of hands.
    hands: [usize; 2],
    friction: [f64; 2],
    /// Part of a joint's range by which a leg's and an arm's joints leave the resting posture.
    joints: [f64; 2],
    /// Tilt of the surfaces under the feet, and under the hands.
    tilt: [[f64; 2]; 2],
}

#[rustfmt::skip]
fn ranges(family: Family) -> Ranges {
    let (hands, friction, joints, tilt) = match family {
        Family::OneFoot => ([2, 2], [0.5, 0.9], [0.35, 0.6], [[0.0, 25.0], [0.0, 90.0]]),
        Family::Chimney => ([0, 2], [0.6, 1.0], [0.6, 0.7], [[25.0, 60.0], [30.0, 110.0]]),
        Family::Spread => ([0, 1], [0.15, 0.3], [0.5, 0.6], [[0.0, 12.0], [0.0, 90.0]]),
        _ => ([1, 1], [0.5, 0.9], [0.4, 0.6], [[20.0, 40.0], [0.0, 90.0]]),
    };
    Ranges { hands, friction, joints, tilt }
}

/// Largest angle between a wall's horizontal normal and the direction to the middle, rad.
const OFF_MIDDLE: f64 = 35.0_f64.to_radians();
/// How much farther from the middle a spread foot is than at rest.
const WIDER: f64 = 1.6;

pub(super) fn draw(maker: &Maker, family: Family, draws: &mut Draws) -> Option<ProblemRecord> {
    let ranges = ranges(family);
    let [feet_tilt, hands_tilt] = ranges.tilt.map(|range| range.map(f64::to_radians));
    let mut limbs = match family {
        Family::OneFoot => draws.some(&maker.limbs.feet.iter().collect::<Vec<_>>(), 1),
        _ => maker.limbs.some_feet(draws),
    };
    limbs.extend(maker.limbs.some_hands(ranges.hands, draws));
    let mu = draws.between(ranges.friction[0], ranges.friction[1]);
    let rest = Kinematics::new(maker.robot, &maker.rest);
    let fits = |limb: &Limb, X_WC: &Isometry3<f64>| {
        let patch = &maker.robot.patches[limb.patch];
        let (foot, ball) = (patch.has_role("foot"), patch.point_radius_m().is_some());
        let [least, most] = if foot { feet_tilt } else { hands_tilt };
        let at_rest = rest.X_WC(patch).translation.vector;
        (ball || (least..=most).contains(&tilt(X_WC)))
            && match family {
                Family::Chimney => ball || is_opposed(X_WC, at_rest.y),
                Family::Spread => !foot || is_wide(X_WC, at_rest.xy().norm()),
                _ => true,
            }
    };
    let under = match family {
        Family::Chimney => Under::Inward(feet_tilt, OFF_MIDDLE),
        _ => Under::Any(feet_tilt),
    };
    maker.plausible(&limbs, ranges.joints, &fits, under, mu, draws)
}

/// Whether the wall looks across the robot: the side of the limb, y, decides which way that is.
fn is_opposed(X_WC: &Isometry3<f64>, side: f64) -> bool {
    let across = Vector3::new(0.0, -side.signum(), 0.0);
    let z = X_WC.rotation * Vector3::z();
    Vector3::new(z.x, z.y, 0.0).angle(&across) <= OFF_MIDDLE
}

/// Legs that already stand wide cannot stand so much wider.
fn is_wide(X_WC: &Isometry3<f64>, at_rest: f64) -> bool {
    X_WC.translation.vector.xy().norm() >= (WIDER * at_rest).min(at_rest + 0.15)
}
