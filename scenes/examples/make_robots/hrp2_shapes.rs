//! The robot's bulk: collision shapes and inertias, estimated from its outer size.
//!
//! Tables are for the left side; the right side is mirrored in y.

use crate::parts::Shape;

/// A box from its lower to its upper corner.
fn block(a: [f64; 3], b: [f64; 3]) -> Shape {
    Shape::Box(
        [0, 1, 2].map(|i| (a[i] + b[i]) / 2.0),
        [0, 1, 2].map(|i| b[i] - a[i]),
    )
}

/// A cylinder along z: its axis, its lower and upper end, its radius.
fn rod([x, y]: [f64; 2], [low, high]: [f64; 2], radius: f64) -> Shape {
    Shape::AlongZ([x, y, (low + high) / 2.0], high - low, radius)
}

fn mirrored(shape: Shape) -> Shape {
    let turn = |[x, y, z]: [f64; 3]| [x, -y, z];
    match shape {
        Shape::Box(middle, edges) => Shape::Box(turn(middle), edges),
        Shape::AlongZ(middle, length, radius) => Shape::AlongZ(turn(middle), length, radius),
        Shape::Ball(middle, radius) => Shape::Ball(turn(middle), radius),
        other => other,
    }
}

/// Collision shapes of a link: one or two primitives, none on the small links inside a joint.
pub fn collision(link: &str) -> Vec<Shape> {
    let left: Vec<Shape> = match generic(link) {
        // Waist: starts above the thighs' sweep, so that a thigh may rise to 115 degrees.
        "BODY" => vec![block([-0.13, -0.13, 0.13], [0.09, 0.13, 0.32])],
        // Chest with the computer's box on its back.
        "CHEST_LINK1" => vec![block([-0.19, -0.16, -0.02], [0.10, 0.16, 0.26])],
        "HEAD_LINK1" => vec![Shape::Ball([0.01, 0.0, 0.08], 0.115)],
        // The legs hang outside their hips: the thigh's CoM is 78 mm out, the shank's 58 mm.
        "LEG_LINK2" => vec![rod([0.0, 0.075], [-0.26, 0.0], 0.07)],
        "LEG_LINK3" => vec![
            Shape::Ball([0.0, 0.05, 0.0], 0.065),
            rod([0.01, 0.045], [-0.25, 0.0], 0.055),
        ],
        "LEG_LINK5" => vec![
            block([-0.100, -0.056, -0.105], [0.130, 0.075, -0.055]),
            block([-0.050, -0.040, -0.055], [0.050, 0.040, 0.030]),
        ],
        "ARM_LINK1" => vec![Shape::Ball([0.0, 0.0, 0.0], 0.07)],
        "ARM_LINK2" => vec![rod([0.0, 0.0], [-0.23, -0.03], 0.05)],
        "ARM_LINK3" => vec![rod([0.0, 0.0], [-0.20, 0.02], 0.045)],
        // The closed fist; its lower face carries the hand patch.
        "ARM_LINK5" => vec![block([-0.035, -0.035, -0.20], [0.035, 0.035, -0.02])],
        "ARM_LINK6" => vec![block([0.005, -0.025, -0.08], [0.035, 0.025, 0.0])],
        _ => vec![],
    };
    if link.starts_with('R') {
        left.into_iter().map(mirrored).collect()
    } else {
        left
    }
}

/// Edges of the homogeneous box whose inertia stands for the link's, m.
pub fn inertia_box(link: &str) -> [f64; 3] {
    match generic(link) {
        "BODY" => [0.23, 0.26, 0.24],
        "LEG_LINK0" => [0.10, 0.10, 0.14],
        "LEG_LINK1" => [0.10, 0.12, 0.10],
        "LEG_LINK2" => [0.14, 0.14, 0.32],
        "LEG_LINK3" => [0.12, 0.12, 0.32],
        "LEG_LINK4" => [0.08, 0.08, 0.08],
        "LEG_LINK5" => [0.23, 0.131, 0.08],
        "CHEST_LINK0" => [0.10, 0.18, 0.08],
        "CHEST_LINK1" => [0.29, 0.32, 0.28],
        "HEAD_LINK0" => [0.08, 0.08, 0.06],
        "HEAD_LINK1" => [0.20, 0.18, 0.20],
        "ARM_LINK0" | "ARM_LINK1" => [0.11, 0.11, 0.11],
        "ARM_LINK2" => [0.10, 0.10, 0.27],
        "ARM_LINK3" => [0.09, 0.09, 0.22],
        "ARM_LINK4" => [0.07, 0.07, 0.12],
        "ARM_LINK5" => [0.07, 0.07, 0.18],
        _ => [0.03, 0.05, 0.08],
    }
}

/// The link's name without its side.
fn generic(link: &str) -> &str {
    match link.strip_prefix(['L', 'R']) {
        Some(rest) if rest.starts_with("LEG_") || rest.starts_with("ARM_") => rest,
        _ => link,
    }
}
