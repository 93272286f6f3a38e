//! Distances along a motion, by bounds on how far the shapes move.
//!
//! A pair of shapes at distance d that may come as near as m needs no look until the two have moved
//! by d − m together: a shape's points move at most by its centre's move and 2 sin(θ/2) times its
//! radius. So the distance is known to keep m at every sample, and between two samples to fall
//! short by less than half of what the pair moves in one step.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use posture::PlacedShape;
use robot_model::Kinematics;
use robot_model::collision::{Shape, closest};

use crate::airborne::{Airborne, touching_m};
use crate::failure::{Failure, Reason, keep_worst};
use crate::problem::{MotionContext, Task};

/// Pairs farther apart than this are not measured exactly, m.
const LOOK_M: f64 = 0.15;
/// Bodies of the environment farther than this from the robot are not looked at until it has moved, m.
const AROUND_M: f64 = 0.5;
/// By how much a distance may fall short, m. The postures at the ends may be on their bounds, and a
/// C² curve cannot follow a bound and leave it: 5 % of the margin to the environment, less what it
/// may stray between two samples.
pub(crate) const TOLERANCE_M: f64 = 4e-4;
/// By how much less two parts of the robot may be apart between two samples, m. The certificate has 0.2 mm
/// there; a quarter of it is for ways that are not straight.
const BETWEEN_M: f64 = 1.5e-4;

/// How much farther a shape may move to the next sample than from the last one.
const FURTHER: f64 = 1.5;

/// A ball around a shape.
struct Ball {
    centre_G: Point3<f64>,
    radius: f64,
}

/// A shape where it is.
#[derive(Clone, Copy)]
struct Placed {
    X_WG: Isometry3<f64>,
    centre: Point3<f64>,
    /// How far its centre moved since the last sample, and how far its points turned about it at most, m.
    step: Vector3<f64>,
    turned_m: f64,
}

/// Checks the distances of one phase, sample by sample.
pub(crate) struct ClearanceMonitor<'a> {
    context: &'a MotionContext<'a>,
    task: &'a Task,
    swing_body: Option<usize>,
    balls: Vec<Ball>,
    placed: Vec<Placed>,
    /// How far each shape moved since the last sample, at most, and in all, m.
    moved: Vec<f64>,
    gone: Vec<f64>,
    /// For each pair of the robot's shapes, by how much they may still move.
    own: Vec<f64>,
    /// The bodies of the environment that are near the robot, by index.
    near: Vec<usize>,
    /// By how much every shape may move until another body could be too near, m.
    alone_m: f64,
    /// How far each shape may have gone beside each of the near bodies, by shape, and beside all of them.
    world: Vec<f64>,
    soonest: Vec<f64>,
    fresh: bool,
    /// How much shorter steps have to be for parts of the robot that pass each other.
    pub coarse: f64,
}

impl<'a> ClearanceMonitor<'a> {
    pub fn new(context: &'a MotionContext<'a>, task: &'a Task) -> Self {
        let collision = &context.robot.collision;
        let ball = |shape: &Shape| {
            let (centre_G, half) = shape.geometry.bounds();
            let radius = half.norm();
            Ball { centre_G, radius }
        };
        let balls: Vec<Ball> = collision.shapes().iter().map(ball).collect();
        let at = Placed {
            X_WG: Isometry3::identity(),
            centre: Point3::origin(),
            step: Vector3::zeros(),
            turned_m: 0.0,
        };
        let swing = task.swing.as_ref();
        Self {
            context,
            task,
            swing_body: swing.map(|s| context.robot.patches[s.patch].body),
            placed: vec![at; balls.len()],
            moved: vec![0.0; balls.len()],
            gone: vec![0.0; balls.len()],
            own: vec![0.0; collision.pairs().len()],
            near: Vec::new(),
            alone_m: 0.0,
            world: Vec::new(),
            soonest: vec![0.0; balls.len()],
            balls,
            fresh: true,
            coarse: 0.0,
        }
    }

