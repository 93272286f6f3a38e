//! Surfaces and obstacles in the page.

use serde_json::{Value, json};
use surfaces::{Obstacle, Surface};

use super::number::{metres, plane_points, point, pose};

/// A surface with what the page would have to compute from it.
pub(super) fn record(surface: &Surface) -> Value {
    let normal = surface.normal_W();
    let outline: Vec<Vec<[f64; 2]>> = surface
        .outline
        .iter()
        .map(|ring| ring.iter().map(|p| p.map(metres)).collect())
        .collect();
    json!({
        "id": surface.id,
        "source": surface.source,
        "X_WS": pose(&surface.X_WS),
        "polygon": plane_points(surface.polygon.vertices()),
        "effective": surface.effective_polygon().map(|p| plane_points(p.vertices())),
        "outline": outline,
        "outline_edges": surface.outline_edges,
        "vertices_W": surface.vertices_W().iter().map(point).collect::<Vec<_>>(),
        "inset_m": surface.inset_m,
        "inliers": surface.inliers,
        "rms_m": surface.rms_m,
        "area_m2": surface.polygon.area(),
        "tilt_rad": normal.z.clamp(-1.0, 1.0).acos(),
    })
}

/// A body that is only avoided.
pub(super) fn obstacle(obstacle: &Obstacle) -> Value {
    json!({
        "id": obstacle.id,
        "points_W": obstacle.points_W.iter().map(point).collect::<Vec<_>>(),
    })
}
