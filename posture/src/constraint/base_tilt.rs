//! The base stays upright:
//!
//!   1 − z_B·z ≤ 1 − cos θ_max        (z the direction that it keeps to)

use nalgebra::Vector3;

use super::ANGLE_ARM_M;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    let Some(upright) = ctx.config.solver.upright else {
        return;
    };
    let z = it.q.R_WB * Vector3::z();
    let most = ANGLE_ARM_M * (1.0 - upright.tilt_max_rad.cos());
    let tilt = ANGLE_ARM_M * (1.0 - z.dot(&upright.z_W));
    let row = rows.push(Tag::BaseTilt, tilt, f64::NEG_INFINITY, most);
    if !row.is_empty() {
        // dz = φ × z, so that −dz·z_W = φ·(z_W × z)
        let gradient = ANGLE_ARM_M * upright.z_W.cross(&z);
        for k in 0..3 {
            row[3 + k] += gradient[k];
        }
    }
}
