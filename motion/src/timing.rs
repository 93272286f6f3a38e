//! A phase in time: how long it takes, and whether its samples are as slow as they should be.
#![allow(non_snake_case)]

use robot_model::GRAVITY_M_S2;

use crate::blend;
use crate::config::Config;
use crate::failure::{Failure, Reason};
use crate::problem::{MotionContext, Task};
use crate::route::Route;
use crate::sampling::SampledTrajectory;
use crate::swing_path::SwingPath;
use crate::time_scaling::{RATE_MAX, quintic};

/// Numbers of a configuration that belong to the base: position and quaternion.
const BASE: usize = 7;
/// Instants at which rates are looked at before the duration is set.
const INSTANTS: usize = 200;
/// Part of the margin of the centre of mass that its acceleration may use, m: the zero-moment point
/// stays this near to it.
const ZMP_EXCURSION_M: f64 = 0.015;
/// Largest vertical acceleration of the centre of mass, m/s²: forces and torques, which are those of
/// standing still, are more by its part of gravity.
const LIFT_MAX_M_S2: f64 = 1.5;

/// Steps of `dt_s` that the phase takes: the shortest time that is allowed, and as long as the
/// centre of mass, the joints and the patch in the air need.
///
///   T ≥ √(max |c''(s)| z_c / (g m)),   T ≥ max |q'(s)| / q̇_max,   T ≥ 1.875 L / v_max
pub(crate) fn steps(
    context: &MotionContext,
    task: &Task,
    path: Option<&SwingPath>,
    route: &mut Route,
) -> usize {
    let config = context.config;
    let robot = context.robot;
    let mut time = path.map_or(config.shift_s, |path| {
        let least = RATE_MAX * path.length_m / config.swing_speed_m_s;
        config.swing_s.max(least)
    });
    let ds = 1.0 / INSTANTS as f64;
    let u = |i: usize| quintic(i as f64 * ds);
    // The zero-moment point is off the centre of mass by its acceleration times z_c / g.
    let com = (0..=INSTANTS).map(|i| blend::com_W(&task.keyframes, u(i)));
    let com: Vec<_> = com.collect();
    let heights = task.closed.iter().map(|c| c.X_WC.translation.vector.z);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    for w in com.windows(3) {
        let acceleration = (w[2] - 2.0 * w[1] + w[0]).xy().norm() / (ds * ds);
        let height = (w[1].z - lowest).max(0.0);
        let least = acceleration * height / (GRAVITY_M_S2 * ZMP_EXCURSION_M);
        time = time.max(least.sqrt());
    }
    let mut before = task.keyframes[0].q.clone();
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

/// Where a trajectory is fastest.
#[derive(Default)]
pub(crate) struct Fastest {
    /// Part of what is allowed: of the joints' speeds, or of the distance that a body moves.
    pub over: f64,
    joint: usize,
    /// Number of the second of the samples.
    sample: usize,
}

/// Part of the clearance that a body may move between two samples, so that it is clear between them
/// too.
const STEP_PART: f64 = 0.6;

/// Where the trajectory is fastest relative to what is allowed.
pub(crate) fn fastest(context: &MotionContext, trajectory: &SampledTrajectory) -> Fastest {
    let config = context.config;
    let step_m = STEP_PART * context.posture.clearance_m;
    let mut fastest = Fastest::default();
    let places = trajectory.places_W.windows(2);
    let pairs = trajectory.samples.windows(2).zip(places);
    for (sample, (pair, places)) in (1..).zip(pairs) {
        let mut keep = |over: f64, joint: usize| {
            if over > fastest.over {
                (fastest.over, fastest.joint, fastest.sample) = (over, joint, sample);
            }
        };
        let steps = pair[0].q[BASE..].iter().zip(&pair[1].q[BASE..]);
        for (joint, ((a, b), body)) in steps.zip(context.robot.joint_bodies()).enumerate() {
            let allowed = config.dt_s * body.velocity * config.joint_speed_use;
            keep((b - a).abs() / allowed, joint);
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

/// How much longer a trajectory has to take for its vertical acceleration to be allowed; 1 where it is.
///
/// In T times the time an acceleration is its T²th part. The postures that a path is made of are at rest;
/// what lies between them may rise and fall more than they do.
pub(crate) fn slower_for_lift(config: &Config, trajectory: &SampledTrajectory) -> f64 {
    let heights = trajectory.samples.iter().map(|sample| sample.com_W.z);
    let ahead = (LIFT_S / config.dt_s).ceil().max(1.0) as usize;
    let between = heights.clone().skip(ahead);
    let bends = heights.clone().zip(between).zip(heights.skip(2 * ahead));
    let bends = bends.map(|((a, b), c)| (c - 2.0 * b + a).abs());
    let most = bends.fold(0.0, f64::max);
    let most_m_s2 = most / (ahead as f64 * config.dt_s).powi(2);
    (most_m_s2 / LIFT_MAX_M_S2).sqrt().max(1.0)
}

/// A trajectory that is still too fast when its time was stretched: the postures that close the
/// contacts jump from one side of something to the other.
pub(crate) fn discontinuity(
    context: &MotionContext,
    task: &Task,
    trajectory: &SampledTrajectory,
    fastest: &Fastest,
) -> Failure {
    let [before, after] =
        [fastest.sample - 1, fastest.sample].map(|k| trajectory.samples[k].q[BASE + fastest.joint]);
    let joint = context.robot.joint_bodies()[fastest.joint].joint.clone();
    let s = fastest.sample as f64 / (trajectory.samples.len() - 1) as f64;
    let jump = (after - before).abs();
    context.failure(task, Reason::Discontinuity { joint }, jump, quintic(s))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::sampling::Instance;

    /// A trajectory of which only the heights matter.
    fn trajectory(heights: impl Iterator<Item = f64>) -> SampledTrajectory {
        let sample = |z| Instance {
            q: Vec::new(),
            com_W: Vector3::new(0.0, 0.0, z),
            forces_W: Vec::new(),
        };
        SampledTrajectory {
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
            let rise = |i: usize| 2.0 * LIFT_MAX_M_S2 * time(i).powi(2) + noise(i);
            let slower = slower_for_lift(&config, &trajectory((0..=end).map(rise)));
            assert!((slower - 2.0).abs() < 0.05, "{slower}");
            let even = |i: usize| 0.5 * time(i) + noise(i);
            let even = trajectory((0..=end).map(even));
            assert_eq!(slower_for_lift(&config, &even), 1.0);
        }
        let too_short_to_rise = trajectory([0.0, 1.0].into_iter());
        assert_eq!(slower_for_lift(&config, &too_short_to_rise), 1.0);
    }
}
