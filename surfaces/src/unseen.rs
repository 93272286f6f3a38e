//! Space of which nothing was seen, as far as a thing could go on there: behind faces, and beyond the border of the view.
//!
//! A ray ends on a face; what it would have met behind is hidden. So a face's body goes on behind it along
//! the rays that saw it ([`Face::bodies_W`]): exactly what the view does not show, and nothing of what it looked
//! through. Where the border of the view cuts a face, it goes on in its plane, straight along the edges that lead to
//! the border. What another view saw there ends both.
#![allow(non_snake_case)]

use nalgebra::{Point2, Point3, Vector2};

use crate::conservative_bodies::TOUCH_M;
use crate::cover::{self, cover};
use crate::free_space::{BEHIND_MIN_M, FreeSpace, SIGMAS};
use crate::outline::Outline;
use crate::{ConvexPolygon, EdgeKind, Face, Obstacle, Ring, Source};

/// Shorter edges are corners that were rounded off, m.
const EDGE_MIN_M: f64 = 0.03;
/// A rounded corner is this near to the sharp one, m.
const CORNER_M: f64 = 0.1;
/// An edge that leads to the border at a flatter angle does not tell how the face goes on (its sine).
const FLAT: f64 = 0.25;
/// What is smaller is not worth a body, m².
const SPECK_M2: f64 = 0.002;

/// Makes bodies behind scanned faces `depth_m` deep along the rays, or as deep as none of the views saw anything
/// there; and returns bodies beyond the border of the view, which reach `reach_m` far.
///
/// Units: m.  Frames: W.
pub fn fill_unseen(
    faces: &mut [Face],
    views: &[FreeSpace],
    depth_m: f64,
    reach_m: f64,
) -> Vec<Obstacle> {
    let scanned = |face: &&mut Face| face.source == Source::Scan;
    let mut bodies = Vec::new();
    for face in faces.iter_mut().filter(scanned) {
        if let Some(view) = face.views.first() {
            face.depth_m = hidden_m(face, &view.eye_W, views, depth_m);
        }
        if reach_m > 0.0 && depth_m > 0.0 {
            bodies.extend(beyond(face, views, depth_m, reach_m));
        }
    }
    bodies
}

/// The point that is `depth_m` behind another, as seen from the eye.
pub(crate) fn behind_W(p_W: &Point3<f64>, eye_W: &Point3<f64>, depth_m: f64) -> Point3<f64> {
    p_W + (p_W - eye_W).try_normalize(0.0).unwrap_or_default() * depth_m
}

/// How deep nothing was seen behind a face along the rays from an eye, `most_m` at most.
fn hidden_m(face: &Face, eye_W: &Point3<f64>, views: &[FreeSpace], most_m: f64) -> f64 {
    let X_FW = face.X_WF.inverse();
    let eye = X_FW * eye_W;
    let seen = views.iter().flat_map(|view| &view.points);
    // Only another view sees what this one does not.
    if views.len() < 2 || eye.z <= 0.0 {
        return most_m;
    }
    let inside = face.inset_region(0.0, TOUCH_M);
    let deep = seen.filter_map(|seen| {
        let p = X_FW * seen.p_W;
        let margin = BEHIND_MIN_M + SIGMAS * seen.sigma_m;
        let at = eye + (p - eye) * (eye.z / (eye.z - p.z));
        let past_m = (p - at).norm();
        (p.z < -margin && past_m < most_m && inside.contains(&at.xy())).then_some(past_m)
    });
    deep.fold(most_m, f64::min)
}

/// Bodies where a face goes on beyond the border of the view.
fn beyond(face: &Face, views: &[FreeSpace], depth_m: f64, reach_m: f64) -> Vec<Obstacle> {
    let ring = &face.region.rings()[0];
    let mut bodies = Vec::new();
    for (edge, front) in (0..ring.edges.len()).filter_map(|i| Some((i, front(ring, i, reach_m)?))) {
        let Some(eye_W) = ring.edges[edge].view.and_then(|i| face.views.get(i)) else {
            continue;
        };
        let looked_through = |left: Outline, view: &FreeSpace| {
            let carved = view.carved(&face.X_WF, &left, &|_| 0.0);
            left.minus(&carved.through)
        };
        let whole = Outline::from_polygon(&front);
        let left = views.iter().fold(whole.clone(), looked_through);
        let pieces = match left == whole {
            true => vec![front],
            false => {
                let regions = left.without_specks(SPECK_M2).regions().into_iter();
                let pieces = regions.flat_map(|region| cover(&region, &cover::BODIES).pieces);
                pieces.map(|piece| piece.polygon).collect()
            }
        };
        for piece in pieces {
            let corners: Vec<_> = piece.vertices().iter().map(|p| face.point_W(p)).collect();
            let behind = corners.iter().map(|p| behind_W(p, &eye_W.eye_W, depth_m));
            bodies.push(Obstacle {
                id: format!("{}/beyond{}", face.id, bodies.len()),
                points_W: corners.iter().copied().chain(behind).collect(),
                surface: None,
                assumed: true,
            });
        }
    }
    bodies
}

/// The part of the plane in which a face goes on beyond edge `i` of a ring, where the border cuts it there.
fn front(ring: &Ring, i: usize, reach_m: f64) -> Option<ConvexPolygon> {
    let count = ring.edges.len();
    let ends = |i: usize| (ring.vertices[i], ring.vertices[(i + 1) % count]);
    let vector = |i: usize| ends(i).1 - ends(i).0;
    if ring.edges[i].kind != EdgeKind::FieldOfView || vector(i).norm() < EDGE_MIN_M {
        return None;
    }
    let outward = |i: usize| Vector2::new(vector(i).y, -vector(i).x).normalize();
    let (a, b) = ends(i);
    // At each end the corner with the neighbour, and where that leads.
    let corner = |end: Point2<f64>, step: usize, sign: f64| {
        let mut others = (1..count).map(|k| (i + k * step) % count);
        let straight = (end, end + outward(i) * reach_m);
        let Some(other) = others.find(|&k| vector(k).norm() >= EDGE_MIN_M) else {
            return straight;
        };
        let (along, toward) = (vector(i), vector(other).normalize() * sign);
        let turn = along.perp(&toward);
        let sharp = end + along * ((ends(other).0 - end).perp(&toward) / turn);
        let end = match (sharp - end).norm() {
            near if near <= CORNER_M => sharp,
            _ => end,
        };
        let along = match ring.edges[other].kind {
            // The border's own corner: both its sides lead there.
            EdgeKind::FieldOfView => (outward(i) + outward(other))
                .try_normalize(FLAT)
                .unwrap_or(outward(i)),
            EdgeKind::Real if toward.dot(&outward(i)) >= FLAT => toward,
            _ => outward(i),
        };
        (end, end + along * reach_m)
    };
    let (a, far_a) = corner(a, count - 1, 1.0);
    let (b, far_b) = corner(b, 1, -1.0);
    // Edges that lead together end the face where they meet.
    let (u, v) = (far_a - a, far_b - b);
    let (s, t) = ((b - a).perp(&v) / u.perp(&v), (b - a).perp(&u) / u.perp(&v));
    let meet = (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
    let far = if meet { [a + u * s; 2] } else { [far_a, far_b] };
    ConvexPolygon::hull(&[&[a, b], &far[..]].concat()).ok()
}

#[cfg(test)]
mod tests;
