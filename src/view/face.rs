//! Faces and obstacles in the page.

use nalgebra::Point2;
use serde_json::{Value, json};
use surfaces::{Face, Obstacle, Ring};

use super::number::{metres, plane_points, point, pose};

/// A face with what the page would have to compute from it.
pub(super) fn record(face: &Face, edge_sigmas: f64) -> Value {
    let normal = face.normal_W();
    let points = |ring: &Ring| plane_points(&ring.vertices);
    let rings = face.region.rings();
    let left = face.inset_region(edge_sigmas, 0.0).regions();
    let insets_m = face.edge_insets_m(edge_sigmas).concat();
    let kinds = |ring: &Ring| ring.edges.iter().map(|e| e.kind).collect::<Vec<_>>();
    let triangle = |t: &[Point2<f64>; 3]| t.map(|p| [p.x, p.y].map(metres));
    json!({
        "id": face.id,
        "source": face.source,
        "friction": face.friction,
        "X_WS": pose(&face.X_WF),
        "triangles": face.region.triangles().iter().map(triangle).collect::<Vec<_>>(),
        "effective": left.iter().flat_map(|r| r.rings()).map(points).collect::<Vec<_>>(),
        "outline": rings.iter().map(points).collect::<Vec<_>>(),
        "outline_edges": rings.iter().map(kinds).collect::<Vec<_>>(),
        "vertices_W": face.vertices_W().iter().map(point).collect::<Vec<_>>(),
        "inset_m": insets_m.into_iter().fold(0.0, f64::max),
        "inliers": face.fit.map_or(0, |fit| fit.points),
        "rms_m": face.fit.map_or(0.0, |fit| fit.rms_m),
        "area_m2": face.region.area(),
        "tilt_rad": normal.z.clamp(-1.0, 1.0).acos(),
    })
}

/// The bodies behind the faces where nothing was seen of what lies there.
pub(super) fn unseen(faces: &[Face], thickness_m: f64) -> Vec<Value> {
    let hidden = faces.iter().filter(|face| face.depth_m > 0.0);
    let bodies = hidden.flat_map(|face| {
        let bodies = face.bodies_W(thickness_m).into_iter();
        bodies.map(
            |body| json!({ "id": face.id, "points_W": body.iter().map(point).collect::<Vec<_>>() }),
        )
    });
    bodies.collect()
}

/// A body that is only avoided.
pub(super) fn obstacle(obstacle: &Obstacle) -> Value {
    json!({
        "id": obstacle.id,
        "assumed": obstacle.assumed,
        "points_W": obstacle.points_W.iter().map(point).collect::<Vec<_>>(),
    })
}
