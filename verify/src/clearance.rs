//! Nothing but contacts is near the environment, contacts do not sink in, and the robot's parts
//! are apart.

use nalgebra::{Matrix4, Vector3};
use robot_model::Robot;
use robot_model::collision::ShapeGeometry;
use surfaces::Face;

use crate::Check;
use crate::distance::{Ball, Placed as Still, Solid};
use crate::extremes::Extremes;
use crate::findings::Findings;
use crate::posture::{column, point};
use crate::scene::{Placed, Scene};
use crate::step::{Moment, Step};
use crate::surroundings::Body;
use crate::watch::{Asked, Other, Two, Watch};

/// What is farther over its bound than this is not measured in a stance, m.
const FAR_M: f64 = 0.5;

/// A value that is worse than the worst by less than this need not be told, m.
const TOLD_M: f64 = 1e-6;

/// The smallest distances found in a stance, m; infinite where all is far.
pub(crate) struct Nearest {
    pub environment: f64,
    pub own: f64,
}

/// The distances of one stance.
pub(crate) fn check(placed: &Placed, findings: &mut Findings) -> Nearest {
    let mut worst = Extremes::default();
    let scene = placed.scene;
    let bounds = Bounds::new(scene, scene.options.distance_m, FAR_M);
    // Where nothing is near, that is what is found.
    for (check, bound) in [
        (Check::Clearance, bounds.free),
        (Check::ContactDepth, bounds.touching),
        (Check::SelfClearance, bounds.own),
    ] {
        worst.add(check, f64::INFINITY, bound, String::new);
    }
    let touches = placed.touches.iter().map(|t| (t.patch.body, t.face));
    let touches: Vec<(usize, &Face)> = touches.collect();
    let now = Moment::new(scene, &placed.posture, None);
    let mut pairs = Pairs::new(scene, &touches, bounds, &[&now]);
    let step = Step {
        before: None,
        now: &now,
        bends_m: &[],
        at: &|_| None,
    };
    pairs.look(&step, &vec![true; touches.len()], "", &mut worst);
    let nearest = Nearest {
        environment: worst.value(Check::Clearance),
        own: worst.value(Check::SelfClearance),
    };
    worst.report(placed.at, findings);
    nearest
}

/// The least distances that are allowed, and how far over them is too far to be measured, m.
pub(crate) struct Bounds {
    free: f64,
    touching: f64,
    own: f64,
    beyond: f64,
}

impl Bounds {
    fn new(scene: &Scene, slack_m: f64, beyond: f64) -> Self {
        let required = &scene.plan.required;
        Self {
            free: required.clearance_m - slack_m,
            touching: -scene.options.contact_depth_m,
            own: required.self_clearance_m - slack_m,
            beyond,
        }
    }

    /// Those of a motion, of what could be nearer than it may.
    pub fn of_motion(scene: &Scene) -> Self {
        Self::new(scene, scene.options.motion_distance_m, 0.0)
    }
}

/// A shape of the robot and a body of the environment.
struct Near<'a> {
    shape: usize,
    body: &'a Body,
    still: Still<'a>,
    watch: Watch,
    /// What may touch the body: the touch, how far the body rises over the touched plane where that is
    /// little, and else the part that rises over it.
    parts: Vec<Part>,
}

struct Part {
    touch: usize,
    normal: Vector3<f64>,
    rise: Result<f64, (Solid, Watch)>,
}

/// All that may come near each other, watched over some time.
pub(crate) struct Pairs<'a> {
    scene: &'a Scene<'a>,
    bounds: Bounds,
    environment: Vec<Near<'a>>,
    own: Vec<(usize, usize, Watch)>,
}

impl<'a> Pairs<'a> {
    /// Of robot and environment, and of the robot and itself, the nearest first. `touches` are the
    /// bodies and faces that may touch; the environment is looked up around all of some moments.
    pub fn new(
        scene: &'a Scene,
        touches: &[(usize, &Face)],
        bounds: Bounds,
        moments: &[&Moment],
    ) -> Self {
        let reach_m = bounds.beyond + bounds.free.max(0.0);
        let mut environment = Vec::new();
        for (shape, (body, _)) in scene.shapes.iter().enumerate() {
            let balls = moments.iter().map(|moment| moment.shapes[shape].ball());
            for other in scene.surroundings.near(balls, reach_m) {
                let own = touches.iter().enumerate().filter(|(_, t)| t.0 == *body);
                let part = |(touch, (_, face)): (usize, &(usize, &Face))| Part {
                    touch,
                    normal: -column(&face.X_WF.to_homogeneous(), 2),
                    rise: (other.rise_over(face, scene.options))
                        .ok_or_else(|| (other.above(face, scene.options), Watch::new())),
                };
                environment.push(Near {
                    shape,
                    body: other,
                    still: other.solid.here(),
                    watch: Watch::new(),
                    parts: own.map(part).collect(),
                });
            }
        }
        let pairs = scene.robot.collision.pairs().iter();
        let mut own: Vec<_> = pairs.map(|&(i, j)| (i, j, Watch::new())).collect();
        if let Some(first) = moments.first() {
            let ball = |shape: usize| first.shapes[shape].ball();
            environment
                .sort_by_cached_key(|near| Ordered(near.body.bounds.least_m(&ball(near.shape))));
            own.sort_by_cached_key(|(i, j, _)| Ordered(apart(&ball(*i), &ball(*j))));
        }
        Self {
            scene,
            bounds,
            environment,
            own,
        }
    }

