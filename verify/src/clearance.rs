//! Nothing but contacts is near the environment, contacts do not sink in, and the robot's parts
//! are apart.

use nalgebra::Vector3;
use robot_model::{ContactPatch, Robot};
use surfaces::Face;

use crate::extremes::Extremes;
use crate::findings::Findings;
use crate::posture::column;
use crate::scene::{Placed, Scene};
use crate::shapes::Shank;
use crate::solid::{Ball, Placed as Still, Solid};
use crate::step::{Moment, Step};
use crate::surroundings::Body;
use crate::watch::{Asked, Other, Two, Watch};
use crate::{Check, TOLERANCES};

/// What is farther over its bound than this is not measured in a stance, m.
const FAR_M: f64 = 0.5;

/// Links that carry a sole or a palm: as many joints are between, at most, those of an ankle or a wrist.
pub(crate) const CARRYING_JOINTS: usize = 2;

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
    let bounds = Bounds::new(scene, TOLERANCES.distance_m, FAR_M);
    // Where nothing is near, that is what is found.
    for (check, bound) in [
        (Check::Clearance, bounds.free),
        (Check::ContactDepth, bounds.touching),
        (Check::SelfClearance, bounds.own),
    ] {
        worst.add(check, f64::INFINITY, bound, String::new);
    }
    let touches = placed.touches.iter().map(|t| (t.patch, t.face));
    let touches: Vec<(&ContactPatch, &Face)> = touches.collect();
    let now = Moment::new(scene, &placed.posture, None);
    let mut pairs = Pairs::new(scene, &touches, bounds, &[&now]);
    let step = Step {
        before: None,
        now: &now,
        bends_m: &[],
        at: &|_| None,
    };
    let heights_m = vec![f64::NEG_INFINITY; touches.len()];
    pairs.look(&step, &heights_m, "", &mut worst);
    let nearest = Nearest {
        environment: worst.value(Check::Clearance),
        own: worst.value(Check::SelfClearance),
    };
    worst.report(placed.at, findings);
    nearest
}

/// The least distances that are allowed, and how far over them is too far to be measured, m.
pub(crate) struct Bounds {
    slack: f64,
    free: f64,
    touching: f64,
    own: f64,
    beyond: f64,
}

impl Bounds {
    fn new(scene: &Scene, slack_m: f64, beyond: f64) -> Self {
        let required = &scene.plan.required;
        Self {
            slack: slack_m,
            free: required.clearance_m - slack_m,
            touching: -TOLERANCES.contact_depth_m,
            own: required.self_clearance_m - slack_m,
            beyond,
        }
    }

