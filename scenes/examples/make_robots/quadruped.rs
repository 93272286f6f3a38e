//! The quadruped; a design of its own, of the size of the machines in use. Units: m, kg, rad, N·m.

use crate::parts::{Link, Robot, Shape, ball_foot, leg};

/// Place of the abduction axes beside the body's middle, ahead and to the side.
pub const HIP: [f64; 2] = [0.33, 0.11];
/// Distance of the thigh's axis from the abduction axis, outward.
pub const ABDUCTION: f64 = 0.10;
/// Length of the thigh, and of the shank from the knee to the middle of the foot's ball.
const BONE: f64 = 0.33;
/// Radius of the foot's ball.
pub const FOOT_RADIUS: f64 = 0.015;
/// Friction of rubber feet on dry wood, concrete or carpet.
const FRICTION: f64 = 0.9;
/// Height of the abduction axes over the ground while it stands.
pub const STANCE_HEIGHT: f64 = 0.55;

/// Mass of the body with its battery and computers.
const BODY_KG: f64 = 25.2;
/// Mass of the lidar.
const LIDAR_KG: f64 = 0.8;
/// Masses of hip, thigh and shank: the drives of hip and knee sit at the hip. All in all 50 kg.
const LEG_KG: [f64; 3] = [2.5, 2.6, 0.9];
/// Where the lidar's optical centre is on the head, over the front hips.
const LIDAR: [f64; 3] = [0.36, 0.0, 0.20];

/// Name of each leg, and the signs of its hip's place.
pub const LEGS: [(&str, [f64; 2]); 4] = [
    ("front_left", [1.0, 1.0]),
    ("rear_left", [-1.0, 1.0]),
    ("rear_right", [-1.0, -1.0]),
    ("front_right", [1.0, -1.0]),
];

const ABOUT: &str = "
     A quadruped of 12 joints on ball feet, of the size and strength of the machines in use, with
     a VLP-16 on its head.

     Masses are of 50 kg in all; inertias are those of homogeneous boxes of the links' sizes.
     Every frame has the body's axes while the joints are at zero, legs straight down: x forward,
     y left, z up. \"vlp16\" is the lidar's optical centre, x ahead, z along its spin axis.
     Units: m, kg, rad, N m.
";

/// In the body's frame (x forward, y left, z up): positive hip angles swing the leg to the left,
/// positive thigh angles backward; the knee bends forward below the thigh.
const JOINTS: &str = "
    hip   | 1 0 0 | -0.75 |  0.75 | 150 | 10 | of its class of machines; half the weight on a bent leg needs 60
    thigh | 0 1 0 | -1.0  |  3.5  | 150 | 10 | of its class of machines; half the weight on a bent leg needs 60
    knee  | 0 1 0 | -2.6  | -0.6  | 150 | 10 | of its class of machines; half the weight on a bent leg needs 60
";

/// Joint angles while it stands, the feet below the thighs' axes: two links of one length.
///
///   2 · bone · cos θ = height − radius
fn standing() -> [f64; 3] {
    let thigh = ((STANCE_HEIGHT - FOOT_RADIUS) / (2.0 * BONE)).acos();
    [0.0, thigh, -2.0 * thigh]
}

fn body() -> Link {
    let box_ = Shape::Box([0.0; 3], [0.56, 0.22, 0.16]);
    // The head carries the lidar: a drum of 0.103 m by 0.072 m.
    let neck = Shape::Box([LIDAR[0] - 0.02, 0.0, 0.08], [0.10, 0.10, 0.16]);
    let lidar = Shape::AlongZ(LIDAR, 0.072, 0.0515);
    let mass = BODY_KG + LIDAR_KG;
    let com = LIDAR.map(|x| x * LIDAR_KG / mass);
    Link::solid("body", mass, com, [0.60, 0.24, 0.18]).with(&[box_, neck, lidar])
}

/// Thigh or shank, drawn short of the joint beyond it, where the next one turns.
fn bone(name: &str, mass_kg: f64, width: f64, end: &[Shape]) -> Link {
    let middle = [0.0, 0.0, -0.5 * BONE];
    let short = [0.0, 0.0, -0.5 * BONE + 0.01];
    let drawn = Shape::AlongZ(short, BONE - 0.06, 0.5 * width);
    Link::solid(name, mass_kg, middle, [width, width, BONE]).with(&[&[drawn], end].concat())
}

pub fn robot() -> Robot {
    let mut links = vec![body()];
    let end = [0.0, 0.0, -BONE];
    for (name, [front, left]) in LEGS {
        let out = left * ABDUCTION;
        let middle = [0.0, 0.5 * out, 0.0];
        let drive = Shape::AlongY(middle, ABDUCTION - 0.03, 0.05);
        let hip = Link::solid("hip", LEG_KG[0], middle, [0.10, ABDUCTION, 0.10]);
        let thigh = bone("thigh", LEG_KG[1], 0.07, &[]);
        let shank = bone("shank", LEG_KG[2], 0.04, &[Shape::Ball(end, FOOT_RADIUS)]);
        let at_hip = [front * HIP[0], left * HIP[1], 0.0];
        let bones = [
            (hip.with(&[drive]), at_hip, [0.0; 3]),
            (thigh, [0.0, out, 0.0], [0.0; 3]),
            (shank, end, [0.0; 3]),
        ];
        links.extend(leg(name, JOINTS, bones, end));
    }
    links.push(Link::frame("vlp16").on("vlp16_mount", "body", LIDAR, [0.0; 3]));
    Robot {
        name: "quadruped",
        about: ABOUT,
        links,
        posture: ("standing", standing().repeat(4)),
        overlapping: Vec::new(),
        about_patches: "the balls at the ends of the shanks",
        patches: LEGS
            .map(|(leg, _)| ball_foot(leg, FOOT_RADIUS, FRICTION))
            .into(),
    }
}