    /// Looks at the next sample; `at` is where it is on the path.
    pub fn look(&mut self, kinematics: &Kinematics, at: f64, worst: &mut Option<Failure>) {
        self.place(kinematics);
        let air = self.task.swing.as_ref().map(|swing| {
            let patch = &self.context.robot.patches[swing.patch];
            Airborne::new(self.context, swing, &kinematics.X_WC(patch))
        });
        self.look_at_own(at, worst);
        self.look_at_world(at, air.as_ref(), worst);
        self.fresh = false;
    }

    fn place(&mut self, kinematics: &Kinematics) {
        let shapes = self.context.robot.collision.shapes();
        for (i, (shape, ball)) in shapes.iter().zip(&self.balls).enumerate() {
            let X_WG = kinematics.X_WB[shape.body] * shape.X_BG;
            let centre = X_WG * ball.centre_G;
            let before = &self.placed[i];
            let (mut step, mut turned_m) = (Vector3::zeros(), 0.0);
            if !self.fresh {
                step = centre - before.centre;
                turned_m = chord(&before.X_WG.rotation, &X_WG.rotation) * ball.radius;
                self.moved[i] = step.norm() + turned_m;
                self.gone[i] += self.moved[i];
            }
            self.placed[i] = Placed {
                X_WG,
                centre,
                step,
                turned_m,
            };
        }
    }

    fn look_at_own(&mut self, at: f64, worst: &mut Option<Failure>) {
        let collision = &self.context.robot.collision;
        let shapes = collision.shapes();
        let required = self.context.posture.self_clearance_m;
        let least = (required - TOLERANCE_M - BETWEEN_M).max(0.0);
        for (left, &(i, j)) in self.own.iter_mut().zip(collision.pairs()) {
            let before = *left + required;
            *left -= self.moved[i] + self.moved[j];
            if *left > 0.0 {
                continue;
            }
            let (a, b) = (&self.placed[i], &self.placed[j]);
            let apart = (a.centre - b.centre).norm() - self.balls[i].radius - self.balls[j].radius;
            if apart > LOOK_M {
                *left = apart - required;
                continue;
            }
            let [one, other] = [i, j].map(|k| &shapes[k].geometry);
            let found = closest(one, &a.X_WG, other, &b.X_WG, LOOK_M);
            let distance = found.map_or(LOOK_M, |f| f.distance);
            *left = distance - required;
            // On a straight way past each other they stay apart by h if √(d₀² − h²) + √(d₁² − h²) is no
            // shorter than the way; both factors are bounded, so that parts which may touch do not ask for steps
            // without end.
            let passed_m = (a.step - b.step).norm() + a.turned_m + b.turned_m;
            let beside =
                |d: f64| ((d - least).max(BETWEEN_M) * (d + least).max(TOLERANCE_M)).sqrt();
            self.coarse = (self.coarse).max(passed_m / (beside(before) + beside(distance)));
            if *left < -TOLERANCE_M {
                let reason = Reason::SelfClearance {
                    link: shapes[i].link.clone(),
                    other: shapes[j].link.clone(),
                };
                keep_worst(worst, self.context.failure(self.task, reason, -*left, at));
            }
        }
    }

