//! The one place that speaks glam to parry: closest points of two convex cores, and boxes found by what
//! they meet.

use glamx::{DPose3, DVec3};
use nalgebra::{Isometry3, Point3, Unit, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::query::PointQuery;
use parry3d_f64::query::epa::EPA;
use parry3d_f64::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d_f64::shape::{SupportMap, Triangle};

use super::ShapeGeometry;

/// A shape without its rounding radius.
struct Core<'a>(&'a ShapeGeometry);

impl SupportMap for Core<'_> {
    fn local_support_point(&self, dir: DVec3) -> DVec3 {
        to_glam(&self.0.core_support(&from_glam(dir)).coords)
    }
}

fn to_glam(v: &Vector3<f64>) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

fn from_glam(v: DVec3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// What parry found, in A's frame.
pub(super) struct CoreClosest {
    pub p_a: Point3<f64>,
    pub p_b: Point3<f64>,
    /// From a toward b.
    pub normal: Unit<Vector3<f64>>,
}

/// The outcome of the query.
pub(super) enum Answer {
    /// Closest, or deepest, points.
    Found(CoreClosest),
    /// The cores are provably further apart than asked for.
    Far,
    /// The algorithm ran out of digits.
    Failed,
}

/// Closest points of a's and b's cores (GJK), or the least way out of overlap (EPA).
///
/// Frames: `X_AB` is b's pose in a's frame, the answer is in a's frame; `toward` is a first
/// guess for the direction from a to b.
pub(super) fn closest_cores(
    a: &ShapeGeometry,
    b: &ShapeGeometry,
    X_AB: &Isometry3<f64>,
    toward: &Vector3<f64>,
    max_distance_m: f64,
) -> Answer {
    let (core_a, core_b) = (Core(a), Core(b));
    let pose = DPose3::from(*X_AB);
    let first = toward.try_normalize(1e-12).unwrap_or_else(Vector3::x);
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(
        &pose,
        &core_a,
        &core_b,
        to_glam(&first),
    ));
    let found =
        match gjk::closest_points(&pose, &core_a, &core_b, max_distance_m, true, &mut simplex) {
            GJKResult::ClosestPoints(p_a, p_b, normal) => Some((p_a, p_b, normal)),
            GJKResult::Intersection => EPA::new().closest_points(&pose, &core_a, &core_b, &simplex),
            GJKResult::NoIntersection(direction) => {
                // The same value says "too far" and "gave up": only a separating direction proves.
                let support = CsoPoint::from_shapes(&pose, &core_a, &core_b, direction);
                if -direction.dot(support.point) > max_distance_m {
                    return Answer::Far;
                }
                None
            }
            GJKResult::Proximity(_) => None,
        };
    let Some((p_a, p_b, normal)) = found else {
        return Answer::Failed;
    };
    let Some(normal) = Unit::try_new(from_glam(normal), 0.5) else {
        return Answer::Failed;
    };
    let (p_a, p_b) = (from_glam(p_a), from_glam(p_b));
    if !(p_a + p_b).iter().all(|value| value.is_finite()) {
        return Answer::Failed;
    }
    Answer::Found(CoreClosest {
        p_a: p_a.into(),
        p_b: p_b.into(),
        normal,
    })
}

/// Distance of a point from a triangle, m.
pub(super) fn distance_m(p: &Point3<f64>, corners: [Point3<f64>; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| to_glam(&p.coords));
    Triangle::new(a, b, c).distance_to_local_point(to_glam(&p.coords), true)
}

/// Boxes along W's axes, each known by its number: parry's hierarchy of bounding volumes.
#[derive(Clone, Default)]
pub struct BoxIndex(Bvh);

impl BoxIndex {
    /// Boxes (lowest and highest corner, W, m), numbered as they come.
    pub fn new(boxes: impl IntoIterator<Item = (Point3<f64>, Point3<f64>)>) -> Self {
        let boxes = boxes.into_iter().map(|(low, high)| aabb(&low, &high));
        let boxes: Vec<_> = boxes.collect();
        Self(Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes))
    }

    /// The boxes that come within `distance_m` of a box along each axis, in ascending order.
    pub fn near(&self, low: &Point3<f64>, high: &Point3<f64>, distance_m: f64) -> Vec<usize> {
        let beside = Vector3::repeat(distance_m);
        let asked = aabb(&(low - beside), &(high + beside));
        let found = self.0.intersect_aabb(&asked).map(|i| i as usize);
        let mut found: Vec<usize> = found.collect();
        found.sort_unstable();
        found
    }
}

/// A box along the axes, by its lowest and highest corner.
fn aabb(low: &Point3<f64>, high: &Point3<f64>) -> Aabb {
    Aabb::new(to_glam(&low.coords), to_glam(&high.coords))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_near_a_box_are_found_in_their_order() {
        let cube = |x: f64| (Point3::new(x, 0.0, 0.0), Point3::new(x + 1.0, 1.0, 1.0));
        let index = BoxIndex::new([5.0, 0.0, 2.5, -9.0].map(cube));
        let (low, high) = cube(1.2);
        assert_eq!(index.near(&low, &high, 0.25), [1]);
        assert_eq!(index.near(&low, &high, 0.35), [1, 2]);
        assert_eq!(index.near(&low, &high, 10.0), [0, 1, 2, 3]);
        assert!(BoxIndex::default().near(&low, &high, 1e3).is_empty());
    }
}
