//! The base is where the goal wants it:
//!
//!   |p_WB,k − p*_k| ≤ tolerance,   |ψ − ψ*| ≤ tolerance        (ψ the heading of the base's x)

use nalgebra::Vector3;

use super::ANGLE_ARM_M;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    let Some(goal) = &ctx.problem.base_goal else {
        return;
    };
    for (k, wanted) in goal.position_m.iter().enumerate() {
        let Some(wanted) = wanted else { continue };
        let tolerance = goal.tolerance_m;
        let error = it.q.p_WB[k] - wanted;
        let row = rows.push(Tag::BaseGoal, error, -tolerance, tolerance);
        if !row.is_empty() {
            row[k] = 1.0;
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
