//! The constraints, one a file; each writes its rows at an iterate.

mod base_goal;
mod base_tilt;
mod clearance;
mod closure;
mod equilibrium;
mod friction;
mod inclusion;
mod torque;

pub(crate) use clearance::Clearances;
pub(crate) use torque::Torques;

use crate::iterate::{Context, Iterate};
use crate::rows::Rows;

/// Lever arm that turns an angle into a length where both share a tolerance, m.
pub(crate) const ANGLE_ARM_M: f64 = 0.1;

/// Working memory of the constraints that need some.
#[derive(Default)]
pub(crate) struct Scratch {
    pub torques: Torques,
    pub clearances: Clearances,
}

/// Writes the rows of every constraint at the iterate.
pub(crate) fn all(ctx: &Context, it: &Iterate, scratch: &mut Scratch, rows: &mut Rows) {
    let load = friction::Load::new(ctx, it, rows);
    for contact in 0..ctx.contacts.len() {
        if !ctx.relaxed.place(contact) {
            closure::rows(ctx, it, contact, rows);
            inclusion::rows(ctx, it, contact, rows);
        }
        friction::rows(ctx, it, contact, &load, rows);
    }
    if !ctx.relaxed.equilibrium {
        equilibrium::rows(ctx, it, rows);
    }
    scratch.torques.rows(ctx, it, rows);
    scratch.clearances.rows(ctx, it, rows);
    base_tilt::rows(ctx, it, rows);
    base_goal::rows(ctx, it, rows);
}

/// Writes the rows of what the robot touches and of the goal.
pub(crate) fn touching(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    for contact in 0..ctx.contacts.len() {
        closure::rows(ctx, it, contact, rows);
        inclusion::rows(ctx, it, contact, rows);
    }
    base_goal::rows(ctx, it, rows);
}
