//! A scanned floor that continues the ground under the feet.

use nalgebra::{Isometry3, Point2, Point3, UnitQuaternion, Vector2, Vector3};
use surfaces::outline::Outline;
use surfaces::{ConvexPolygon, Face, HalfPlane, Region, Source};

use super::centred;

/// A scanned surface of which every vertex lies this near to the soles' plane is the same floor, m:
/// the error of a plane fitted to a scan.
const JOIN_HEIGHT_M: f64 = 0.010;

/// What a scanned floor is to the ground under the feet.
pub(super) enum Floor {
    /// It lies elsewhere.
    Other,
    /// It lies in the ground's plane, farther away than may be reached over, m.
    Apart(f64),
    /// It continues the ground.
    Joined,
}

/// Reaches over to a scanned `floor` that continues the ground, and moves it into its plane.
pub(super) fn join(
    X_WF: &mut Isometry3<f64>,
    polygon: &mut ConvexPolygon,
    floor: &mut Face,
    gap_m: f64,
    notes: &mut Vec<String>,
) -> Floor {
    let normal = X_WF.rotation * Vector3::z();
    let in_ground = |p: &Point3<f64>| X_WF.inverse_transform_point(p);
    let vertices = floor.vertices_W().into_iter();
    let off_m = vertices.map(|v| in_ground(&v).z.abs()).fold(0.0, f64::max);
    let is_same = off_m <= JOIN_HEIGHT_M && normal.dot(&floor.normal_W()) > 0.0;
    if floor.source != Source::Scan || !is_same {
        return Floor::Other;
    }
    // The convex part of the floor about its point nearest to the soles.
    let middle = polygon.centroid();
    let middle = *X_WF * Point3::new(middle.x, middle.y, 0.0);
    let middle = floor.X_WF.inverse_transform_point(&middle).xy();
    let ahead = floor.region.nearest(&middle) - middle;
    let Some(part) = Outline::from(&floor.region).convex_around(&middle, &ahead) else {
        return Floor::Other;
    };
    let corners = part.vertices().iter();
    let corners: Vec<Point2<f64>> = corners.map(|v| in_ground(&floor.point_W(v)).xy()).collect();
    let Ok(seen) = ConvexPolygon::hull(&corners) else {
        return Floor::Other;
    };
    let apart_m = apart_m(polygon, &seen);
    if apart_m > gap_m {
        return Floor::Apart(apart_m);
    }
    let reached = reach_over(polygon, &seen);
    let Some(Ok(centred)) = reached.map(|reached| centred(X_WF, &reached)) else {
        return Floor::Other;
    };
    (*X_WF, *polygon) = centred;
    into_plane(floor, X_WF);
    notes.push(format!(
        "face {} continues the ground under the feet and was moved into its plane by {:.1} mm",
        floor.id,
        1e3 * off_m
    ));
    Floor::Joined
}

/// How far two convex polygons are apart, m.
fn apart_m(a: &ConvexPolygon, b: &ConvexPolygon) -> f64 {
    match a.intersection(b) {
        Some(_) => 0.0,
        None => nearest_points(a, b).map_or(f64::INFINITY, |(from, to)| (to - from).norm()),
    }
}

/// `polygon` grown over the gap to `seen` at its own width; unchanged where they overlap.
fn reach_over(polygon: &ConvexPolygon, seen: &ConvexPolygon) -> Option<ConvexPolygon> {
    if polygon.intersection(seen).is_some() {
        return Some(polygon.clone());
    }
    let (from, to) = nearest_points(polygon, seen)?;
    let across = to - from;
    // The strip of the polygon's width that runs across the gap.
    let along = across.try_normalize(1e-9)?;
    let side = Vector2::new(-along.y, along.x);
    let extent = |d: Vector2<f64>| {
        let along = polygon.vertices().iter().map(|v| d.dot(&v.coords));
        along.fold(f64::NEG_INFINITY, f64::max)
    };
    let mut ahead = seen.clone();
    for n in [side, -side] {
        ahead = ahead.clip(&HalfPlane { n, b: extent(n) })?;
    }
    ConvexPolygon::hull(&[polygon.vertices(), ahead.vertices()].concat()).ok()
}

/// The nearest points of two convex polygons that do not overlap: one of them is a vertex.
fn nearest_points(a: &ConvexPolygon, b: &ConvexPolygon) -> Option<(Point2<f64>, Point2<f64>)> {
    let from_vertices = |of: &ConvexPolygon, to: &ConvexPolygon| {
        let to = Region::from(to);
        let pairs = of.vertices().iter().map(|v| (*v, to.nearest(v)));
        pairs.collect::<Vec<_>>()
    };
    let mut pairs = from_vertices(a, b);
    pairs.extend(from_vertices(b, a).into_iter().map(|(q, p)| (p, q)));
    let apart = |(p, q): &(Point2<f64>, Point2<f64>)| (q - p).norm();
    pairs
        .into_iter()
        .min_by(|l, r| apart(l).total_cmp(&apart(r)))
}

/// Moves `floor` into the plane z = 0 of a frame by the smallest rotation and the offset along the
/// normal.
fn into_plane(floor: &mut Face, X_WF: &Isometry3<f64>) {
    let normal = X_WF.rotation * Vector3::z();
    let origin = Point3::from(floor.X_WF.translation.vector);
    let onto = origin - X_WF.inverse_transform_point(&origin).z * normal;
    let turn = UnitQuaternion::rotation_between(&floor.normal_W(), &normal)
        .unwrap_or_else(UnitQuaternion::identity);
    floor.X_WF = Isometry3::from_parts(onto.into(), turn * floor.X_WF.rotation);
}
