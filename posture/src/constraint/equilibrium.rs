//! Forces and moments balance the weight (forces over the weight, moments about the CoM c):
//!
//!   Σ f_i − (0, 0, 1) = 0,   Σ (p_i − c) × f_i = 0
//!
//! The point p_i that a ball touches moves as the ball's centre does.

use nalgebra::Vector3;

use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, rows: &mut Rows) {
    let c = it.kinematics.com_W;
    // (contact, column, point, force) and the point of the body that moves as the first does
    type Point = (usize, usize, Vector3<f64>, Vector3<f64>);
    let mut points: Vec<(Point, Vector3<f64>)> = Vec::new();
    for (contact, columns) in ctx.layout.force.iter().enumerate() {
        for (v, &column) in ctx.contacts[contact].force_points.iter().zip(columns) {
            let p_W = ctx.patch_point_W(it, contact, v);
            let f_W = ctx.force_W(it, contact, column);
            let carried_W = ctx.carried_point_W(it, contact, v);
            points.push(((contact, column, p_W, f_W), carried_W));
        }
    }
    let total: Vector3<f64> = points.iter().map(|((_, _, _, f), _)| f).sum();
    let balance: Vector3<f64> = -Vector3::z();
    for k in 0..3 {
        let row = rows.push(Tag::Equilibrium, total[k] + balance[k], 0.0, 0.0);
        if row.is_empty() {
            continue;
        }
        for ((contact, column, _, _), _) in &points {
            for j in 0..3 {
                row[column + j] = ctx.contacts[*contact].axes[(k, j)];
            }
        }
    }
    let moments = points.iter().map(|((_, _, p, f), _)| (p - c).cross(f));
    let moment: Vector3<f64> = moments.sum();
    for k in 0..3 {
        let row = rows.push(Tag::Balance, moment[k], 0.0, 0.0);
        if row.is_empty() {
            continue;
        }
        let e = Vector3::ith(k, 1.0);
        for ((contact, column, p, f), carried) in &points {
            // e·((p − c) × (A φ)) = ((e × (p − c))ᵀ A) φ
            let lever = e.cross(&(p - c));
            for j in 0..3 {
                row[column + j] += lever.dot(&ctx.contacts[*contact].axes.column(j));
            }
            // e·(dp × f) = (f × e)·dp
            ctx.add_point_gradient(it, ctx.contacts[*contact].body, carried, &f.cross(&e), row);
        }
        ctx.add_com_gradient(it, &(-total.cross(&e)), row);
    }
}
