//! A contact's patch is inside its area: for every patch vertex p and every edge of the area
//! with outward normal n and offset b
//!
//!   n·p − b ≤ −margin        (p in the face's plane)
//!
//! Of a ball, p is the point that touches; it moves as the ball's centre does, and the ball's radius
//! adds to the margin, where the area is wide enough for it ([`ball_inset_m`](crate::ball_inset_m)): the ball is over
//! the surface as a whole, clear of what rises at its edge.
//!
//! Source: [brossette2013] Algorithm 1, with unit edge normals so that the value is a distance.

use nalgebra::{Point3, Vector3};

use crate::iterate::{Context, Iterate};
use crate::rows::{Rows, Tag};

/// Vertices farther inside than this get no row: they cannot reach the edge in one step, m.
const NEAR_M: f64 = 0.5;

pub(super) fn rows(ctx: &Context, it: &Iterate, contact: usize, rows: &mut Rows) {
    let Some(area) = ctx.problem.contacts[contact].area() else {
        return;
    };
    let body = ctx.contacts[contact].body;
    let vertices = ctx.contacts[contact].vertices.iter().map(|v| {
        let p_W = ctx.patch_point_W(it, contact, v);
        let p_F = area.X_WF.inverse_transform_point(&Point3::from(p_W)).xy();
        (ctx.carried_point_W(it, contact, v), p_F)
    });
    let vertices: Vec<_> = vertices.collect();
    let margin = ctx.config.patch_margin_m + ctx.contacts[contact].inside_m;
    for edge in area.polygon.half_planes() {
        let n_W = area.X_WF.rotation * Vector3::new(edge.n.x, edge.n.y, 0.0);
        for (carried_W, p_F) in &vertices {
            let value = edge.n.dot(&p_F.coords) - edge.b;
            if value < -margin - NEAR_M {
                continue;
            }
            let row = rows.push(Tag::Inclusion(contact), value, f64::NEG_INFINITY, -margin);
            if !row.is_empty() {
                ctx.add_point_gradient(it, body, carried_W, &n_W, row);
            }
        }
    }
}
