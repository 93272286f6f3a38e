//! Whether a robot's base looks where the robot looks.

use nalgebra::{Isometry3, Point3};

use crate::{Kinematics, PatchKind, Robot};

/// Part of a sole's length by which its middle must lie behind the ankle to tell.
const TELLS: f64 = 0.1;

/// Whether the base's x looks backward, as an iCub's does: every sole reaches farther behind its ankle, against x,
/// than ahead of it. Balls, and soles about as long to both sides, do not tell, and x is ahead.
pub fn looks_backward(robot: &Robot) -> bool {
    let upright = robot.resting().with_base(&Isometry3::identity());
    let kinematics = Kinematics::new(robot, &upright);
    let soles = robot.patches.iter();
    let mut soles = soles
        .filter(|patch| patch.kind == PatchKind::Area && patch.has_role("foot"))
        .map(|patch| {
            let (X_WC, ankle) = (kinematics.X_WC(patch), kinematics.origin_W[patch.body]);
            let reach = patch.polygon.iter();
            let reach = reach.map(|v| (X_WC * Point3::new(v.x, v.y, 0.0)).x - ankle.x);
            reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            })
        })
        .peekable();
    soles.peek().is_some() && soles.all(|(low, high)| 0.5 * (low + high) < -TELLS * (high - low))
}
