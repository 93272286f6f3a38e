//! Space of which nothing was seen, as far as a thing could go on there: behind faces, and beyond the border of the view.
//!
//! A ray ends on a face; what it would have met behind is hidden. So a face's body goes on behind it along
//! the rays that saw it ([`Face::bodies_W`]): exactly what the view does not show, and nothing of what it looked
//! through. Where the border of the view cuts a face, it goes on in its plane, straight along the edges that lead to
//! the border. What another view saw there ends both.

use std::collections::BTreeMap;

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
pub(crate) const CORNER_M: f64 = 0.1;
/// Corners this near to a line are on it, m.
const STRAIGHT_M: f64 = 0.02;
/// A jagged edge is seen so far inside the line on which it ends, m: rays that graze an edge are lost.
pub(crate) const JAG_M: f64 = 0.04;
/// An edge tells where a face ends for as many times as far as it was seen straight.
pub(crate) const TELLS: f64 = 3.0;
/// An edge that leads to the border at a flatter angle does not tell how the face goes on (its sine).
const FLAT: f64 = 0.25;
/// What is smaller is not worth a body, m².
const SPECK_M2: f64 = 0.002;

/// Makes bodies behind scanned faces as deep as the ray through the middle goes in `depth_m`, or as none of the views
/// saw anything there; and returns bodies beyond the border of the view, which reach `reach_m` far.
///
/// Of a face that several views saw the first is then the one whose rays leave the body deepest: what another view
/// sees in a shadow shows that it is none, as before the riser below a tread that was seen over its back edge.
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
        let depths = face
            .views
            .iter()
            .map(|view| hidden_m(face, &view.eye_W, views, depth_m));
        // The later of equal ones is the greatest.
        let deepest = depths.enumerate().rev().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((view, deepest_m)) = deepest {
            put_first(face, view);
            face.depth_m = deepest_m;
        }
        if reach_m > 0.0 && depth_m > 0.0 {
            bodies.extend(beyond(face, views, depth_m, reach_m));
        }
    }
    bodies
}

/// Makes a view of a face the first one.
fn put_first(face: &mut Face, view: usize) {
    face.views.swap(0, view);
    for edge in face.region.edges_mut().flatten() {
        edge.view = edge.view.map(|seen| match seen {
            0 => view,
            seen if seen == view => 0,
            seen => seen,
        });
    }
}

/// How deep behind the plane of a face nothing was seen along the rays from an eye, at most as deep as the ray through
/// the face's middle goes in `along_m`: one depth for all of the face, so that its body has a plane back.
fn hidden_m(face: &Face, eye_W: &Point3<f64>, views: &[FreeSpace], along_m: f64) -> f64 {
    let X_FW = face.X_WF.inverse();
    let eye = X_FW * eye_W;
    let seen = views.iter().flat_map(|view| &view.points);
    // From behind the plane, by an error of its pose, a view tells nothing of what the face hides.
    if eye.z <= 0.0 {
        return 0.0;
    }
    let middle = face.region.centroid().coords.push(0.0);
    let most_m = (along_m * eye.z / (eye.coords - middle).norm()).min(eye.z);
    // Only another view sees what this one does not.
    if views.len() < 2 {
        return most_m;
    }
    let inside = face.inset_region(0.0, TOUCH_M);
    let Some((low, high)) = Outline::from(&face.region).bounds() else {
        return most_m;
    };
    let in_bounds = |p: &Point2<f64>| (0..2).all(|k| (low[k]..=high[k]).contains(&p[k]));
    // Nearly all points are elsewhere: their height over the plane alone tells, or the bounds of the face.
    let (n_W, b_m) = (
        face.normal_W(),
        face.normal_W().dot(&face.X_WF.translation.vector),
    );
    let deep = seen.filter_map(|seen| {
        let height_m = n_W.dot(&seen.p_W.coords) - b_m;
        let margin = BEHIND_MIN_M + SIGMAS * seen.sigma_m;
        if !(-most_m..-margin).contains(&height_m) {
            return None;
        }
        let p = X_FW * seen.p_W;
        let at = eye + (p - eye) * (eye.z / (eye.z - p.z));
        let is_behind = in_bounds(&at.xy()) && inside.contains(&at.xy());
        is_behind.then_some(-height_m)
    });
    deep.fold(most_m, f64::min)
}

