//! Where a patch would like to touch a surface.

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};

use crate::node::{Held, Node};
use crate::request::{FootState, Prepared, hindmost};

/// Where a patch would like to touch a surface.
pub(crate) struct Wish {
    /// The point of the surface, in W.
    pub place: Point3<f64>,
    /// Heading of a foot.
    pub yaw_rad: Option<f64>,
    /// Progress along the guide path that was aimed at, m.
    pub along_m: f64,
}

/// The place on a surface that a patch would like best, if it is within reach at all: a stride
/// ahead of the hindmost of the other feet (for a hand, of the foremost that stands), along the
/// guide path, at the patch's usual offset, moved onto the surface.
#[allow(non_snake_case)]
pub(crate) fn wanted_place(
    prepared: &Prepared,
    node: &Node,
    feet: &[FootState],
    patch: usize,
    surface: usize,
) -> Option<Wish> {
    let request = prepared.request;
    let guide = &request.guide;
    let support = match prepared.feet.iter().position(|&foot| foot == patch) {
        Some(i) => hindmost(feet, i),
        None => feet
            .iter()
            .filter(|f| !f.in_air)
            .map(|f| f.along_m)
            .max_by(f64::total_cmp)
            .unwrap_or(f64::NEG_INFINITY),
    };
    let (_, heading) = guide.at(support);
    let normal = request.environment.surfaces[surface].normal_W();
    let stride_m = prepared.stride_on(patch, &normal, heading);
    let along = (support + stride_m).min(guide.length_m());
    let wanted = guide.foot_at(along, &prepared.offset[patch]);
    let (_, heading) = guide.at(along);

    let place = onto(prepared, patch, surface, &Point3::from(wanted))?;

    // Within reach of every contact that stays: two limbs and what is between them. A ball's centre
    // is over the place that it touches.
    let X_WS = &request.environment.surfaces[surface].X_WS;
    let polygon = request.environment.effective[surface].as_ref()?;
    let over = request.robot.patches[patch].touching(&Isometry3::identity());
    let centre = place + X_WS.rotation * over.translation.vector;
    let X_over = X_WS * over;
    for held in &node.contacts {
        let apart = (centre.coords - held.X_WC.translation.vector).norm();
        let nearest = distance_to_polygon(&X_over, polygon.vertices(), &held.X_WC);
        let reach = prepared.reach_m[patch] + prepared.reach_m[held.patch];
        if nearest > reach && apart > reach {
            return None;
        }
    }
    // A foot looks along the path; how a hand lies does not matter.
    let yaw_rad = prepared.feet.contains(&patch).then_some(heading);
    Some(Wish {
        place,
        yaw_rad,
        along_m: along,
    })
}

/// Places on the surface about one where the patch does touch, `planner.same_place_m` away from it
/// along the path and across: for where no motion leads to that one.
pub(crate) fn elsewhere(prepared: &Prepared, held: &Held) -> Vec<Wish> {
    let guide = &prepared.request.guide;
    let place = held.place_W(prepared);
    let along_m = guide
        .foot_progress(&place, &prepared.offset[held.patch])
        .along_m;
    let heading = guide.at(along_m).1;
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), heading);
    let step = prepared.config.same_place_m;
    [-Vector3::x(), -Vector3::y(), Vector3::y(), Vector3::x()]
        .iter()
        .filter_map(|way| {
            let wanted = Point3::from(place + turn * way * step);
            let beside = onto(prepared, held.patch, held.surface, &wanted)?;
            let moved = (beside.coords - place).norm() > 0.5 * step;
            let yaw_rad = prepared.feet.contains(&held.patch).then_some(heading);
            moved.then_some(Wish {
                place: beside,
                yaw_rad,
                along_m,
            })
        })
        .collect()
}

/// The nearest place on a surface to a point, the patch's middle at least its half width from the
/// edge, a ball's at least its radius; none on a surface that is smaller.
#[allow(non_snake_case)]
fn onto(
    prepared: &Prepared,
    patch: usize,
    surface: usize,
    wanted: &Point3<f64>,
) -> Option<Point3<f64>> {
    let environment = prepared.request.environment;
    let X_WS = &environment.surfaces[surface].X_WS;
    let shape = &prepared.request.robot.patches[patch];
    let half_width = shape
        .point_radius_m()
        .unwrap_or_else(|| half_width(&shape.polygon));
    let room = environment.effective[surface].as_ref()?.inset(half_width)?;
    let p_S = X_WS.inverse_transform_point(wanted).xy();
    let place_S = nearest_inside(room.vertices(), &p_S);
    Some(X_WS * Point3::new(place_S.x, place_S.y, 0.0))
}

/// Distance of a contact from the nearest point of a polygon, m.
#[allow(non_snake_case)]
fn distance_to_polygon(
    X_WS: &Isometry3<f64>,
    polygon: &[nalgebra::Point2<f64>],
    X_WC: &Isometry3<f64>,
) -> f64 {
    let p = X_WS.inverse_transform_point(&Point3::from(X_WC.translation.vector));
    let inside = nearest_inside(polygon, &p.xy());
    ((inside - p.xy()).norm_squared() + p.z * p.z).sqrt()
}

/// Radius of the largest circle about the centroid that the patch contains, m.
fn half_width(polygon: &[nalgebra::Point2<f64>]) -> f64 {
    let n = polygon.len().max(1) as f64;
    let c = polygon
        .iter()
        .map(|p| p.coords)
        .sum::<nalgebra::Vector2<f64>>()
        / n;
    polygon
        .iter()
        .zip(polygon.iter().cycle().skip(1))
        .map(|(a, b)| {
            let e = b - a;
            e.perp(&(c - a.coords)).abs() / e.norm().max(1e-12)
        })
        .fold(f64::INFINITY, f64::min)
}

/// The point of a convex counter-clockwise polygon that is nearest to `p`.
fn nearest_inside(
    polygon: &[nalgebra::Point2<f64>],
    p: &nalgebra::Point2<f64>,
) -> nalgebra::Point2<f64> {
    let mut inside = true;
    let mut best = (*p, f64::INFINITY);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let e = b - a;
        if e.perp(&(p - a)) < 0.0 {
            inside = false;
        }
        let t = (e.dot(&(p - a)) / e.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        let q = a + t * e;
        let d = (p - q).norm();
        if d < best.1 {
            best = (q, d);
        }
    }
    if inside { *p } else { best.0 }
}
