//! Nothing but contacts is near the environment, contacts do not sink in, and the robot's parts
//! are apart.

use nalgebra::{Matrix4, Vector3};
use plan::Plan;
use robot_model::collision::{Shape, ShapeGeometry};

use crate::distance::{Solid, signed_distance};
use crate::findings::Findings;
use crate::motion::Extremes;
use crate::posture::{Posture, column, point};
use crate::scene::{Scene, Touch};
use crate::surroundings::{Ball, Surroundings};
use crate::{Check, Options};

/// The worst of some values against their bounds.
struct Worst {
    margin: f64,
    value: f64,
    bound: f64,
    subject: String,
}

impl Worst {
    fn new(bound: f64) -> Self {
        let value = f64::INFINITY;
        Self {
            margin: value,
            value,
            bound,
            subject: String::new(),
        }
    }

    fn add(&mut self, value: f64, bound: f64, subject: impl FnOnce() -> String) {
        let margin = value - bound;
        // What is not a number is the worst of all.
        if margin.is_nan() || margin < self.margin {
            *self = Self {
                margin,
                value,
                bound,
                subject: subject(),
            };
        }
    }
}

/// The smallest distances found in a stance, m.
pub(crate) struct Nearest {
    pub environment: f64,
    pub own: f64,
}

/// The distances of one stance.
pub(crate) fn check(
    plan: &Plan,
    posture: &Posture,
    touches: &[Touch],
    surroundings: &Surroundings,
    options: &Options,
    stance: usize,
    findings: &mut Findings,
) -> Nearest {
    let shapes = posture.robot.collision.shapes();
    let solids: Vec<Option<Solid>> = shapes
        .iter()
        .map(|shape| {
            let pose = posture.X_WB.get(shape.body)? * shape.X_BG.to_homogeneous();
            Some(solid(&shape.geometry, &pose))
        })
        .collect();

    // Robot and environment.
    let free_bound = plan.required.clearance_m - options.distance_m;
    let mut free = Worst::new(free_bound);
    let mut touching = Worst::new(-options.contact_depth_m);
    for (shape, solid) in shapes.iter().zip(&solids) {
        let Some(solid) = solid else { continue };
        let ball = ball_around(posture, shape);
        for body in &surroundings.bodies {
            // What is farther than the worst so far, however it may be touched, cannot be the worst.
            let least = ball.as_ref().map_or(0.0, |ball| body.bounds.least_m(ball));
            let touch_bound = -options.contact_depth_m;
            if least - free_bound > free.margin && least - touch_bound > touching.margin {
                continue;
            }
            let rise = touches
                .iter()
                .filter(|touch| touch.patch.body == shape.body)
                .filter_map(|touch| Some((body.rise_over(touch.face, options)?, touch)))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let subject = || format!("{} / {}", shape.link, body.name);
            match rise {
                Some((rise, touch)) => {
                    let hint = column(&touch.face.X_WF.to_homogeneous(), 2);
                    let distance = signed_distance(solid, &body.solid, &[hint]);
                    touching.add(distance, -options.contact_depth_m - rise, subject);
                }
                None => free.add(
                    signed_distance(solid, &body.solid, &[]),
                    free_bound,
                    subject,
                ),
            }
        }
    }

    // The robot and itself.
    let own_bound = plan.required.self_clearance_m - options.distance_m;
    let mut own = Worst::new(own_bound);
    for &(i, j) in posture.robot.collision.pairs() {
        if let (Some(Some(a)), Some(Some(b))) = (solids.get(i), solids.get(j)) {
            own.add(signed_distance(a, b, &[]), own_bound, || {
                format!("{} / {}", shapes[i].link, shapes[j].link)
            });
        }
    }

    let nearest = Nearest {
        environment: free.value,
        own: own.value,
    };
    for (check, worst) in [
        (Check::Clearance, free),
        (Check::ContactDepth, touching),
        (Check::SelfClearance, own),
    ] {
        findings.value(Some(stance), check, worst.subject, worst.value, worst.bound);
    }
    nearest
}

/// The distances of one sample of a motion, of what could be near.
pub(crate) fn along(
    scene: &Scene,
    posture: &Posture,
    touches: &[Touch],
    t_s: f64,
    worst: &mut Extremes,
) {
    let (plan, options) = (scene.plan, scene.options);
    let shapes = posture.robot.collision.shapes();
    let solids: Vec<Option<(Solid, Ball)>> = shapes
        .iter()
        .map(|shape| {
            let pose = posture.X_WB.get(shape.body)? * shape.X_BG.to_homogeneous();
            Some((solid(&shape.geometry, &pose), ball_around(posture, shape)?))
        })
        .collect();
    let free_bound = plan.required.clearance_m - options.motion_distance_m;
    let own_bound = plan.required.self_clearance_m - options.motion_distance_m;
    let far = |a: &Ball, b: &Ball, bound: f64| (a.0 - b.0).norm() - a.1 - b.1 > bound;
    for (shape, solid) in shapes.iter().zip(&solids) {
        let Some((solid, ball)) = solid else { continue };
        for body in &scene.surroundings.bodies {
            if body.bounds.least_m(ball) > free_bound {
                continue;
            }
            let subject = || format!("{} / {} at {t_s:.2} s", shape.link, body.name);
            let rise = touches
                .iter()
                .filter(|touch| touch.patch.body == shape.body)
                .filter_map(|touch| Some((body.rise_over(touch.face, options)?, touch)))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            match rise {
                Some((rise, touch)) => {
                    let hint = column(&touch.face.X_WF.to_homogeneous(), 2);
                    let distance = signed_distance(solid, &body.solid, &[hint]);
                    let bound = -options.contact_depth_m - rise;
                    worst.add(Check::ContactDepth, distance, bound, subject);
                }
                None => {
                    let distance = signed_distance(solid, &body.solid, &[]);
                    worst.add(Check::Clearance, distance, free_bound, subject);
                }
            }
        }
    }
    for &(i, j) in posture.robot.collision.pairs() {
        if let (Some(Some((a, ball_a))), Some(Some((b, ball_b)))) = (solids.get(i), solids.get(j))
            && !far(ball_a, ball_b, own_bound)
        {
            let distance = signed_distance(a, b, &[]);
            worst.add(Check::SelfClearance, distance, own_bound, || {
                format!("{} / {} at {t_s:.2} s", shapes[i].link, shapes[j].link)
            });
        }
    }
}

/// A ball around a shape of the robot, in W.
fn ball_around(posture: &Posture, shape: &Shape) -> Option<Ball> {
    let pose = posture.X_WB.get(shape.body)? * shape.X_BG.to_homogeneous();
    let (centre, half) = shape.geometry.bounds();
    Some((point(&pose, &centre.coords), half.norm()))
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
            let corners = [-1.0, 1.0].into_iter().flat_map(|i| {
                [-1.0, 1.0]
                    .into_iter()
                    .flat_map(move |j| [-1.0, 1.0].map(|k| (i, j, k)))
            });
            Solid::hull(corners.map(|(i, j, k)| at(i * h.x, j * h.y, k * h.z)), 0.0)
        }
        ShapeGeometry::ConvexHull(hull) => {
            Solid::hull(hull.vertices().iter().map(|v| at(v.x, v.y, v.z)), 0.0)
        }
    }
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use nalgebra::{Isometry3, Point3, UnitQuaternion};
    use proptest::prelude::*;
    use robot_model::collision::{Hull, closest};

    use super::*;

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
        (
            prop::array::uniform3(-0.8..0.8),
            prop::array::uniform3(-2.0..2.0),
        )
            .prop_map(|(p, turn)| {
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
