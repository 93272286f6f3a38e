//! Nothing but contacts is near the environment, contacts do not sink in, and the robot's parts
//! are apart.

use nalgebra::{Matrix4, Vector3};
use robot_model::collision::{Shape, ShapeGeometry};

use crate::Check;
use crate::distance::{Solid, signed_distance};
use crate::extremes::Extremes;
use crate::findings::Findings;
use crate::posture::{Posture, column, point};
use crate::scene::{Placed, Scene, Touch};
use crate::surroundings::Ball;

/// What is farther over its bound than this is not measured in a stance, m.
const FAR_M: f64 = 0.5;

/// The smallest distances found in a stance, m; infinite where all is far.
pub(crate) struct Nearest {
    pub environment: f64,
    pub own: f64,
}

/// The distances of one stance.
pub(crate) fn check(placed: &Placed, findings: &mut Findings) -> Nearest {
    let mut worst = Extremes::default();
    let scene = placed.scene;
    let bounds = Bounds::new(scene, scene.options.distance_m);
    // Where nothing is near, that is what is found.
    for (check, bound) in [
        (Check::Clearance, bounds.free),
        (Check::ContactDepth, bounds.touching),
        (Check::SelfClearance, bounds.own),
    ] {
        worst.add(check, f64::INFINITY, bound, String::new);
    }
    let (posture, touches) = (&placed.posture, &placed.touches);
    distances(scene, posture, touches, &bounds, "", &mut worst);
    let nearest = Nearest {
        environment: worst.value(Check::Clearance),
        own: worst.value(Check::SelfClearance),
    };
    worst.report(placed.at, findings);
    nearest
}

/// The distances of one sample of a motion, of what could be nearer than it may.
pub(crate) fn along(
    scene: &Scene,
    posture: &Posture,
    touches: &[Touch],
    t_s: f64,
    worst: &mut Extremes,
) {
    let bounds = Bounds {
        beyond: 0.0,
        ..Bounds::new(scene, scene.options.motion_distance_m)
    };
    let at = format!(" at {t_s:.2} s");
    distances(scene, posture, touches, &bounds, &at, worst);
}

/// The least distances that are allowed, and how far over them is too far to be measured, m.
struct Bounds {
    free: f64,
    touching: f64,
    own: f64,
    beyond: f64,
}

impl Bounds {
    fn new(scene: &Scene, slack_m: f64) -> Self {
        let required = &scene.plan.required;
        Self {
            free: required.clearance_m - slack_m,
            touching: -scene.options.contact_depth_m,
            own: required.self_clearance_m - slack_m,
            beyond: FAR_M,
        }
    }
}

/// The worst distances, of what cannot be told to be too far over its bound.
fn distances(
    scene: &Scene,
    posture: &Posture,
    touches: &[Touch],
    bounds: &Bounds,
    at: &str,
    worst: &mut Extremes,
) {
    let shapes = posture.robot.collision.shapes();
    let placed = |shape: &Shape| {
        let pose = posture.X_WB.get(shape.body)? * shape.X_BG.to_homogeneous();
        Some((solid(&shape.geometry, &pose), ball(&shape.geometry, &pose)))
    };
    let solids: Vec<Option<(Solid, Ball)>> = shapes.iter().map(placed).collect();

    // Robot and environment.
    let balls = solids.iter().flatten().map(|(_, ball)| *ball);
    let reach_m = bounds.beyond + bounds.free.max(0.0);
    let bodies = scene.surroundings.near(balls, reach_m);
    for (shape, solid) in shapes.iter().zip(&solids) {
        let Some((solid, ball)) = solid else { continue };
        for body in &bodies {
            // What is farther than the worst so far, however it may be touched, cannot be the worst.
            let least = body.bounds.least_m(ball);
            let is_better = least - bounds.free > worst.margin(Check::Clearance)
                && least - bounds.touching > worst.margin(Check::ContactDepth);
            if is_better || least - bounds.free > bounds.beyond {
                continue;
            }
            let own = touches
                .iter()
                .filter(|touch| touch.patch.body == shape.body);
            let rise = own
                .clone()
                .filter_map(|touch| Some((body.rise_over(touch.face, scene.options)?, touch)))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let subject = || format!("{} / {}{at}", shape.link, body.name);
            match rise {
                Some((rise, touch)) => {
                    let hint = column(&touch.face.X_WF.to_homogeneous(), 2);
                    let distance = signed_distance(solid, &body.solid, &[hint]);
                    worst.add(
                        Check::ContactDepth,
                        distance,
                        bounds.touching - rise,
                        subject,
                    );
                }
                None => {
                    let whole = signed_distance(solid, &body.solid, &[]);
                    let above = own.map(|touch| body.above(touch.face, scene.options));
                    let above = above.map(|part| signed_distance(solid, &part, &[]));
                    match above.max_by(f64::total_cmp) {
                        Some(above) => {
                            worst.add(Check::Clearance, above, bounds.free, subject);
                            worst.add(Check::ContactDepth, whole, bounds.touching, subject);
                        }
                        None => worst.add(Check::Clearance, whole, bounds.free, subject),
                    }
                }
            }
        }
    }

    // The robot and itself.
    for &(i, j) in posture.robot.collision.pairs() {
        let (Some(Some((a, ball_a))), Some(Some((b, ball_b)))) = (solids.get(i), solids.get(j))
        else {
            continue;
        };
        let least = (ball_a.0 - ball_b.0).norm() - ball_a.1 - ball_b.1;
        if least - bounds.own <= bounds.beyond {
            let distance = signed_distance(a, b, &[]);
            worst.add(Check::SelfClearance, distance, bounds.own, || {
                format!("{} / {}{at}", shapes[i].link, shapes[j].link)
            });
        }
    }
}

/// A ball around a shape of the robot, in W.
fn ball(geometry: &ShapeGeometry, pose: &Matrix4<f64>) -> Ball {
    let (centre, half) = geometry.bounds();
    (point(pose, &centre.coords), half.norm())
}

/// A shape of the robot in W; round ones, cylinders and boxes are centred in their frame, with
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
    use crate::Options;

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
                &solid(&a, &X_WA.to_homogeneous()),
                &solid(&b, &X_WB.to_homogeneous()),
                &[],
            );
            let theirs = closest(&a, &X_WA, &b, &X_WB, 10.0).unwrap().distance;
            if theirs > 0.0 {
                prop_assert!((mine - theirs).abs() < Options::default().distance_m, "{mine} and {theirs}");
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
}