    /// Finds the bodies of the environment that are near the robot, once it has moved far enough to
    /// come near to others.
    fn find_near(&mut self) {
        let context = self.context;
        self.alone_m -= self.moved.iter().copied().fold(0.0, f64::max);
        if !self.fresh && self.alone_m > 0.0 {
            return;
        }
        let corners = self.placed.iter().zip(&self.balls).map(|(placed, ball)| {
            let reach = Vector3::repeat(ball.radius);
            (placed.centre - reach, placed.centre + reach)
        });
        let Some((low, high)) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))) else {
            return;
        };
        self.near = context.environment.world().near(&low, &high, AROUND_M);
        self.world = vec![0.0; self.balls.len() * self.near.len()];
        self.soonest.fill(0.0);
        let most = context
            .posture
            .clearance_m
            .max(context.config.swing_clearance_m);
        self.alone_m = AROUND_M - most;
    }

    fn look_at_world(&mut self, at: f64, air: Option<&Airborne>, worst: &mut Option<Failure>) {
        self.find_near();
        let (context, task) = (self.context, self.task);
        let shapes = context.robot.collision.shapes();
        let obstacles = context.environment.world().obstacles();
        let beside = context.posture.clearance_m;
        let most = beside.max(context.config.swing_clearance_m);
        for (i, shape) in shapes.iter().enumerate() {
            let gone = self.gone[i];
            if self.soonest[i] > gone {
                continue;
            }
            let swings = self.swing_body == Some(shape.body);
            let carries = |swung| context.robot.are_close(swung, shape.body);
            let may_land = self.swing_body.is_some_and(carries);
            let row = &mut self.world[i * self.near.len()..(i + 1) * self.near.len()];
            for (&o, until) in self.near.iter().zip(&mut *row) {
                if *until > gone {
                    continue;
                }
                let in_air = air.filter(|_| swings);
                let placed = &self.placed[i];
                let apart = obstacles[o].distance_m(&placed.centre) - self.balls[i].radius;
                if apart > LOOK_M {
                    *until = gone + apart - most;
                    continue;
                }
                let moves_m = (FURTHER * self.moved[i]).min(0.5 * beside);
                let touching = touching_m(context, task, air, shape, o, moves_m);
                // What a patch touches changes while it is in the air alone.
                if touching == Some(f64::NEG_INFINITY) {
                    *until = if swings { gone } else { f64::INFINITY };
                    continue;
                }
                let (other, pose) = (obstacles[o].geometry(), obstacles[o].pose());
                let found = closest(&shape.geometry, &placed.X_WG, other, pose, LOOK_M);
                let Some(found) = found else {
                    *until = gone + LOOK_M - most;
                    continue;
                };
                let shape_here = PlacedShape {
                    geometry: &shape.geometry,
                    X_BG: &shape.X_BG,
                    X_WG: &placed.X_WG,
                    is_pad: shape.is_pad,
                    nearest_W: found.p_a_W,
                    normal_W: found.normal_W,
                };
                let beside_contact = || {
                    let on = (shape.body, &shape_here);
                    (in_air)
                        .and_then(|a| a.beside_contact_m(context, on.1, o, moves_m))
                        .or_else(|| task.beside_contact_m(context, on, o))
                };
                let required = match (touching.or_else(beside_contact), in_air) {
                    (Some(least_m), _) => least_m,
                    (None, Some(air)) => air.required_m(context, &found.normal_W, 0.0),
                    (None, None) => beside,
                };
                let short = required - found.distance;
                // What is asked of a patch in the air grows along its path, and beside a contact with where a shape
                // leans: look again in good time.
                *until = gone
                    + match touching {
                        Some(_) if may_land => 0.0,
                        Some(least_m) => found.distance - least_m,
                        None => found.distance - if swings { most } else { beside },
                    };
                if short > TOLERANCE_M {
                    let reason = Reason::Clearance {
                        link: shape.link.clone(),
                        body: context.environment.body_name(o).to_owned(),
                    };
                    keep_worst(worst, context.failure(task, reason, short, at));
                }
            }
            self.soonest[i] = row.iter().copied().fold(f64::INFINITY, f64::min);
        }
    }
}

/// 2 sin(θ/2) of the rotation between two orientations: how far a point at unit distance moves.
fn chord(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    // |a − b|² = 2 − 2 cos(θ/2) for the nearer of ±b; sin(θ/2) ≤ |a − b|.
    let (plus, minus) = ((a.coords - b.coords).norm(), (a.coords + b.coords).norm());
    2.0 * plus.min(minus)
}
