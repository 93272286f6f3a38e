//! A phase in time: its duration, its samples, and the dense check of every one of them.
#![allow(non_snake_case)]

use nalgebra::{Point3, Vector3};
use robot_model::{GRAVITY_M_S2, Kinematics};

use crate::blend;
use crate::clearance::Watch;
use crate::config::Config;
use crate::failure::{Failure, Reason, keep_worst, patch_name};
use crate::problem::{Setting, Task};
use crate::projection::{ANGLE_ARM_M, is_point};
use crate::route::Route;
use crate::statics::Statics;
use crate::time_scaling::{RATE_MAX, quintic};
use crate::way::Way;

/// Numbers of a configuration that belong to the base: position and quaternion.
const BASE: usize = 7;
/// Instants at which rates are looked at before the duration is set.
const INSTANTS: usize = 200;
/// How far a joint may be inside its margin, rad. The postures at the ends may be on their bounds,
/// and a C² curve cannot follow a bound and leave it: it strays by less than a tenth of a degree,
/// 5 % of the margin.
const JOINT_TOLERANCE: f64 = 1.5e-3;
/// Patches stray from their places between the knots by this much more than the contacts may, as a
/// factor: the postures close their contacts to a tolerance of their own.
const CLOSURE_FACTOR: f64 = 5.0;

/// How far the patch in the air may be off its way between the knots, m: nothing is near it but what
/// the clearances are kept from, and those are checked where it is.
const SWING_TOLERANCE_M: f64 = 2e-3;

/// One sample of a phase.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub q: Vec<f64>,
    pub com_W: Vector3<f64>,
    pub forces_W: Vec<Vec<Vector3<f64>>>,
}

/// The samples of a phase, both ends included.
pub(crate) struct Track {
    pub samples: Vec<Instance>,
    /// Centre of mass of every body at every sample, m.
    places_W: Vec<Vec<Point3<f64>>>,
}

/// Steps of `dt_s` that the phase takes: the shortest time that is allowed, and as long as the
/// centre of mass, the joints and the patch in the air need.
///
///   T ≥ √(max |c''(s)| z_c / (g m)),   T ≥ max |q'(s)| / q̇_max,   T ≥ 1.875 L / v_max
pub(crate) fn steps(setting: &Setting, task: &Task, way: Option<&Way>, route: &mut Route) -> usize {
    let config = setting.config;
    let robot = setting.robot;
    let mut time = match way {
        Some(way) => config
            .swing_s
            .max(RATE_MAX * way.length_m / config.swing_speed_m_s),
        None => config.shift_s,
    };
    let ds = 1.0 / INSTANTS as f64;
    let u = |i: usize| quintic(i as f64 * ds);
    // The zero-moment point is off the centre of mass by its acceleration times z_c / g.
    let com: Vec<_> = (0..=INSTANTS)
        .map(|i| blend::com_W(&task.keys, u(i)))
        .collect();
    let lowest = task
        .closed
        .iter()
        .map(|c| c.X_WC.translation.vector.z)
        .fold(f64::INFINITY, f64::min);
    for w in com.windows(3) {
        let acceleration = (w[2] - 2.0 * w[1] + w[0]).xy().norm() / (ds * ds);
        let height = (w[1].z - lowest).max(0.0);
        let least = acceleration * height / (GRAVITY_M_S2 * config.zmp_excursion_m);
        time = time.max(least.sqrt());
    }
    let mut before = task.keys[0].q.clone();
    let mut now = before.clone();
    for i in 1..=INSTANTS {
        route.configuration(u(i), &mut now);
        for (b, body) in robot.bodies.iter().enumerate().skip(1) {
            let rate = (now.joints[b - 1] - before.joints[b - 1]).abs() / ds;
            time = time.max(rate / (body.velocity * config.joint_speed_use));
        }
        std::mem::swap(&mut before, &mut now);
    }
    (time / config.dt_s - 1e-9).ceil().max(1.0) as usize
}

