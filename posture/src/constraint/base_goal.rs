//! The base is where the goal wants it:
//!
//!   ‖p_WB − p*‖ ≤ tolerance over the coordinates that are wanted,   |ψ − ψ*| ≤ tolerance
//!   (ψ the heading of the base's x)

use nalgebra::Vector3;

use super::ANGLE_ARM_M;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Nearer than this the base is at its goal, m.
const AT_GOAL_M: f64 = 1e-9;

pub(super) fn rows(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    let Some(goal) = &ctx.problem.base_goal else {
        return;
    };
    let mut error = Vector3::zeros();
    for (k, wanted) in goal.position_m.iter().enumerate() {
        error[k] = wanted.map_or(0.0, |wanted| it.q.p_WB[k] - wanted);
    }
    if goal.position_m.iter().any(Option::is_some) {
        let distance = error.norm();
        let row = rows.push(Tag::BaseGoal, distance, f64::NEG_INFINITY, goal.tolerance_m);
        // At the goal itself the distance has no gradient, and the row needs none.
        if !row.is_empty() && distance > AT_GOAL_M {
            for k in 0..3 {
                row[k] = error[k] / distance;
            }
        }
    }
    if let Some(wanted) = goal.yaw_rad {
        let x = it.q.R_WB * Vector3::x();
        let error = wrap(x.y.atan2(x.x) - wanted);
        let tolerance = goal.yaw_tolerance_rad * ANGLE_ARM_M;
        let row = rows.push(Tag::BaseGoal, ANGLE_ARM_M * error, -tolerance, tolerance);
        if !row.is_empty() {
            // dψ = (x_1 dx_2 − x_2 dx_1) / (x_1² + x_2²), dx = φ × x
            let flat = (x.x * x.x + x.y * x.y).max(1e-6);
            let direction = Vector3::new(-x.y, x.x, 0.0) / flat;
            let gradient = ANGLE_ARM_M * x.cross(&direction);
            for k in 0..3 {
                row[3 + k] += gradient[k];
            }
        }
    }
}

/// The angle between −π and π.
pub(crate) fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
