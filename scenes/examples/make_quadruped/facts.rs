//! What the robot is made of; a design of its own, of the size of the machines in use. Units: m, kg,
//! rad, N·m.

use crate::legged::Joint;

/// Place of the abduction axes beside the body's middle, ahead and to the side.
pub const HIP: [f64; 2] = [0.33, 0.11];
/// Distance of the thigh's axis from the abduction axis, outward.
pub const ABDUCTION: f64 = 0.10;
/// Length of the thigh.
pub const THIGH: f64 = 0.33;
/// Length of the shank, from the knee to the middle of the foot's ball.
pub const SHANK: f64 = 0.33;
/// Radius of the foot's ball.
pub const FOOT_RADIUS: f64 = 0.015;
/// Friction of rubber feet on dry wood, concrete or carpet.
pub const FRICTION: f64 = 0.9;
/// Height of the abduction axes over the ground while it stands.
pub const STANCE_HEIGHT: f64 = 0.55;

/// Mass of the body with its battery and computers.
pub const BODY_KG: f64 = 25.2;
/// Mass of the lidar.
pub const LIDAR_KG: f64 = 0.8;
/// Masses of hip, thigh and shank: the drives of hip and knee sit at the hip. All in all 50 kg.
pub const LEG_KG: [f64; 3] = [2.5, 2.6, 0.9];
/// Where the lidar's optical centre is on the head, over the front hips.
pub const LIDAR: [f64; 3] = [0.36, 0.0, 0.20];

/// Name of each leg, and the signs of its hip's place.
pub const LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("rear_left", [-1.0, 1.0]),
    ("rear_right", [-1.0, -1.0]),
    ("front_right", [1.0, -1.0]),
];

const EFFORT: f64 = 150.0;
const REASON: &str = "of its class of machines; half the weight on a bent leg needs 60";

/// In the body's frame (x forward, y left, z up): positive hip angles swing the leg to the left,
/// positive thigh angles backward; the knee bends forward below the thigh.
pub const JOINTS: [Joint; 3] = [
    Joint {
        name: "hip",
        axis: "1 0 0",
        lower: -0.75,
        upper: 0.75,
        effort: EFFORT,
        reason: REASON,
        velocity: 10.0,
    },
    Joint {
        name: "thigh",
        axis: "0 1 0",
        lower: -1.0,
        upper: 3.5,
        effort: EFFORT,
        reason: REASON,
        velocity: 10.0,
    },
    Joint {
        name: "knee",
        axis: "0 1 0",
        lower: -2.6,
        upper: -0.6,
        effort: EFFORT,
        reason: REASON,
        velocity: 10.0,
    },
];

/// Joint angles while it stands, the feet below the thighs' axes: two links of one length.
///
///   2 · thigh · cos θ = height − radius
pub fn standing() -> [f64; 3] {
    let down = STANCE_HEIGHT - FOOT_RADIUS;
    let thigh = (down / (THIGH + SHANK)).acos();
    [0.0, thigh, -2.0 * thigh]
}
