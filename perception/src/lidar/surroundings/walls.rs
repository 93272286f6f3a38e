//! Planes that are too steep for slopes.

use nalgebra::{Isometry3, Matrix3, Point2, Point3, Rotation3, UnitQuaternion, Vector3};
use surfaces::{ConvexPolygon, Face, Fit, Source, UNSEEN_DEPTH_M};

use super::{BEYOND_M, CLEAR_M, Upright, View, Wall, bounds, obstacle};
use crate::face::convex;
use crate::lidar::config::LidarConfig;
use crate::lidar::extract_planes::{TRIES, extended};
use crate::lidar::faces::{EDGE_M, VERTICES_MAX, edge};
use crate::lidar::plane::Plane;
use crate::lidar::slopes::{Patch, PatchSearch, patches};

/// Most walls.
const WALLS_MAX: usize = 24;
/// Fewest points of a wall.
const WALL_POINTS_MIN: usize = 120;
/// A wall ends where nothing of it is seen over this width, m.
const WALL_GAP_M: f64 = 0.4;
/// Points of a part of a wall, as a share of the fewest of a wall.
const PART: usize = 4;

/// The walls among the free points; these are free no more.
pub(super) fn walls(view: &View, free: &mut [bool], config: &LidarConfig) -> Vec<Wall> {
    let field = view.field;
    let up = view.ground_V.map_or_else(Vector3::z, |plane| plane.normal);
    let steep = config.inclination_max_rad.cos();
    let wanted = PatchSearch {
        points_min: WALL_POINTS_MIN,
        count_max: WALLS_MAX,
        tries: TRIES,
        over: None,
    };
    // What hangs over is one as well, a ceiling is not.
    let is_steep = |n: &Vector3<f64>| n.dot(&up).abs() < steep;
    let mut open = free.to_vec();
    let found: Vec<Patch> = patches(
        field,
        &mut open,
        &wanted,
        config,
        is_steep,
        |plane| is_steep(&plane.normal),
        |_| true,
    );
    let mut walls = Vec::new();
    for patch in found {
        let members = extended(field, &patch.plane, |i| free[i]);
        let Some(X_WF) = upright_frame(&patch.plane, view) else {
            continue;
        };
        for part in parts(&X_WF, view, members, WALL_GAP_M) {
            if part.len() * PART < WALL_POINTS_MIN {
                continue;
            }
            let number = walls.len();
            if let Some((wall, body)) = wall(view, &patch.plane, &X_WF, &part, number) {
                walls.push(wall);
                // What else is in its body is avoided with it.
                for (i, free) in free.iter_mut().enumerate().filter(|(_, free)| **free) {
                    let p_W = view.X_WV * Point3::from(field.point(i));
                    *free = !body.holds(&p_W, CLEAR_M);
                }
            }
        }
    }
    walls
}

/// The frame of a steep plane: z_F its normal, x_F level, y_F up; the origin below the sensor.
fn upright_frame(plane: &Plane, view: &View) -> Option<Isometry3<f64>> {
    let z = view.X_WV * plane.normal;
    let x = Vector3::z().cross(&z).try_normalize(1e-6)?;
    let R_WS = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    let foot = view.eye() - z * plane.offset_m;
    let rotation = UnitQuaternion::from_rotation_matrix(&R_WS);
    Some(Isometry3::from_parts(foot.into(), rotation))
}

/// The points of a plane, parted where none is seen over a width along it, from x_F = −∞ on.
fn parts(X_WF: &Isometry3<f64>, view: &View, members: Vec<u32>, gap_m: f64) -> Vec<Vec<u32>> {
    let places = view.in_W(&members);
    let across = places.iter().map(|p| X_WF.inverse_transform_point(p).x);
    let mut order: Vec<(f64, u32)> = across.zip(members).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut parts: Vec<Vec<u32>> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (x, i) in order {
        match parts.last_mut() {
            Some(part) if x - last <= gap_m => part.push(i),
            _ => parts.push(vec![i]),
        }
        last = x;
    }
    parts
}

/// The wall of these points, its frame moved to their middle, and the body of all that it may be.
fn wall(
    view: &View,
    plane: &Plane,
    X_WF: &Isometry3<f64>,
    members: &[u32],
    number: usize,
) -> Option<(Wall, Upright)> {
    let places = view.in_W(members);
    let local: Vec<Point3<f64>> = places
        .iter()
        .map(|p| X_WF.inverse_transform_point(p))
        .collect();
    let flat: Vec<Point2<f64>> = local.iter().map(|p| p.xy()).collect();
    let n = flat.len() as f64;
    let middle = flat
        .iter()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n;
    let centred: Vec<Point2<f64>> = flat.iter().map(|p| p - middle).collect();
    let polygon = ConvexPolygon::hull(&centred)
        .ok()?
        .simplified_inside(VERTICES_MAX);
    let X_WM = X_WF * Isometry3::translation(middle.x, middle.y, 0.0);
    let squares: f64 = local.iter().map(|p| p.z * p.z).sum();
    let face = Face {
        fit: Some(Fit {
            points: members.len(),
            rms_m: (squares / n).sqrt(),
        }),
        source: Source::Scan,
        ..Face::new(
            format!("wall{number}"),
            X_WM,
            convex(&polygon, edge(EDGE_M)),
        )
    };
    let heights_m = bounds(places.iter().map(|p| view.height(p)));

    // All of it between its ends: from the ground where no beam goes below, up to where the next beam
    // would be, or on.
    let gap = view.gap_m(members);
    let [lowest, uppermost] = view.ends(members);
    let [low, high] = bounds(places.iter().map(|p| p.z));
    let ground = low - heights_m[0];
    let on_ground = view.ground_V.is_some() && (lowest || heights_m[0] <= gap + CLEAR_M);
    let from = if on_ground { ground } else { low - gap };
    let to = high + if uppermost { BEYOND_M } else { gap };
    let level = Vector3::new(face.normal_W().x, face.normal_W().y, 0.0).try_normalize(1e-6)?;
    let across = Vector3::z().cross(&level);
    let side = bounds(places.iter().map(|p| across.dot(&p.coords)));
    let front = bounds(places.iter().map(|p| level.dot(&p.coords)));
    let body = Upright {
        u: level,
        along: [front[0].min(front[1] - UNSEEN_DEPTH_M), front[1]],
        across: [side[0] - EDGE_M, side[1] + EDGE_M],
        z: [from, to],
    };
    let id = format!("wall{number}/beyond");
    let wall = Wall {
        beyond: obstacle(id, body.corners_W(), Some(face.id.to_string()), false),
        distance_m: plane.offset_m,
        width_m: side[1] - side[0],
        heights_m,
        face,
    };
    Some((wall, body))
}
