//! What is known or estimated of the robot. Units: m, kg, rad, N·m.

use crate::legged::Joint;

/// Distance of the hips from the body's middle.
pub const HIP_RADIUS: f64 = 0.208;
/// Distance of the feet from the body's middle while it stands.
pub const STANCE_RADIUS: f64 = 0.78;
/// Height of the hips over the ground while it stands: the middle of the known heights
/// 0.615, 0.68 and 0.75.
pub const STANCE_HEIGHT: f64 = 0.68;
/// Length of the coxa, from the yaw axis to the thigh's.
pub const COXA: f64 = 0.10;
/// Length of the thigh.
pub const THIGH: f64 = 0.45;
/// Length of the shank, from the knee to the middle of the foot's ball.
pub const SHANK: f64 = 0.55;
/// Radius of the foot's ball; an estimate. The real feet tilt on a joint and do not roll: the ball is
/// small, so that it rolls little.
pub const FOOT_RADIUS: f64 = 0.02;
/// Friction of the feet on the ground; an estimate.
pub const FRICTION: f64 = 0.6;

/// Mass of the body.
pub const BODY_KG: f64 = 140.0;
/// Masses of coxa, thigh and shank: 10 kg a leg, its division an estimate.
pub const LEG_KG: [f64; 3] = [3.0, 4.0, 3.0];

/// Name and heading of each leg, degrees.
pub const LEGS: [(&str, f64); 6] = [
    ("front_left", 30.0),
    ("middle_left", 90.0),
    ("rear_left", 150.0),
    ("rear_right", -150.0),
    ("middle_right", -90.0),
    ("front_right", -30.0),
];

/// In the leg's frame (x outward, z up): positive thigh and knee angles lift; the knee bends down
/// only.
pub const JOINTS: [Joint; 3] = [
    Joint {
        name: "coxa",
        axis: "0 0 1",
        lower: -0.8,
        upper: 0.8,
        effort: 250.0,
        reason: "estimate: 300 N across the foot of a leg of 0.78 m",
        velocity: 2.0,
    },
    Joint {
        name: "thigh",
        axis: "0 -1 0",
        lower: -1.0,
        upper: 1.4,
        effort: 400.0,
        reason: "estimate: 200 kg on three legs, feet 0.47 m beside the hips, need 300",
        velocity: 2.0,
    },
    Joint {
        name: "knee",
        axis: "0 -1 0",
        lower: -2.6,
        upper: -0.2,
        effort: 400.0,
        reason: "estimate: 654 N on a foot up to 0.5 m beside the knee, need 330",
        velocity: 2.0,
    },
];

/// Joint angles while it stands: coxa, thigh and knee of two links that reach from the thigh's
/// axis to the middle of the foot's ball.
///
///   cos(π + knee) = (thigh² + shank² − d²) / (2 thigh shank)
pub fn standing() -> [f64; 3] {
    let out = STANCE_RADIUS - HIP_RADIUS - COXA;
    let down = STANCE_HEIGHT - FOOT_RADIUS;
    let d2 = out * out + down * down;
    let at_knee = ((THIGH * THIGH + SHANK * SHANK - d2) / (2.0 * THIGH * SHANK)).acos();
    let at_hip = ((THIGH * THIGH + d2 - SHANK * SHANK) / (2.0 * THIGH * d2.sqrt())).acos();
    [
        0.0,
        at_hip - down.atan2(out),
        at_knee - std::f64::consts::PI,
    ]
}
