//! Contacts anywhere on convex polygons with bodies behind them; solvable by a witness.
#![allow(non_snake_case)]

use std::f64::consts::TAU;

use nalgebra::{Point2, Point3, Translation3};
use robot_model::collision::World;
use surfaces::{ConvexPolygon, Surface};

use super::draw::Draws;
use super::place::{Touch, rows};
use super::record::{BODY_M, ContactRecord, ProblemRecord, SurfaceRecord};
use super::{Maker, easy};

/// Distance of the witness's patch from the edge of its polygon, m; the planner's is 0.005.
const EDGE_M: f64 = 0.01;
/// How often the surfaces around a witness are drawn anew.
const LAYOUTS: usize = 12;

pub(super) fn draw(maker: &Maker, draws: &mut Draws) -> Option<ProblemRecord> {
    let (q, touches, mu) = easy::witness(maker, draws)?;
    let surfaces = (0..LAYOUTS).find_map(|_| {
        let surfaces: Vec<Surface> = touches
            .iter()
            .enumerate()
            .map(|(k, touch)| around(maker, touch, k, draws))
            .collect::<Option<_>>()?;
        let bodies: Vec<Vec<Point3<f64>>> = surfaces
            .iter()
            .map(|s| s.thin_body(BODY_M).points_W)
            .collect();
        let world = World::new(&bodies).ok()?;
        maker.is_clear_of(&world, &q, &touches).then_some(surfaces)
    })?;
    let mut problem = maker.fixed(&touches, mu);
    for (contact, surface) in problem.contacts.iter_mut().zip(&surfaces) {
        *contact = ContactRecord {
            p: None,
            R: None,
            yaw_free: false,
            surface: Some(surface.id.clone()),
            ..contact.clone()
        };
    }
    problem.surfaces = surfaces.iter().map(record).collect();
    Some(maker.witnessed(problem, &q))
}

/// A surface through the touched place, larger than the patch, which lies anywhere in it. Its
/// axes are those of the patch.
fn around(maker: &Maker, touch: &Touch, k: usize, draws: &mut Draws) -> Option<Surface> {
    let patch = &maker.robot.patches[touch.limb.patch];
    let radius = patch
        .polygon
        .iter()
        .map(|v| v.coords.norm())
        .fold(0.0, f64::max);
    // Vertices on an ellipse around the patch.
    let [a, b] = [(); 2].map(|()| radius + EDGE_M + draws.between(0.03, 0.25));
    let n = 4 + draws.index(4);
    let turned = draws.between(0.0, TAU);
    let shift = Point2::new(draws.between(-0.5, 0.5) * a, draws.between(-0.5, 0.5) * b);
    let vertices: Vec<Point2<f64>> = (0..n)
        .map(|i| {
            let (sin, cos) =
                (turned + TAU * (i as f64 + draws.between(-0.3, 0.3)) / n as f64).sin_cos();
            Point2::new(shift.x + a * cos, shift.y + b * sin)
        })
        .collect();
    let polygon = ConvexPolygon::hull(&vertices).ok()?;
    let inside = polygon.inset(EDGE_M)?;
    if !patch.polygon.iter().all(|v| inside.contains(v, 0.0)) {
        return None;
    }
    // The origin moves to the polygon's centroid, as a surface's is.
    let c = polygon.centroid();
    let moved = polygon
        .vertices()
        .iter()
        .map(|v| Point2::from(v - c))
        .collect();
    let X_WS = touch.X_WS * Translation3::new(c.x, c.y, 0.0);
    Some(Surface::new(
        format!("s{k}"),
        X_WS,
        ConvexPolygon::new(moved).ok()?,
    ))
}

fn record(surface: &Surface) -> SurfaceRecord {
    SurfaceRecord {
        id: surface.id.clone(),
        p: surface.X_WS.translation.vector.into(),
        R: rows(&surface.X_WS.rotation.to_rotation_matrix()),
        polygon_m: surface
            .polygon
            .vertices()
            .iter()
            .map(|v| [v.x, v.y])
            .collect(),
    }
}
