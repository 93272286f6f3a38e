//! The robot's shapes as bodies that distances are measured between.

use nalgebra::{Matrix4, Vector3};
use robot_model::Robot;
use robot_model::collision::{Shape, ShapeGeometry};

use crate::posture::{column, point};
use crate::solid::Solid;

/// The robot's shapes, each with its body, in the body's frame.
pub(crate) fn shapes(robot: &Robot) -> Vec<(usize, Solid)> {
    let shapes = robot.collision.shapes().iter();
    let solid = |s: &Shape| (s.body, solid(&s.geometry, &s.X_BG.to_homogeneous()));
    shapes.map(solid).collect()
}

/// A shape that holds a ball, and what of it is not near the ball.
pub(crate) struct Shank {
    /// The ball's patch.
    pub patch: usize,
    /// The shape.
    pub shape: usize,
    /// What of it is farther from the ball's centre than [`NEAR_RADII`] of its radius, as a shape.
    pub beyond: usize,
}

/// What of a link is within so many radii of a ball's centre may come to where the ball does.
const NEAR_RADII: f64 = 2.0;

/// The robot's shapes, and after them the parts of shanks that are not near their balls.
pub(crate) fn with_shanks(robot: &Robot) -> (Vec<(usize, Solid)>, Vec<Shank>) {
    let mut shapes = shapes(robot);
    let mut shanks = Vec::new();
    for (patch, touching) in robot.patches.iter().enumerate() {
        let Some(radius_m) = touching.point_radius_m() else {
            continue;
        };
        let centre = column(&touching.X_BC.to_homogeneous(), 3);
        for (shape, drawn) in robot.collision.shapes().iter().enumerate() {
            if !drawn.is_pad || drawn.body != touching.body {
                continue;
            }
            if let Some(beyond) = shapes[shape].1.beyond(&centre, NEAR_RADII * radius_m) {
                shanks.push(Shank {
                    patch,
                    shape,
                    beyond: shapes.len(),
                });
                shapes.push((drawn.body, beyond));
            }
        }
    }
    (shapes, shanks)
}

