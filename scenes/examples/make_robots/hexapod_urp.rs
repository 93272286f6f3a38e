//! The hexapod with a universal joint at each hip and a leg that slides. Units: m, kg, rad, N, N·m.

use crate::hexapod::{FOOT_RADIUS, FRICTION, HIP_RADIUS, LEGS, STANCE_HEIGHT, STANCE_RADIUS, body};
use crate::parts::{Link, Robot, Shape, ball_foot, leg};

/// Shortest leg, from the hip to the middle of the foot's ball.
const SHORTEST: f64 = 0.718;
/// Angle of the leg below the horizontal where both angles of its hip are zero; an estimate, the
/// middle of the known heights.
const DOWN: f64 = 0.85;
/// Length of the rod that slides out of the tube, to the middle of the foot's ball; an estimate.
const ROD: f64 = 0.42;

const LINKS: [&str; 3] = ["yoke", "tube", "rod"];
/// Their masses: 10 kg a leg, its division an estimate.
const LINK_KG: [f64; 3] = [1.0, 5.5, 3.5];
/// Begin, length and radius of the cylinders along the leg that the links are drawn as.
const CYLINDERS: [[f64; 3]; 3] = [
    [-0.02, 0.04, 0.04],
    [0.07, 0.52, 0.05],
    [0.02, ROD - 0.04, 0.025],
];

const ABOUT: &str = "
     A hexapod of 18 joints on ball feet: a universal joint at the hip and a leg that slides, the
     tree that stands for the parallel legs (one universal-prismatic limb and two
     universal-prismatic-spherical ones) of a heavy walking machine.

     Known:     hips on a circle of 0.208 m, feet on one of 0.78 m; hip angles of 0.7 and 0.6 rad
                to either side; legs from 0.718 m, with a stroke of 0.41 m; 140 kg of body and
                10 kg a leg; screws of 3.3 kN.
     Estimated: the direction of the leg at zero angles, the hip's torques (with their reason), the
                division of a leg's mass, every inertia (of a homogeneous box of the link's size),
                every shape.
     Leg frames: x along the leg, z up from it. Units: m, kg, rad, N, N m.
";

/// In the leg's frame (x along it, z up from it); positive lift lifts.
const JOINTS: &str = "
    swing | 0 0 1  | -0.7 | 0.7  | 600  | 1   | estimate: 654 N across the foot of a leg of 0.87 m need 570
    lift  | 0 -1 0 | -0.6 | 0.6  | 600  | 1   | estimate: 654 N up on a foot 0.57 m beside the hip need 380
    slide | 1 0 0  | 0    | 0.41 | 3300 | 0.4 | known: one screw of 3.3 kN along the leg; the others steer it
";

/// Joint values while it stands.
fn standing() -> [f64; 3] {
    let (out, down) = (STANCE_RADIUS - HIP_RADIUS, STANCE_HEIGHT - FOOT_RADIUS);
    [0.0, DOWN - down.atan2(out), down.hypot(out) - SHORTEST]
}

pub fn robot() -> Robot {
    let mut links = vec![body()];
    let end = [ROD, 0.0, 0.0];
    let link = |i: usize| {
        let [begin, length, radius] = CYLINDERS[i];
        let middle = [begin + 0.5 * length, 0.0, 0.0];
        let mut shapes = vec![Shape::AlongX(middle, length, radius)];
        if i == 2 {
            shapes.push(Shape::Ball(end, FOOT_RADIUS));
        }
        let edges = [length, 2.0 * radius, 2.0 * radius];
        Link::solid(LINKS[i], LINK_KG[i], middle, edges).with(&shapes)
    };
    for (name, degrees) in LEGS {
        let heading = degrees.to_radians();
        let (sin, cos) = heading.sin_cos();
        let hip = [HIP_RADIUS * cos, HIP_RADIUS * sin, 0.0];
        let parts = [
            (link(0), hip, [0.0, DOWN, heading]),
            (link(1), [0.0; 3], [0.0; 3]),
            (link(2), [SHORTEST - ROD, 0.0, 0.0], [0.0; 3]),
        ];
        links.extend(leg(name, JOINTS, parts, end));
    }
    Robot {
        name: "hexapod_urp",
        about: ABOUT,
        links,
        posture: ("standing", standing().repeat(6)),
        overlapping: Vec::new(),
        about_patches: "the balls at the ends of the legs",
        patches: LEGS
            .map(|(leg, _)| ball_foot(leg, FOOT_RADIUS, FRICTION))
            .into(),
    }
}