    /// The worst distances of a step; `active` says which touches there are during it.
    pub fn look(&mut self, step: &Step, active: &[bool], at: &str, worst: &mut Extremes) {
        let shapes = self.scene.robot.collision.shapes();
        let (free, touching) = (self.bounds.free, self.bounds.touching);
        let far = self.bounds.beyond;
        let asked = |worst: &Extremes, check: Check, bound: f64| Asked {
            bound,
            enough: bound
                + worst
                    .margin(check)
                    .min((worst.margin(check) - TOLD_M).max(0.0)),
            far: bound + far,
        };
        for near in &mut self.environment {
            let two = Two(near.shape, Other::Still(&near.still));
            let boxes = || {
                near.body
                    .bounds
                    .least_m(&step.now.shapes[near.shape].ball())
            };
            let subject = || format!("{} / {}{at}", shapes[near.shape].link, near.body.name);
            let mut hints = Vec::new();
            let mut rise = f64::NEG_INFINITY;
            for part in near.parts.iter().filter(|part| active[part.touch]) {
                hints.push(part.normal);
                rise = rise.max(part.rise.as_ref().map_or(f64::NEG_INFINITY, |rise| *rise));
            }
            if hints.is_empty() {
                let asked = asked(worst, Check::Clearance, free);
                if let Some(found) = near.watch.look(two, step, &asked, &[], boxes) {
                    worst.add(Check::Clearance, found, free, subject);
                }
                continue;
            }
            let bound = touching - rise.max(0.0);
            let deep = asked(worst, Check::ContactDepth, bound);
            if let Some(found) = near.watch.look(two, step, &deep, &hints, boxes) {
                worst.add(Check::ContactDepth, found, bound, subject);
            }
            if rise.is_finite() {
                continue;
            }
            // What rises over the plane of a contact: the part that does is to be kept away from.
            let asked = asked(worst, Check::Clearance, free);
            let mut most = Some(f64::NEG_INFINITY);
            for part in near.parts.iter_mut().filter(|part| active[part.touch]) {
                if let Err((above, watch)) = &mut part.rise {
                    let still = above.here();
                    let two = Two(near.shape, Other::Still(&still));
                    let found = watch.look(two, step, &asked, &[], boxes);
                    most = most.and_then(|most| found.map(|found| most.max(found)));
                }
            }
            if let Some(found) = most {
                worst.add(Check::Clearance, found, free, subject);
            }
        }
        for (i, j, watch) in &mut self.own {
            let asked = asked(worst, Check::SelfClearance, self.bounds.own);
            let ball = |shape: usize| step.now.shapes[shape].ball();
            let boxes = || apart(&ball(*i), &ball(*j));
            let two = Two(*i, Other::Shape(*j));
            if let Some(found) = watch.look(two, step, &asked, &[], boxes) {
                worst.add(Check::SelfClearance, found, self.bounds.own, || {
                    format!("{} / {}{at}", shapes[*i].link, shapes[*j].link)
                });
            }
        }
    }
}

/// How far two balls are apart, m.
fn apart(a: &Ball, b: &Ball) -> f64 {
    (a.0 - b.0).norm() - a.1 - b.1
}

/// A number that can be sorted by.
#[derive(PartialEq)]
struct Ordered(f64);

impl Eq for Ordered {}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The robot's shapes, each with its body, in the body's frame.
pub(crate) fn shapes(robot: &Robot) -> Vec<(usize, Solid)> {
    let shapes = robot.collision.shapes().iter();
    let solid = |shape: &robot_model::collision::Shape| {
        (
            shape.body,
            solid(&shape.geometry, &shape.X_BG.to_homogeneous()),
        )
    };
    shapes.map(solid).collect()
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
            Solid::hull(hull.vertices().iter().map(|v| at(v.x, v.y, v.z)), 0.0)
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
                &solid(&b, &nalgebra::Matrix4::identity()).at(&X_WB.to_homogeneous()),
                &[],
                f64::INFINITY,
            ).0;
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
