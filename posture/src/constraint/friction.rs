//! A contact pushes, and inside the friction pyramid inscribed in the cone:
//!
//!   f_z ≥ 0,   |f_x| ≤ μ/√2·f_z,   |f_y| ≤ μ/√2·f_z        (in the contact's axes)
//!
//! On balls alone the same holds of f less the load that gives the centre of mass its margin.

use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, contact: usize, rows: &mut Rows) {
    let mu = ctx.contacts[contact].mu_axis;
    for &column in &ctx.layout.force[contact] {
        let k = column - ctx.layout.nq;
        // The four sides imply f_z ≥ 0.
        for axis in 0..2 {
            for sign in [1.0, -1.0] {
                let least = ctx.pyramid_min(it.least_load, contact, axis, sign);
                let value = mu * it.force[k + 2] + sign * it.force[k + axis];
                let row = rows.push(Tag::Friction(contact), value, least, f64::INFINITY);
                if !row.is_empty() {
                    row[column + 2] = mu;
                    row[column + axis] = sign;
                }
                rows.harden_last();
            }
        }
    }
}
