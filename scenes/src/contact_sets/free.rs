//! Contacts anywhere on convex polygons with bodies behind them; solvable by a witness.

use std::f64::consts::TAU;

use nalgebra::{Point2, Point3, Translation3};
use robot_model::collision::World;
use surfaces::{ConvexPolygon, Face, Region};

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
    let faces = (0..LAYOUTS).find_map(|_| {
        let places = touches.iter().enumerate();
        let faces = places.map(|(k, touch)| around(maker, touch, k, draws));
        let faces: Vec<Face> = faces.collect::<Option<_>>()?;
        let bodies = faces.iter().flat_map(|face| face.bodies_W(BODY_M));
        let bodies: Vec<Vec<Point3<f64>>> = bodies.collect();
        let world = World::new(&bodies).ok()?;
        maker.is_clear_of(&world, &q, &touches).then_some(faces)
    })?;
    let mut problem = maker.fixed(&touches, mu);
    for (contact, face) in problem.contacts.iter_mut().zip(&faces) {
        *contact = ContactRecord {
            p: None,
            R: None,
            yaw_free: false,
            surface: Some(face.id.to_string()),
            ..contact.clone()
        };
    }
    problem.surfaces = faces.iter().map(record).collect();
    Some(maker.witnessed(problem, &q))
}

/// A convex face through the touched place, larger than the patch, which lies anywhere in it. Its
/// axes are those of the patch.
fn around(maker: &Maker, touch: &Touch, k: usize, draws: &mut Draws) -> Option<Face> {
    let patch = &maker.robot.patches[touch.limb.patch];
    let radii = patch.polygon.iter().map(|v| v.coords.norm());
    let radius = radii.fold(0.0, f64::max);
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
    // The origin moves to the polygon's centroid.
    let c = polygon.centroid();
    let X_WF = touch.X_WS * Translation3::new(c.x, c.y, 0.0);
    let region = Region::from(&polygon).moved(&-c.coords);
    Some(Face::new(format!("s{k}"), X_WF, region))
}

fn record(face: &Face) -> SurfaceRecord {
    let outer = &face.region.rings()[0].vertices;
    SurfaceRecord {
        id: face.id.to_string(),
        p: face.X_WF.translation.vector.into(),
        R: rows(&face.X_WF.rotation.to_rotation_matrix()),
        polygon_m: outer.iter().map(|v| [v.x, v.y]).collect(),
    }
}
