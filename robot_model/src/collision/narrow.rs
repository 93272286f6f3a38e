//! The signed distance of two convex shapes.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::ShapeGeometry;
use super::parry::{Answer, closest_cores};
use super::segment;

/// The closest, or deepest, points of two shapes.
///
/// Frames: all in W.  Units: m.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// Signed distance; negative on overlap.
    pub distance: f64,
    /// Unit normal from b toward a.
    pub normal_W: Vector3<f64>,
    /// Witness point on a.
    pub p_a_W: Point3<f64>,
    /// Witness point on b.
    pub p_b_W: Point3<f64>,
}

/// Signed distance of a and b, or `None` where it exceeds `max_distance_m`.
///
///   d = max over unit n of ( min nᵀx, x ∈ a  −  max nᵀy, y ∈ b )
///
/// Spheres and capsules are taken as points and segments with a radius: pairs of them are closed
/// forms, and their overlap with other shapes stays exact until the core itself overlaps.
pub fn closest(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
    max_distance_m: f64,
) -> Option<Closest> {
    let (radius_a, radius_b) = (a.margin_m(), b.margin_m());
    let cores = match (a.segment_half_m(), b.segment_half_m()) {
        (Some(half_a), Some(half_b)) => segments(X_WA, half_a, X_WB, half_b),
        _ => {
            let X_AB = X_WA.inv_mul(X_WB);
            let reach = max_distance_m + radius_a + radius_b;
            match closest_cores(a, b, &X_AB, &X_AB.translation.vector, reach) {
                Answer::Far => return None,
                Answer::Failed => least_overlap_found(a, X_WA, b, X_WB),
                Answer::Found(found) => {
                    let normal_W = -(X_WA.rotation * found.normal.into_inner());
                    let (p_a_W, p_b_W) = (X_WA * found.p_a, X_WA * found.p_b);
                    let distance = (p_a_W - p_b_W).dot(&normal_W);
                    Closest {
                        distance,
                        normal_W,
                        p_a_W,
                        p_b_W,
                    }
                }
            }
        }
    };
    // Put the radii back on.
    let distance = cores.distance - radius_a - radius_b;
    (distance <= max_distance_m).then(|| Closest {
        distance,
        normal_W: cores.normal_W,
        p_a_W: cores.p_a_W - cores.normal_W * radius_a,
        p_b_W: cores.p_b_W + cores.normal_W * radius_b,
    })
}

/// Two segments (or points), in closed form.
fn segments(X_WA: &Isometry3<f64>, half_a: f64, X_WB: &Isometry3<f64>, half_b: f64) -> Closest {
    let (p, q) = (X_WA.translation.vector, X_WB.translation.vector);
    let (u, w) = (X_WA.rotation * Vector3::z(), X_WB.rotation * Vector3::z());
    let (a, b) = segment::closest_points(&p, &u, half_a, &q, &w, half_b);
    // Crossing cores have no direction between them: leave along their common normal.
    let (normal, distance) = Unit::try_new_and_get(a - b, 1e-12).unwrap_or_else(|| {
        let across = Unit::try_new(u.cross(&w), 1e-6);
        let normal = across.unwrap_or_else(|| {
            let axis = if half_a >= half_b { u } else { w };
            Unit::new_normalize(axis.cross(&Vector3::ith(axis.iamin(), 1.0)))
        });
        let toward_a = if normal.dot(&(p - q)) < 0.0 {
            -normal
        } else {
            normal
        };
        (toward_a, 0.0)
    });
    Closest {
        distance,
        normal_W: normal.into_inner(),
        p_a_W: a.into(),
        p_b_W: b.into(),
    }
}

/// Where GJK and EPA fail (degenerate touching): the best of the directions that could part them.
///
/// The separation along any direction bounds the signed distance from below, so the answer is
/// never too large.
fn least_overlap_found(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
) -> Closest {
    let candidates = [(a, X_WA), (b, X_WB)]
        .into_iter()
        .flat_map(|(shape, X_WS)| face_normals(shape).into_iter().map(|n| X_WS.rotation * n));
    let between = X_WA * a.bounds().0 - X_WB * b.bounds().0;
    let along = |n: Vector3<f64>| separation(a, X_WA, b, X_WB, &n);
    let start = along(between.try_normalize(1e-12).unwrap_or_else(Vector3::z));
    candidates
        .flat_map(|n| [along(n), along(-n)])
        .fold(start, |best, next| {
            if next.distance > best.distance {
                next
            } else {
                best
            }
        })
}

/// How far apart the cores are along n, negative on overlap.
fn separation(
    a: &ShapeGeometry,
    X_WA: &Isometry3<f64>,
    b: &ShapeGeometry,
    X_WB: &Isometry3<f64>,
    n: &Vector3<f64>,
) -> Closest {
    let p_a_W = X_WA * a.core_support(&(X_WA.rotation.inverse() * -n));
    let p_b_W = X_WB * b.core_support(&(X_WB.rotation.inverse() * n));
    Closest {
        distance: (p_a_W - p_b_W).dot(n),
        normal_W: *n,
        p_a_W,
        p_b_W,
    }
}

/// Normals of a hull's faces, or the axes of any other shape.
fn face_normals(shape: &ShapeGeometry) -> Vec<Vector3<f64>> {
    match shape {
        ShapeGeometry::ConvexHull(hull) => hull.face_normals().collect(),
        _ => vec![Vector3::x(), Vector3::y(), Vector3::z()],
    }
}