/// Samples the route and checks every sample.
pub(crate) fn sample(
    setting: &Setting,
    task: &Task,
    way: Option<&Way>,
    route: &mut Route,
    steps: usize,
) -> Result<Track, Failure> {
    let robot = setting.robot;
    let mut q = task.keys[0].q.clone();
    let mut kinematics = Kinematics::new(robot, &q);
    let mut watch = Watch::new(setting, task);
    let mut statics = Statics::new(setting, task);
    let mut worst = None;
    let mut samples = Vec::with_capacity(steps + 1);
    let mut places_W = Vec::with_capacity(steps + 1);
    let mut last_quaternion = task.keys[0].q.R_WB.coords;
    for i in 0..=steps {
        let u = quintic(i as f64 / steps as f64);
        route.close(robot, u, &mut q, &mut kinematics);
        // q and −q are one orientation: stay on the side of the one before.
        if q.R_WB.coords.dot(&last_quaternion) < 0.0 {
            q.R_WB = nalgebra::UnitQuaternion::new_unchecked(-q.R_WB.into_inner());
        }
        last_quaternion = q.R_WB.coords;
        let forces_W = blend::forces_W(&task.keys, u);
        closure(setting, task, way, &kinematics, u, &mut worst);
        joints(setting, task, &q.joints, u, &mut worst);
        statics.check(&kinematics, &forces_W, u, &mut worst);
        watch.look(&kinematics, u, &mut worst);
        let bodies = robot.bodies.iter().zip(&kinematics.X_WB);
        places_W.push(
            bodies
                .map(|(body, X_WB)| X_WB * Point3::from(body.com_B))
                .collect(),
        );
        samples.push(Instance {
            q: q.to_q(),
            com_W: kinematics.com_W,
            forces_W,
        });
    }
    match worst {
        Some(failure) => Err(failure),
        None => Ok(Track { samples, places_W }),
    }
}

/// How fast the body is between two samples.
pub(crate) struct Fastest {
    /// Part of what is allowed: of the joints' speeds, or of the distance that a body moves.
    pub over: f64,
    joint: usize,
    /// Number of the second of the samples.
    sample: usize,
}

/// A body moves less than this part of the clearance between two samples: what lies between them is
/// clear then, too.
const STEP_PART: f64 = 0.6;

/// Where the track is fastest for what is allowed.
pub(crate) fn fastest(setting: &Setting, track: &Track) -> Fastest {
    let config = setting.config;
    let step_m = STEP_PART * setting.posture.clearance_m;
    let mut fastest = Fastest {
        over: 0.0,
        joint: 0,
        sample: 0,
    };
    let pairs = track.samples.windows(2).zip(track.places_W.windows(2));
    for (k, (pair, places)) in pairs.enumerate() {
        let mut keep = |over: f64, joint: usize| {
            if over > fastest.over {
                let sample = k + 1;
                fastest = Fastest {
                    over,
                    joint,
                    sample,
                };
            }
        };
        let steps = pair[0].q[BASE..].iter().zip(&pair[1].q[BASE..]);
        for (joint, ((a, b), body)) in steps.zip(setting.robot.joint_bodies()).enumerate() {
            keep(
                (b - a).abs() / (config.dt_s * body.velocity * config.joint_speed_use),
                joint,
            );
        }
        for (body, (a, b)) in places[0].iter().zip(&places[1]).enumerate() {
            keep((b - a).norm() / step_m, body.saturating_sub(1));
        }
    }
    fastest
}

/// Vertical accelerations are taken over twice this time: contacts are closed to within a tolerance, anew
/// at every sample.
const LIFT_S: f64 = 0.03;

/// How much longer a track has to take for its vertical acceleration to be allowed; 1 where it is.
///
/// In T times the time an acceleration is its T²th part. The postures that a way is made of are at rest;
/// what lies between them may rise and fall more than they do.
pub(crate) fn slower_for_lift(config: &Config, track: &Track) -> f64 {
    let heights = track.samples.iter().map(|sample| sample.com_W.z);
    let ahead = (LIFT_S / config.dt_s).ceil().max(1.0) as usize;
    let between = heights.clone().skip(ahead);
    let bends = heights.clone().zip(between).zip(heights.skip(2 * ahead));
    let most = bends
        .map(|((a, b), c)| (c - 2.0 * b + a).abs())
        .fold(0.0, f64::max);
    let most_m_s2 = most / (ahead as f64 * config.dt_s).powi(2);
    (most_m_s2 / config.lift_m_s2).sqrt().max(1.0)
}

