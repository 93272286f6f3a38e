//! Space of which nothing was seen, as far as a thing could go on there: behind faces, and beyond the border of the view.
//!
//! A ray ends on a face; what it would have met behind is hidden. So a face's body goes on behind it along
//! the rays that saw it ([`Face::bodies_W`]): exactly what the view does not show, and nothing of what it looked
//! through. Where the border of the view cuts a face, it goes on in its plane, straight along the edges that lead to
//! the border. What another view saw there ends both.
#![allow(non_snake_case)]

use nalgebra::{Point2, Point3, Vector2};

use crate::conservative_bodies::{TOUCH_M, behind_W};
use crate::cover::{self, cover};
use crate::free_space::{BEHIND_MIN_M, FreeSpace, SIGMAS};
use crate::outline::Outline;
use crate::{ConvexPolygon, EdgeKind, Face, HalfPlane, Obstacle, Ring, Source};

/// Shorter edges at which the border cuts a face are corners that were rounded off, m.
const CUT_MIN_M: f64 = 0.03;
/// Shorter edges do not tell where others lead: they are known to a pixel or two, m.
const LEAD_MIN_M: f64 = 0.1;
/// A rounded corner is this near to the sharp one, m.
const CORNER_M: f64 = 0.1;
/// Corners this near to a line are on it, m.
const STRAIGHT_M: f64 = 0.02;
/// An edge tells where a face ends for as many times as far as it was seen straight.
const TELLS: f64 = 3.0;
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
    let sides = sides(&face.region.rings()[0]);
    let mut bodies = Vec::new();
    for (i, side) in sides.iter().enumerate() {
        let view = side.view.and_then(|view| face.views.get(view));
        let cut = view.filter(|_| side.kind == EdgeKind::FieldOfView);
        let around = [sides.len() - 1, 1].map(|step| &sides[(i + step) % sides.len()]);
        let front = || {
            side.front(around, reach_m)?
                .clip_all(&ends(&sides, i, reach_m))
        };
        let Some((eye_W, front)) = cut.and_then(|view| Some((view.eye_W, front()?))) else {
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
            let behind = corners.iter().map(|p| behind_W(p, &eye_W, depth_m));
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

/// A straight part of a ring.
struct Side {
    ends: [Point2<f64>; 2],
    kind: EdgeKind,
    view: Option<usize>,
}

/// Where the face ends beyond the border of the view at side `i`: the edges before and after the border go straight on.
fn ends(sides: &[Side], i: usize, reach_m: f64) -> Vec<HalfPlane> {
    let count = sides.len();
    let is_cut = |k: &usize| sides[*k].kind == EdgeKind::FieldOfView;
    let before = (1..count).map(|step| (i + count - step) % count);
    let after = (1..count).map(|step| (i + step) % count);
    let nearest = [
        before.clone().find(|k| !is_cut(k)),
        after.clone().find(|k| !is_cut(k)),
    ];
    let real = nearest.into_iter().flatten().map(|k| &sides[k]);
    let long = real.filter(|s| s.kind == EdgeKind::Real && TELLS * s.vector().norm() >= reach_m);
    let inside = long.map(|side| HalfPlane::left_of(&side.ends[0], &side.ends[1]));
    let leads = |h: &HalfPlane| sides[i].ends.iter().all(|p| h.value(p) <= STRAIGHT_M);
    inside.filter(leads).collect()
}

/// The straight parts of a ring that tell how it goes on, in its order.
fn sides(ring: &Ring) -> Vec<Side> {
    let count = ring.edges.len();
    let kind = |i: usize| ring.edges[i % count].kind;
    let is_cut = |kind: EdgeKind| kind == EdgeKind::FieldOfView;
    let first = (0..count).find(|&i| !is_cut(kind(i)) && is_cut(kind(i + 1)));
    let first = first.unwrap_or(0) + 1;
    let edges = (first..first + count).map(|i| Side {
        ends: [i, i + 1].map(|k| ring.vertices[k % count]),
        kind: kind(i),
        view: ring.edges[i % count].view,
    });
    let is_jag = |side: &Side| side.kind == EdgeKind::Real && side.vector().norm() < LEAD_MIN_M;
    let mut sides = joined(edges, is_jag);
    sides.retain(|side| is_cut(side.kind) || side.vector().norm() >= LEAD_MIN_M);
    let mut sides = joined(sides.into_iter(), |side| is_cut(side.kind));
    sides.retain(|side| side.vector().norm() >= CUT_MIN_M);
    sides
}

/// The sides of which those that may join and follow each other on a line are one.
fn joined(sides: impl Iterator<Item = Side>, joins: impl Fn(&Side) -> bool) -> Vec<Side> {
    let mut joined: Vec<Side> = Vec::new();
    let (mut chain, mut open) = (Vec::new(), false);
    for side in sides {
        let (joins, end) = (joins(&side), side.ends[1]);
        let straight = |start: Point2<f64>| {
            let along = (end - start).normalize();
            let off_m = |p: &Point2<f64>| along.perp(&(p - start)).abs();
            chain.iter().all(|p| off_m(p) <= STRAIGHT_M)
        };
        match joined.last_mut() {
            Some(last) if open && joins && straight(last.ends[0]) => {
                last.ends[1] = end;
                chain.push(end);
            }
            _ => {
                (chain, open) = (vec![end], joins);
                joined.push(side);
            }
        }
    }
    joined
}

impl Side {
    fn vector(&self) -> Vector2<f64> {
        self.ends[1] - self.ends[0]
    }

    /// Away from the face, which is on the left.
    fn outward(&self) -> Vector2<f64> {
        let along = self.vector().normalize();
        Vector2::new(along.y, -along.x)
    }

    /// The part of the plane in which the face goes on beyond this side, between the ones before and after it.
    fn front(&self, around: [&Self; 2], reach_m: f64) -> Option<ConvexPolygon> {
        let [[a, far_a], [b, far_b]] = [0, 1].map(|k| self.leads(k, around[k], reach_m));
        // Sides that lead together end the face where they meet.
        let (u, v, apart) = (far_a - a, far_b - b, b - a);
        let [s, t] = [apart.perp(&v), apart.perp(&u)].map(|x| x / u.perp(&v));
        let meet = (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
        let far = if meet { [a + u * s; 2] } else { [far_a, far_b] };
        ConvexPolygon::hull(&[[a, b], far].concat()).ok()
    }

    /// The corner at an end with the side there, and where the face goes on from it.
    fn leads(&self, end: usize, other: &Self, reach_m: f64) -> [Point2<f64>; 2] {
        let (corner, outward) = (self.ends[end], self.outward());
        let toward = other.vector().normalize() * [1.0, -1.0][end];
        let along = self.vector();
        let sharp =
            corner + along * ((other.ends[1 - end] - corner).perp(&toward) / along.perp(&toward));
        let is_near = (sharp - corner).norm() <= CORNER_M;
        let corner = if is_near { sharp } else { corner };
        let way = match other.kind {
            // The corner of the view: what is beyond either border meets there.
            EdgeKind::FieldOfView => (outward + other.outward()).try_normalize(FLAT),
            EdgeKind::Real => Some(toward).filter(|toward| toward.dot(&outward) >= FLAT),
            _ => None,
        };
        [corner, corner + way.unwrap_or(outward) * reach_m]
    }
}

#[cfg(test)]
mod tests;
