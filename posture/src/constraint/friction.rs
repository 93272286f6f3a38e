//! A contact pushes, and inside a pyramid inscribed in its friction cone, of the axes that `layout` turns along
//! the contact's load as far as that is known before:
//!
//!   t·f_t ≤ μ cos(π/n) f_z      for the outward directions t of the n sides   (in the contact's axes)
//!
//! On balls alone the same holds of f less the load that gives the centre of mass its margin.

use nalgebra::Point2;

use crate::iterate::{Context, Iterate};
use crate::least_load::least_load;
use crate::rows::{Rows, Tag};

pub(super) fn rows(ctx: &Context, it: &Iterate, contact: usize, load: &Load, rows: &mut Rows) {
    let mu = ctx.pyramid.part * ctx.contacts[contact].mu;
    for &column in &ctx.layout.force[contact] {
        let k = column - ctx.layout.nq;
        // The sides imply f_z ≥ 0.
        for &side in &ctx.pyramid.sides {
            let share = ctx.up_inside(contact, side, mu);
            let [x, y] = side;
            let along = x * it.force[k] + y * it.force[k + 1];
            let value = mu * it.force[k + 2] - along - share * load.value;
            let row = rows.push(Tag::Friction(contact), value, 0.0, f64::INFINITY);
            if !row.is_empty() {
                for (row, slope) in row.iter_mut().zip(&load.gradient) {
                    *row -= share * slope;
                }
                row[column..column + 3].copy_from_slice(&[-x, -y, mu]);
            }
            rows.harden_last();
        }
    }
}

/// Part of the weight that every ball must be able to do without, where the balls are at an iterate,
/// or at their fixed places; zero where not all that is loaded are balls.
#[derive(Default)]
pub(super) struct Load {
    value: f64,
    /// By the columns; empty where it is not wanted.
    gradient: Vec<f64>,
}

impl Load {
    /// At an iterate; with its gradient if the rows have coefficients.
    pub fn new(ctx: &Context, it: &Iterate, rows: &Rows) -> Self {
        if !ctx.on_balls_alone {
            return Self::default();
        }
        let contacts = &ctx.problem.contacts;
        let loaded = (0..contacts.len()).filter(|i| contacts[*i].loaded);
        let loaded: Vec<usize> = loaded.collect();
        let origin = Point2::origin();
        let moves = |i: usize| contacts[i].area().is_some() || contacts[i].stood_WB.is_some();
        let place = |&i: &usize| match moves(i) {
            false => {
                let patch = &ctx.robot().patches[contacts[i].patch];
                patch.touched_W(&contacts[i].X_WC).xy()
            }
            true => ctx.patch_point_W(it, i, &origin).xy(),
        };
        let places: Vec<_> = loaded.iter().map(place).collect();
        let (value, by_place) = least_load(&places, ctx.config.com_margin_m);
        let mut gradient = Vec::new();
        if rows.with_jacobian {
            gradient.resize(rows.n, 0.0);
            for (&i, slope) in loaded.iter().zip(&by_place) {
                if moves(i) {
                    let p = ctx.carried_point_W(it, i, &origin);
                    let body = ctx.contacts[i].body;
                    ctx.add_point_gradient(it, body, &p, &slope.push(0.0), &mut gradient);
                }
            }
        }
        Self { value, gradient }
    }
}
