//! A contact is at its place.
//!
//! Fixed, with R = R_WC R_W*ᵀ the rotation from the wanted to the actual frame:
//!
//!   p_WC − p_W* = 0,   ℓ·log R = 0        (ℓ = 0.1 m; with free yaw only its two tilt rows)
//!
//! Within an area of a face F with axes x, y, z:
//!
//!   z·(p_WC − p_WF) = 0,   ℓ·x·z_C = 0,   ℓ·y·z_C = 0,   z·z_C ≥ ½
//!
//! A ball may turn as it likes; of the centre of one with radius r
//!
//!   p_WC − p_W* − s = 0   (fixed),   z·(p_WC − p_WF) − r = 0   (within an area)
//!
//! with s how far it has rolled ([`crate::Rolling`]).

use nalgebra::Vector3;

use super::ANGLE_ARM_M;
use crate::contact::Freedom;
use crate::iterate::{Context, Iterate};
use crate::rolling::left_jacobian_inverse;
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, contact: usize, rows: &mut Rows) {
    let body = ctx.contacts[contact].body;
    let radius = ctx.contacts[contact].radius;
    let X_WC = ctx.X_WC(it, contact);
    let p_WC = X_WC.translation.vector;
    let z_C = X_WC.rotation * Vector3::z();
    let asked = &ctx.problem.contacts[contact];
    let wanted = &asked.X_WC;
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| wanted.rotation * axis);
    match &asked.freedom {
        Freedom::Within(area) => {
            let over = p_WC - area.X_WF.translation.vector;
            let height = z.dot(&over) - radius.unwrap_or(0.0);
            let row = rows.push(Tag::Closure(contact), height, 0.0, 0.0);
            if !row.is_empty() {
                ctx.add_point_gradient(it, body, &p_WC, &z, row);
            }
        }
        _ => {
            let rolled = asked.rolling(ctx.robot()).map(|rolling| {
                let R_WB = it.kinematics.X_WB[body].rotation;
                (rolling.shift_W(&R_WB), rolling.gradient(&R_WB))
            });
            let shift_W = rolled.map_or_else(Vector3::zeros, |(shift_W, _)| shift_W);
            let error = p_WC - wanted.translation.vector - shift_W;
            for k in 0..3 {
                let row = rows.push(Tag::Closure(contact), error[k], 0.0, 0.0);
                if row.is_empty() {
                    continue;
                }
                let direction = Vector3::ith(k, 1.0);
                ctx.add_point_gradient(it, body, &p_WC, &direction, row);
                if let Some((_, gradient)) = &rolled {
                    ctx.add_rotation_gradient(it, body, &-gradient.row(k).transpose(), row);
                }
            }
        }
    }
    if radius.is_some() {
        return;
    }
    if asked.freedom != Freedom::Fixed {
        aligned(ctx, it, contact, &z_C, [&x, &y, &z], rows);
        return;
    }
    let log = (X_WC.rotation * wanted.rotation.inverse()).scaled_axis();
    let gradient = left_jacobian_inverse(&log);
    for k in 0..3 {
        let row = rows.push(Tag::Closure(contact), ANGLE_ARM_M * log[k], 0.0, 0.0);
        if !row.is_empty() {
            let direction = ANGLE_ARM_M * gradient.row(k).transpose();
            ctx.add_rotation_gradient(it, body, &direction, row);
        }
    }
}

/// z_C along z: no part of it along x or y, and not the opposite.
fn aligned(
    ctx: &Context,
    it: &Iterate,
    contact: usize,
    z_C: &Vector3<f64>,
    [x, y, z]: [&Vector3<f64>; 3],
    rows: &mut Rows,
) {
    let body = ctx.contacts[contact].body;
    for axis in [x, y] {
        // d(axis·z_C) = axis·(φ × z_C) = (z_C × axis)·φ
        let row = rows.push(Tag::Closure(contact), ANGLE_ARM_M * axis.dot(z_C), 0.0, 0.0);
        if !row.is_empty() {
            ctx.add_rotation_gradient(it, body, &(ANGLE_ARM_M * z_C.cross(axis)), row);
        }
    }
    let cos = z.dot(z_C);
    if cos < 0.8 {
        let (value, least) = (ANGLE_ARM_M * cos, ANGLE_ARM_M * 0.5);
        let row = rows.push(Tag::Closure(contact), value, least, f64::INFINITY);
        if !row.is_empty() {
            ctx.add_rotation_gradient(it, body, &(ANGLE_ARM_M * z_C.cross(z)), row);
        }
    }
}
