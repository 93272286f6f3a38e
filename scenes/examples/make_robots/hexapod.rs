//! The hexapod of three hinges a leg. Units: m, kg, rad, N·m.

use crate::parts::{Link, Robot, Shape, ball_foot, leg};

/// Distance of the hips from the body's middle.
pub const HIP_RADIUS: f64 = 0.208;
/// Distance of the feet from the body's middle while it stands.
pub const STANCE_RADIUS: f64 = 0.78;
/// Height of the hips over the ground while it stands: the middle of the known heights
/// 0.615, 0.68 and 0.75.
pub const STANCE_HEIGHT: f64 = 0.68;
/// Lengths of the coxa, from the yaw axis to the thigh's, of the thigh, and of the shank, from the
/// knee to the middle of the foot's ball.
const LENGTHS: [f64; 3] = [0.10, 0.45, 0.55];
const WIDTHS: [f64; 3] = [0.09, 0.08, 0.06];
/// Masses of coxa, thigh and shank: 10 kg a leg, its division an estimate.
const LEG_KG: [f64; 3] = [3.0, 4.0, 3.0];
/// Radius of the foot's ball; an estimate. The real feet tilt on a joint and do not roll: the ball is
/// small, so that it rolls little.
pub const FOOT_RADIUS: f64 = 0.02;
/// Friction of the feet on the ground; an estimate.
pub const FRICTION: f64 = 0.6;

/// Name and heading of each leg, degrees.
pub const LEGS: [(&str, f64); 6] = [
    ("front_left", 30.0),
    ("middle_left", 90.0),
    ("rear_left", 150.0),
    ("rear_right", -150.0),
    ("middle_right", -90.0),
    ("front_right", -30.0),
];

const ABOUT: &str = "
     A hexapod of 18 joints on ball feet: coxa, thigh and shank, the tree that stands for the
     parallel legs of a heavy walking machine.

     Known:     hips on a circle of 0.208 m, feet on one of 0.78 m; link lengths 0.10, 0.45 and
                0.55 m; 140 kg of body and 10 kg a leg.
     Estimated: torque limits (each with its reason below), joint limits, the division of a leg's
                mass, every inertia (of a homogeneous box of the link's size), every shape.
     Leg frames: x outward, z up. Units: m, kg, rad, N m.
";

/// In the leg's frame (x outward, z up): positive thigh and knee angles lift; the knee bends down
/// only.
const JOINTS: &str = "
    coxa  | 0 0 1  | -0.8 |  0.8 | 250 | 2 | estimate: 300 N across the foot of a leg of 0.78 m
    thigh | 0 -1 0 | -1.0 |  1.4 | 400 | 2 | estimate: 200 kg on three legs, feet 0.47 m beside the hips, need 300
    knee  | 0 -1 0 | -2.6 | -0.2 | 400 | 2 | estimate: 654 N on a foot up to 0.5 m beside the knee, need 330
";

/// The body of both hexapods.
pub fn body() -> Link {
    let shape = Shape::Box([0.0, 0.0, 0.06], [0.30, 0.30, 0.22]);
    Link::solid("body", 140.0, [0.0, 0.0, 0.05], [0.34, 0.34, 0.25]).with(&[shape])
}

/// Joint angles while it stands: coxa, thigh and knee of two links that reach from the thigh's
/// axis to the middle of the foot's ball.
///
///   cos(π + knee) = (thigh² + shank² − d²) / (2 thigh shank)
fn standing() -> [f64; 3] {
    let [coxa, thigh, shank] = LENGTHS;
    let out = STANCE_RADIUS - HIP_RADIUS - coxa;
    let down = STANCE_HEIGHT - FOOT_RADIUS;
    let d2 = out * out + down * down;
    let at_knee = ((thigh * thigh + shank * shank - d2) / (2.0 * thigh * shank)).acos();
    let at_hip = ((thigh * thigh + d2 - shank * shank) / (2.0 * thigh * d2.sqrt())).acos();
    [
        0.0,
        at_hip - down.atan2(out),
        at_knee - std::f64::consts::PI,
    ]
}

pub fn robot() -> Robot {
    let mut links = vec![body()];
    let end = |i: usize| [LENGTHS[i], 0.0, 0.0];
    let link = |i: usize| {
        let (length, width) = (LENGTHS[i], WIDTHS[i]);
        // Links are drawn short of the joint beyond them, where the next one turns.
        let middle = [0.5 * length - 0.01, 0.0, 0.0];
        let mut shapes = vec![Shape::AlongX(middle, length - 0.06, 0.5 * width)];
        if i == 2 {
            shapes.push(Shape::Ball(end(i), FOOT_RADIUS));
        }
        let (name, com) = (["coxa", "thigh", "shank"][i], [0.5 * length, 0.0, 0.0]);
        Link::solid(name, LEG_KG[i], com, [length, width, width]).with(&shapes)
    };
    for (name, degrees) in LEGS {
        let heading = degrees.to_radians();
        let (sin, cos) = heading.sin_cos();
        let hip = [HIP_RADIUS * cos, HIP_RADIUS * sin, 0.0];
        let bones = [
            (link(0), hip, [0.0, 0.0, heading]),
            (link(1), end(0), [0.0; 3]),
            (link(2), end(1), [0.0; 3]),
        ];
        links.extend(leg(name, JOINTS, bones, end(2)));
    }
    Robot {
        name: "hexapod",
        about: ABOUT,
        links,
        posture: ("standing", standing().repeat(6)),
        overlapping: Vec::new(),
        about_patches: "the balls at the ends of the shanks",
        patches: LEGS
            .map(|(leg, _)| ball_foot(leg, FOOT_RADIUS, FRICTION))
            .into(),
    }
}
