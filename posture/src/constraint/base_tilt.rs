//! The base stays upright, as the reference is:
//!
//!   1 − z_B·z_R ≤ 1 − cos θ_max        (z_R the reference's z axis)

use nalgebra::Vector3;

use super::ANGLE_ARM_M;
use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    let Some(most_rad) = ctx.config.solver.tilt_max_rad else {
        return;
    };
    let z = it.q.R_WB * Vector3::z();
    let upright = ctx.problem.reference.R_WB * Vector3::z();
    let tilt = 1.0 - z.dot(&upright);
    let (tilt, most) = (ANGLE_ARM_M * tilt, ANGLE_ARM_M * (1.0 - most_rad.cos()));
    let row = rows.push(Tag::BaseTilt, tilt, f64::NEG_INFINITY, most);
    if !row.is_empty() {
        // dz = φ × z, so that −dz·z_R = φ·(z_R × z)
        let gradient = ANGLE_ARM_M * upright.cross(&z);
        for k in 0..3 {
            row[3 + k] += gradient[k];
        }
    }
}