/// A shape of the robot at a pose; round ones, cylinders and boxes are centred in their frame, with
/// their axis along its z.
fn solid(geometry: &ShapeGeometry, pose: &Matrix4<f64>) -> Solid {
    let at = |x: f64, y: f64, z: f64| point(pose, &Vector3::new(x, y, z));
    match geometry {
        ShapeGeometry::Sphere { radius_m } => Solid::hull([at(0.0, 0.0, 0.0)], *radius_m),
        ShapeGeometry::Capsule {
            half_length_m: h,
            radius_m,
        } => Solid::hull([at(0.0, 0.0, -h), at(0.0, 0.0, *h)], *radius_m),
        ShapeGeometry::Cylinder {
            half_length_m,
            radius_m,
        } => {
            let ends = [-1.0, 1.0].map(|end| at(0.0, 0.0, end * half_length_m));
            Solid::widened(ends, &column(pose, 2), *radius_m)
        }
        ShapeGeometry::Box { half_extents_m: h } => {
            let sign = |k: usize, bit: usize| if k & bit == 0 { -1.0 } else { 1.0 };
            let corner = |k| at(sign(k, 1) * h.x, sign(k, 2) * h.y, sign(k, 4) * h.z);
            Solid::hull((0..8).map(corner), 0.0)
        }
        ShapeGeometry::ConvexHull(hull) => {
            let vertices = hull.vertices().iter().map(|v| at(v.x, v.y, v.z));
            Solid::hull(vertices, hull.shortfall_m())
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, UnitQuaternion};
    use proptest::prelude::*;
    use robot_model::collision::{Hull, closest};

    use super::*;
    use crate::TOLERANCES;
    use crate::distance::signed_distance;

    fn geometries() -> impl Strategy<Value = ShapeGeometry> {
        let size = 0.02..0.5;
        prop_oneof![
            size.clone()
                .prop_map(|radius_m| ShapeGeometry::Sphere { radius_m }),
            (size.clone(), size.clone()).prop_map(|(half_length_m, radius_m)| {
                ShapeGeometry::Capsule {
                    half_length_m,
                    radius_m,
                }
            }),
            (size.clone(), size.clone()).prop_map(|(half_length_m, radius_m)| {
                ShapeGeometry::Cylinder {
                    half_length_m,
                    radius_m,
                }
            }),
            prop::array::uniform3(size).prop_map(|half| ShapeGeometry::Box {
                half_extents_m: Vector3::from(half)
            }),
            prop::collection::vec(prop::array::uniform3(-0.4..0.4), 6..20).prop_filter_map(
                "flat",
                |points| {
                    let points: Vec<Point3<f64>> = points.into_iter().map(Point3::from).collect();
                    Hull::new(&points).ok().map(ShapeGeometry::ConvexHull)
                }
            ),
        ]
    }

    fn poses() -> impl Strategy<Value = Isometry3<f64>> {
        let turn = prop::array::uniform3(-2.0..2.0);
        (prop::array::uniform3(-0.8..0.8), turn).prop_map(|(p, turn)| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
            Isometry3::from_parts(Vector3::from(p).into(), turn)
        })
    }

    proptest! {
        /// The robot's own distances are other code on the same shapes. Mine is a lower bound;
        /// apart, it is tight to the slack that distances get (flat and edged bodies to rounding,
        /// rims of cylinders to some 0.01 mm).
        #[test]
        fn distances_agree_with_the_robots_own(
            a in geometries(), X_WA in poses(), b in geometries(), X_WB in poses(),
        ) {
            let mine = signed_distance(
                &solid(&a, &X_WA.to_homogeneous()).here(),
                &solid(&b, &Matrix4::identity()).at(&X_WB.to_homogeneous()),
                &[],
                f64::INFINITY,
            ).0;
            let theirs = closest(&a, &X_WA, &b, &X_WB, 10.0).unwrap().distance;
            if theirs > 0.0 {
                prop_assert!((mine - theirs).abs() < TOLERANCES.distance_m, "{mine} and {theirs}");
            } else {
                prop_assert!(mine < 1e-6, "{mine} and {theirs}");
                // Overlapping, EPA is exact to rounding on polytopes, but for deep ones it gives up
                // up to some 0.1 mm early.
                let polytope = |g: &ShapeGeometry| {
                    matches!(g, ShapeGeometry::Box { .. } | ShapeGeometry::ConvexHull(_))
                };
                if polytope(&a) && polytope(&b) {
                    prop_assert!(mine > theirs - 1e-3, "{mine} and {theirs}");
                }
            }
        }
    }

    proptest! {
        /// All that is left is far from the point, and nothing that is far enough on the side of the body's middle is lost.
        #[test]
        fn what_is_beyond_a_point_is_what_is_far_from_it(
            geometry in geometries(),
            from in prop::array::uniform3(-0.5..0.5),
            farther_m in 0.0..0.4,
            toward in prop::array::uniform3(-1.0..1.0),
        ) {
            let body = solid(&geometry, &Matrix4::identity());
            let (from, toward) = (Vector3::from(from), Vector3::from(toward));
            prop_assume!(toward.norm() > 0.1);
            let middle = body.ball().0;
            let (farthest, radius) = (body.here().farthest(&toward), body.here().radius());
            let beyond = body.beyond(&from, farther_m);
            let reached = farthest + toward.normalize() * radius;
            if let Some(rest) = &beyond {
                let kept = rest.here().farthest(&toward) + toward.normalize() * radius;
                prop_assert!((kept - from).norm() > farther_m - 1e-9);
            }
            let thick_m = radius + match geometry {
                ShapeGeometry::Cylinder { radius_m, .. } => radius_m,
                _ => 0.0,
            };
            let along = (middle - from).normalize();
            if (reached - from).dot(&along) > farther_m + 2.0 * thick_m + 1e-9 {
                let point = Solid::hull([reached], 0.0);
                let found = beyond.map(|rest| signed_distance(&rest.here(), &point.here(), &[], f64::INFINITY).0);
                prop_assert!(found.is_some_and(|m| m < 1e-6), "{found:?}");
            }
        }
    }
}