/// Bodies where a face goes on beyond the border of the view.
fn beyond(face: &Face, views: &[FreeSpace], depth_m: f64, reach_m: f64) -> Vec<Obstacle> {
    let ring = &face.region.rings()[0];
    let cuts = cuts(ring);
    let mut bodies = Vec::new();
    // Cuts that follow each other are led to by the same edges.
    let mut lines = BTreeMap::new();
    let mut line = |from: usize, side: usize| {
        let known = lines.entry((from, side));
        *known.or_insert_with(|| edge_line(ring, from, side))
    };
    for (i, cut) in cuts.iter().enumerate() {
        let eye_W = cut.view.and_then(|view| Some(face.views.get(view)?.eye_W));
        let mut front = || front(ring, &cuts, i, reach_m, &mut line);
        let Some((eye_W, front)) = eye_W.and_then(|eye_W| Some((eye_W, front()?))) else {
            continue;
        };
        let looked_through = |left: Outline, view: &FreeSpace| {
            let carved = view.carved(&face.X_WF, &left, &|_| 0.0);
            left.minus(&carved.through)
        };
        let whole = || Outline::from_polygon(&front);
        let left = views.iter().fold(None, |left, view| {
            Some(looked_through(left.unwrap_or_else(whole), view))
        });
        let pieces = match left.filter(|left| *left != whole()) {
            None => vec![front],
            Some(left) => {
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

/// A straight part of a ring at which the border of the view cuts the face.
struct Cut {
    ends: [Point2<f64>; 2],
    /// Numbers of these vertices.
    at: [usize; 2],
    view: Option<usize>,
}

/// The cuts of a ring, in its order.
fn cuts(ring: &Ring) -> Vec<Cut> {
    let count = ring.edges.len();
    let is_cut = |i: &usize| ring.edges[i % count].kind == EdgeKind::FieldOfView;
    let first = (0..count).find(|i| !is_cut(i) && is_cut(&(i + 1)));
    let first = first.map_or(0, |i| i + 1);
    let mut cuts: Vec<Cut> = Vec::new();
    let mut chain = Vec::new();
    for i in (first..first + count).filter(is_cut) {
        let ends = [i, i + 1].map(|k| ring.vertices[k % count]);
        match cuts.last_mut() {
            Some(last)
                if apart_m(ring, last.at[1], i) < LEAD_MIN_M
                    && is_straight(last.ends[0], &chain, ends[1], STRAIGHT_M) =>
            {
                (last.ends[1], last.at[1]) = (ends[1], i + 1);
                chain.extend(ends);
            }
            _ => {
                chain = vec![ends[1]];
                cuts.push(Cut {
                    ends,
                    at: [i, i + 1],
                    view: ring.edges[i % count].view,
                });
            }
        }
    }
    cuts.retain(|cut| cut.vector().norm() >= CUT_MIN_M);
    cuts
}

/// Length of a ring's edges from one of its vertices to another, m.
fn apart_m(ring: &Ring, from: usize, to: usize) -> f64 {
    let count = ring.edges.len();
    let edges = (to + count - from % count) % count;
    let ends = (from..from + edges).map(|i| [i, i + 1].map(|k| ring.vertices[k % count]));
    ends.map(|[a, b]| (b - a).norm()).sum()
}

/// Whether points lie within `off_m` of the line from one to another.
fn is_straight(start: Point2<f64>, between: &[Point2<f64>], end: Point2<f64>, off_m: f64) -> bool {
    let along = (end - start).normalize();
    let off = |p: &Point2<f64>| along.perp(&(p - start)).abs();
    between.iter().all(|p| off(p) <= off_m)
}

impl Cut {
    fn vector(&self) -> Vector2<f64> {
        self.ends[1] - self.ends[0]
    }

    /// Away from the face, which is on the left.
    fn outward(&self) -> Vector2<f64> {
        let along = self.vector().normalize();
        Vector2::new(along.y, -along.x)
    }
}

/// The part of the plane in which the face goes on beyond a cut, between the edges that lead to it, whose `line`s are
/// asked for by a vertex and a side.
fn front(
    ring: &Ring,
    cuts: &[Cut],
    i: usize,
    reach_m: f64,
    line: &mut impl FnMut(usize, usize) -> Option<EdgeLine>,
) -> Option<ConvexPolygon> {
    let cut = &cuts[i];
    let mut corners = Vec::new();
    let mut ends = Vec::new();
    for side in 0..2 {
        // At the corner of the view another cut follows; the edges that lead here come after it.
        let next = |k: usize| (k + [cuts.len() - 1, 1][side]) % cuts.len();
        let apart_m = |k: usize| match side {
            0 => apart_m(ring, cuts[next(k)].at[1], cuts[k].at[0]),
            _ => apart_m(ring, cuts[k].at[1], cuts[next(k)].at[0]),
        };
        let chained = (1..cuts.len()).scan(i, |k, _| {
            let on = (apart_m(*k) < LEAD_MIN_M).then(|| next(*k))?;
            *k = on;
            Some(on)
        });
        let last = chained.last();
        let line = line(cuts[last.unwrap_or(i)].at[side], side);
        let mut corner = cut.ends[side];
        let mut way = None;
        if last.is_some() {
            way = (cut.outward() + cuts[next(i)].outward()).try_normalize(FLAT);
        } else if let Some(line) = &line {
            let (along, toward) = (cut.vector(), line.toward);
            let sharp =
                corner + along * ((line.through - corner).perp(&toward) / along.perp(&toward));
            if (sharp - corner).norm() <= CORNER_M {
                corner = sharp;
            }
            way = Some(toward).filter(|toward| toward.dot(&cut.outward()) >= FLAT);
        }
        corners.push([
            corner,
            corner + way.unwrap_or_else(|| cut.outward()) * reach_m,
        ]);
        let inside = line
            .filter(|line| TELLS * line.length_m >= reach_m)
            .map(|line| {
                let on = line.through + line.toward * [-1.0, 1.0][side];
                HalfPlane::left_of(&on, &line.through)
            });
        ends.extend(inside.filter(|h| cut.ends.iter().all(|p| h.value(p) <= STRAIGHT_M)));
    }
    // Edges that lead together end the face where they meet.
    let ([a, far_a], [b, far_b]) = (corners[0], corners[1]);
    let (u, v, apart) = (far_a - a, far_b - b, b - a);
    let [s, t] = [apart.perp(&v), apart.perp(&u)].map(|x| x / u.perp(&v));
    let meet = (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
    let far = if meet { [a + u * s; 2] } else { [far_a, far_b] };
    ConvexPolygon::hull(&[[a, b], far].concat())
        .ok()?
        .clip_all(&ends)
}

/// The line on which a face ends beside a cut.
#[derive(Clone, Copy)]
struct EdgeLine {
    through: Point2<f64>,
    /// Unit vector along it, toward the cut.
    toward: Vector2<f64>,
    /// How much of it was seen to end the face, m.
    length_m: f64,
}

/// The line on which the edges that lead to a vertex end the face: outside of what was seen of it, as edges are
/// seen too far inside where rays graze them or something hides them, and so that least of the plane is between.
/// None where too little of them was seen to end it. The edges are those before the vertex (`side` 0) or after it (1).
fn edge_line(ring: &Ring, from: usize, side: usize) -> Option<EdgeLine> {
    let count = ring.edges.len();
    // From the vertex away from the cut, up to the next cut.
    let vertex = |n: usize| ring.vertices[[from + count - n % count, from + n][side] % count];
    let kind = |n: usize| ring.edges[[from + 2 * count - n - 1, from + n][side] % count].kind;
    let length_m = |n: usize| (vertex(n + 1) - vertex(n)).norm();
    let is_cut = |n: &usize| kind(*n) == EdgeKind::FieldOfView && length_m(*n) >= CUT_MIN_M;
    let edges = (0..count).find(is_cut).unwrap_or(count);
    let points: Vec<Point2<f64>> = (0..=edges).map(vertex).collect();
    // Their hull, as far as it is straight.
    let hull = ConvexPolygon::hull(&points).ok();
    let hull = hull.map_or_else(|| points.clone(), |hull| hull.vertices().to_vec());
    let near = |p: &Point2<f64>| (p - points[0]).norm_squared();
    let first = (0..hull.len()).min_by(|&a, &b| near(&hull[a]).total_cmp(&near(&hull[b])))?;
    let walk = |n: usize| hull[[first + hull.len() - n, first + n][side] % hull.len()];
    let path: Vec<Point2<f64>> = (0..hull.len()).map(walk).collect();
    let straight = |n: &usize| is_straight(path[0], &path[1..*n], path[*n], JAG_M);
    let last = (1..path.len()).take_while(straight).last()?;
    let along = (path[last] - path[0]).normalize();
    let part = |p: &Point2<f64>| (p - path[0]).dot(&along);
    let middle = part(&path[last]) / 2.0;
    let beyond = (1..last).find(|&n| part(&path[n]) > middle).unwrap_or(last);
    let (through, toward) = (path[beyond], (path[beyond - 1] - path[beyond]).normalize());
    let on_line = |p: &Point2<f64>| toward.perp(&(p - through)).abs() <= JAG_M;
    let ends = |n: &usize| {
        matches!(kind(*n), EdgeKind::Real | EdgeKind::Fold)
            && on_line(&vertex(*n))
            && on_line(&vertex(n + 1))
    };
    let length_m: f64 = (0..edges).filter(ends).map(length_m).sum();
    (length_m >= LEAD_MIN_M).then_some(EdgeLine {
        through,
        toward,
        length_m,
    })
}

#[cfg(test)]
mod tests;