/// A track that is still too fast when its time was stretched: the postures that close the contacts
/// leap from one side of something to the other.
pub(crate) fn leap(setting: &Setting, task: &Task, track: &Track, fastest: &Fastest) -> Failure {
    let [before, after] =
        [fastest.sample - 1, fastest.sample].map(|k| track.samples[k].q[BASE + fastest.joint]);
    let joint = setting.robot.joint_bodies()[fastest.joint].joint.clone();
    let s = fastest.sample as f64 / (track.samples.len() - 1) as f64;
    let leap = (after - before).abs();
    setting.failure(task, Reason::Leap { joint }, leap, quintic(s))
}

/// Closed contacts are closed; the patch in the air is on its way.
fn closure(
    setting: &Setting,
    task: &Task,
    way: Option<&Way>,
    kinematics: &Kinematics,
    u: f64,
    worst: &mut Option<Failure>,
) {
    let tolerance = CLOSURE_FACTOR * setting.config.closure_m;
    let swing = task.swing.as_ref().zip(way);
    let swing = swing.map(|(s, way)| {
        let free = way.turn_freedom(u) > 0.0;
        (s.patch, way.pose(u), SWING_TOLERANCE_M, free)
    });
    let closed = task
        .closed
        .iter()
        .map(|c| (c.patch, c.X_WC, tolerance, false));
    for (patch, wanted, tolerance, free) in closed.chain(swing) {
        let X_WC = kinematics.X_WC(&setting.robot.patches[patch]);
        let mut apart = (X_WC.translation.vector - wanted.translation.vector).norm();
        if !free && !is_point(setting.robot, patch) {
            apart = apart.max(ANGLE_ARM_M * X_WC.rotation.angle_to(&wanted.rotation));
        }
        if apart.is_nan() || apart > tolerance {
            let patch = Some(patch_name(setting, patch));
            keep_worst(
                worst,
                setting.failure(task, Reason::Closure { patch }, apart, u),
            );
        }
    }
}

fn joints(
    setting: &Setting,
    task: &Task,
    joints: &nalgebra::DVector<f64>,
    u: f64,
    worst: &mut Option<Failure>,
) {
    for (q, body) in joints.iter().zip(setting.robot.joint_bodies()) {
        let range = (body.upper - body.lower).max(0.0);
        let margin = setting.posture.joint_margin_rad.min(0.25 * range) - JOINT_TOLERANCE;
        let over = (body.lower + margin - q).max(q - body.upper + margin);
        if over > 0.0 {
            let joint = body.joint.clone();
            keep_worst(
                worst,
                setting.failure(task, Reason::JointLimit { joint }, over, u),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A track of which only the heights matter.
    fn track(heights: impl Iterator<Item = f64>) -> Track {
        let sample = |z| Instance {
            q: Vec::new(),
            com_W: Vector3::new(0.0, 0.0, z),
            forces_W: Vec::new(),
        };
        Track {
            samples: heights.map(sample).collect(),
            places_W: Vec::new(),
        }
    }

    #[test]
    fn what_rises_four_times_too_fast_takes_twice_the_time() {
        let mut config = Config::default();
        for dt_s in [0.001, 0.01] {
            config.dt_s = dt_s;
            let end = (0.5 / dt_s) as usize;
            let time = |i: usize| i as f64 * dt_s;
            // Up from rest within half a second, and what closing the contacts adds to that.
            let noise = |i: usize| if i.is_multiple_of(2) { 1e-5 } else { -1e-5 };
            let rise = |i: usize| 2.0 * config.lift_m_s2 * time(i).powi(2) + noise(i);
            let slower = slower_for_lift(&config, &track((0..=end).map(rise)));
            assert!((slower - 2.0).abs() < 0.05, "{slower}");
            let even = |i: usize| 0.5 * time(i) + noise(i);
            assert_eq!(slower_for_lift(&config, &track((0..=end).map(even))), 1.0);
        }
        // Too short to rise at all.
        assert_eq!(
            slower_for_lift(&config, &track([0.0, 1.0].into_iter())),
            1.0
        );
    }
}
