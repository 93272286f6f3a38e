//! The signed distance of two convex shapes.

use nalgebra::{Isometry3, Unit, Vector3};

use super::ShapeGeometry;
use super::closest::{Closest, separation};
use super::overlap::deepest;
use super::parry::{Answer, closest_cores};
use super::segment;

/// Cores nearer than this touch or overlap.
const TOUCHING_M: f64 = 1e-9;
/// A depth that its own normal does not attain to this accuracy is computed again.
const DOUBT_M: f64 = 1e-6;

/// Signed distance of a and b, or `None` where it exceeds `max_distance_m`.
///
///   d = max over unit n of ( min nᵀx, x ∈ a  −  max nᵀy, y ∈ b )
///
/// Spheres and capsules are taken as points and segments with a radius, hulls with what they fall
/// short of: pairs of them are closed
/// forms, and their overlap with other shapes stays exact until the core itself overlaps.
/// Exact to rounding for polyhedra and round cores; a cylinder's distance is up to 2e-5 m too
/// great (where GJK's simplex stops telling support points apart).
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
                Answer::Failed => deepest(a, X_WA, b, X_WB),
                Answer::Found(found) => {
                    let normal_W = -(X_WA.rotation * found.normal.into_inner());
                    let (p_a_W, p_b_W) = (X_WA * found.p_a, X_WA * found.p_b);
                    let distance = (p_a_W - p_b_W).dot(&normal_W);
                    let found = Closest {
                        distance,
                        normal_W,
                        p_a_W,
                        p_b_W,
                    };
                    // One overlap in some thousands comes back with a normal that does not
                    // attain its depth, or with witness points that are not across from
                    // each other.
                    let is_doubtful = distance < TOUCHING_M && {
                        let attained = separation(a, X_WA, b, X_WB, &normal_W).distance;
                        let skew = (p_a_W - p_b_W - normal_W * distance).norm();
                        (distance - attained).max(skew) > DOUBT_M
                    };
                    if is_doubtful {
                        deepest(a, X_WA, b, X_WB)
                    } else {
                        found
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