    /// Those of a motion, of what could be nearer than it may.
    pub fn of_motion(scene: &Scene) -> Self {
        Self::new(scene, TOLERANCES.motion_distance_m, 0.0)
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
    /// Whether the shape is the touching link's, not one of those that carry it.
    is_own: bool,
    is_ball: bool,
    normal: Vector3<f64>,
    rise: Result<f64, (Solid, Watch)>,
    /// What of the shape is not near its ball, and what it keeps from ground that the ball may touch, m.
    beyond: Option<(usize, f64, Watch)>,
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
    /// patches and faces that may touch; the environment is looked up around all of some moments.
    pub fn new(
        scene: &'a Scene,
        touches: &[(&ContactPatch, &Face)],
        bounds: Bounds,
        moments: &[&Moment],
    ) -> Self {
        let reach_m = bounds.beyond + bounds.free.max(0.0);
        let mut environment = Vec::new();
        for (shape, drawn) in scene.robot.collision.shapes().iter().enumerate() {
            let body = drawn.body;
            let balls = moments.iter().map(|moment| moment.shapes[shape].ball());
            for other in scene.surroundings.near(balls, reach_m) {
                // A sole or a palm holds what carries it over the touched plane.
                let carries = |patch: &ContactPatch| match patch.point_radius_m() {
                    Some(_) => patch.body == body,
                    None => joints_between(scene.robot, patch.body, body) <= CARRYING_JOINTS,
                };
                let held = (touches.iter().enumerate()).filter(|(_, t)| carries(t.0));
                let part = |(touch, (patch, face)): (usize, &(&ContactPatch, &Face))| Part {
                    touch,
                    is_own: patch.body == body,
                    is_ball: patch.point_radius_m().is_some(),
                    normal: -column(&face.X_WF.to_homogeneous(), 2),
                    rise: (other.rise_over(face)).ok_or_else(|| (other.above(face), Watch::new())),
                    beyond: patch.point_radius_m().and_then(|radius_m| {
                        let of = |s: &&Shank| {
                            s.shape == shape && scene.robot.patches[s.patch].name == patch.name
                        };
                        let least = (0.5 * radius_m - bounds.slack).min(bounds.free);
                        let shank = scene.shanks.iter().find(of)?;
                        Some((shank.beyond, least, Watch::new()))
                    }),
                };
                environment.push(Near {
                    shape,
                    body: other,
                    still: other.solid.here(),
                    watch: Watch::new(),
                    parts: held.map(part).collect(),
                });
            }
        }
        let pairs = scene.robot.collision.pairs().iter();
        let mut own: Vec<_> = pairs.map(|&(i, j)| (i, j, Watch::new())).collect();
        if let Some(first) = moments.first() {
            let ball = |shape: usize| first.shapes[shape].ball();
            let to_body = |near: &Near| near.body.bounds.least_m(&ball(near.shape));
            environment.sort_by(|a, b| to_body(a).total_cmp(&to_body(b)));
            let between = |(i, j, _): &(usize, usize, Watch)| apart(&ball(*i), &ball(*j));
            own.sort_by(|a, b| between(a).total_cmp(&between(b)));
        }
        Self {
            scene,
            bounds,
            environment,
            own,
        }
    }

    /// The worst distances of a step; `heights_m` says how far over what it may touch each touch is during it: over the
    /// face, and as much farther over a body as that rises over the face.
    pub fn look(&mut self, step: &Step, heights_m: &[f64], at: &str, worst: &mut Extremes) {
        let shapes = self.scene.robot.collision.shapes();
        let (free, touching) = (self.bounds.free, self.bounds.touching);
        let far = self.bounds.beyond;
        let is_active = |part: &Part| {
            let rise = part.rise.as_ref().map_or(0.0, |rise| *rise);
            heights_m[part.touch] - rise < TOLERANCES.motion_touch_m
        };
        let asked = |worst: &Extremes, check: Check, bound: f64| {
            let margin = worst.margin(check);
            Asked {
                bound,
                enough: bound + margin.min((margin - TOLD_M).max(0.0)),
                far: bound + far,
            }
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
            for part in near.parts.iter().filter(|part| is_active(part)) {
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
            // Behind a plane that the link itself touches it is as deep as its patch; behind one that it is held over, not.
            let is_held = |own: bool| {
                let mut parts = near.parts.iter().filter(|part| is_active(part));
                parts.any(|part| part.is_own == own && part.rise.is_ok())
            };
            let touches = near.parts.iter().any(|part| is_active(part) && part.is_own);
            let is_own = is_held(true) || (touches && !is_held(false));
            let bound = match (is_own, shapes[near.shape].is_pad) {
                (false, _) => self.bounds.own.min(free),
                (true, true) => touching - rise.max(0.0),
                (true, false) => 0.0,
            };
            let deep = asked(worst, Check::ContactDepth, bound);
            if let Some(found) = near.watch.look(two, step, &deep, &hints, boxes) {
                worst.add(Check::ContactDepth, found, bound, subject);
            }
            if rise.is_finite() {
                continue;
            }
            // What rises over the plane of a contact: the part that does is to be kept away from.
            let clear = asked(worst, Check::Clearance, free);
            let mut most = Some(f64::NEG_INFINITY);
            for part in near.parts.iter_mut().filter(|part| is_active(part)) {
                if let Err((above, watch)) = &mut part.rise {
                    let still = above.here();
                    let two = Two(near.shape, Other::Still(&still));
                    let found = watch.look(two, step, &clear, &[], boxes);
                    most = most.and_then(|most| found.map(|found| most.max(found)));
                }
            }
            // Beside a ball it may be ground that it touches as well.
            let is_ground = |part: &Part| {
                let most_rad = TOLERANCES.beside_ball_rad;
                part.is_ball && two.parted(step, &part.normal, most_rad, bound)
            };
            let Some(found) = most else {
                continue;
            };
            let mut parts = near.parts.iter_mut().filter(|part| is_active(part));
            let Some(ground) = parts.find(|part| is_ground(part)) else {
                worst.add(Check::Clearance, found, free, subject);
                continue;
            };
            if let Some((beyond, least, watch)) = &mut ground.beyond {
                let asked = asked(worst, Check::ContactDepth, *least);
                let two = Two(*beyond, Other::Still(&near.still));
                if let Some(found) = watch.look(two, step, &asked, &[], boxes) {
                    worst.add(Check::ContactDepth, found, *least, subject);
                }
            }
        }
        let asked = |worst: &Extremes| asked(worst, Check::SelfClearance, self.bounds.own);
        let mut own = asked(worst);
        for (i, j, watch) in &mut self.own {
            let ball = |shape: usize| step.now.shapes[shape].ball();
            let boxes = || apart(&ball(*i), &ball(*j));
            let two = Two(*i, Other::Shape(*j));
            if let Some(found) = watch.look(two, step, &own, &[], boxes) {
                worst.add(Check::SelfClearance, found, self.bounds.own, || {
                    format!("{} / {}{at}", shapes[*i].link, shapes[*j].link)
                });
                own = asked(worst);
            }
        }
    }
}

/// How many joints are between two bodies.
pub(crate) fn joints_between(robot: &Robot, a: usize, b: usize) -> usize {
    (1..robot.bodies.len())
        .filter(|&joint| robot.supports(joint, a) != robot.supports(joint, b))
        .count()
}

/// How far two balls are apart, m.
fn apart(a: &Ball, b: &Ball) -> f64 {
    (a.0 - b.0).norm() - a.1 - b.1
}
