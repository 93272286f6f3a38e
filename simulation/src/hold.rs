//! Whether a stance holds: the robot is put there and held by what executes motions.

use nalgebra::Vector3;
use robot_model::{GRAVITY_M_S2, Robot};

use crate::Error;
use crate::config::Config;
use crate::control::{Control, servo};
use crate::criteria::{Criterion, Unit};
use crate::monitor::Monitor;
use crate::outcome::Held;
use crate::physics::{Physics, Scales};
use crate::plant::Plant;
use crate::reference::ReferenceState;
use crate::run::Run;
use crate::schedule::Closure;
use crate::verdict::{COM_ERROR_FINAL_MAX_M, PENETRATION_MAX_M, TILT_MAX_RAD, contact_n};
use crate::world::WorldBody;

/// Time given to settle on the world as it is before anything is measured, s.
const SETTLE_S: f64 = 0.5;
/// Duration of a push, s.
const PUSH_S: f64 = 0.2;
/// Largest drift of the centre of mass, m: all in all, in the last second, and where the robot is
/// pushed.
const COM_DRIFT_MAX_M: f64 = 0.003;
const COM_DRIFT_LAST_MAX_M: f64 = 0.001;
const COM_DRIFT_PUSHED_MAX_M: f64 = 0.005;
/// Largest slip of a contact, m.
const SLIP_MAX_M: f64 = 0.002;
/// Largest tilt of the base after settling, rad.
const HELD_TILT_MAX_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Largest norm of the joint velocities at the end, rad/s.
const JOINT_SPEED_MAX_RAD_S: f64 = 0.02;
/// Largest relative difference of the mean vertical force from the weight.
const WEIGHT_ERROR_MAX: f64 = 0.01;
/// Largest use of the torque limits.
const TORQUE_USE_MAX: f64 = 0.8;

/// Holds a stance, pushed by `push_W` (in W, N) where there is one.
///
/// What settling, drift, tilt and speed at the end may be is asked of the plain run; a pushed one
/// has to come back from where it was pushed to.
///
/// # Errors
/// As [`Plant::new`] and [`WholeBodyController::torques`](crate::whole_body::WholeBodyController::torques).
pub fn hold(
    robot: &Robot,
    world: &[WorldBody],
    wanted: &ReferenceState,
    config: &Config,
    push_W: Option<Vector3<f64>>,
) -> Result<Held, Error> {
    let physics = Physics::from(config);
    let kind = config.controller;
    let plant = Plant::new(robot, world, &physics, servo(kind), &Scales::default())?;
    let touches_n = contact_n(robot);
    let closed = wanted.contacts.iter().map(|contact| Closure {
        loaded_from_s: (contact.normal_n() > touches_n).then_some(0.0),
        ..Closure::new(contact, 0.0)
    });
    let monitor = Monitor::new(robot, world, closed.collect(), 0.0, touches_n);
    let mut run = Run::new(robot, plant, monitor, wanted);
    // What bears nothing is held where it is, and has nothing to search for.
    let mut bearing = wanted.clone();
    bearing.contacts.retain(|c| c.normal_n() > touches_n);
    let mut control = Control::new(robot, &physics, kind, &bearing, None)?;
    let mut next = |run: &mut Run, step: usize| -> Result<bool, Error> {
        if step.is_multiple_of(control.period) {
            control.command(run, &bearing)?;
        }
        let stable = run.step(step as f64 * physics.dt_s, wanted);
        control.feel(run, &bearing);
        Ok(stable)
    };

    // Settle on the world as it is.
    let steps = |duration_s: f64| (duration_s / physics.dt_s).round() as usize;
    let settling = steps(SETTLE_S);
    let mut stable = true;
    for step in 0..settling {
        stable = stable && next(&mut run, step)?;
    }
    let mut drift = Drift {
        settled_com_m: run.monitor.com_error_m,
        settled_tilt_rad: run.monitor.tilt_rad,
        pushed: push_W.is_some(),
        ..Drift::default()
    };
    run.monitor.forget();
    let home = run.state.clone();
    let com_home = run.monitor.com_W;

    // Hold, pushed at first where so wished.
    let mut com_before_last = com_home;
    let last_from = config.hold_s - 1.0;
    for step in 0..steps(config.hold_s) {
        let since = step as f64 * physics.dt_s;
        let pushing = push_W.filter(|_| since < PUSH_S);
        run.plant.push(&pushing.unwrap_or_else(Vector3::zeros));
        stable = stable && next(&mut run, settling + step)?;
        if !stable {
            break;
        }
        let com = run.monitor.com_W;
        drift.all = drift.all.max((com - com_home).norm());
        let tilt = run.state.R_WB.angle_to(&home.R_WB);
        drift.tilt = drift.tilt.max(tilt);
        if since < last_from {
            com_before_last = com;
        } else {
            drift.last = drift.last.max((com - com_before_last).norm());
        }
    }
    drift.speed = Monitor::joint_speed(&run.v);
    Ok(judge(robot, wanted, &run.monitor, &drift))
}

/// How the robot moved while it was held.
#[derive(Default)]
struct Drift {
    all: f64,
    last: f64,
    tilt: f64,
    speed: f64,
    settled_com_m: f64,
    settled_tilt_rad: f64,
    pushed: bool,
}

fn judge(robot: &Robot, wanted: &ReferenceState, monitor: &Monitor, drift: &Drift) -> Held {
    let peaks = &monitor.peaks;
    let name = |patch: usize| robot.patches[patch].name.clone();
    let steps = peaks.steps.max(1) as f64;
    let weight = robot.mass_kg * GRAVITY_M_S2;
    let pairs = monitor.pairs();
    let forces = pairs.map(|(closure, seen)| (name(closure.patch), seen.force_sum_n / steps));
    let normal_n: Vec<(String, f64)> = forces.collect();
    let bearing = wanted.contacts.iter().zip(&normal_n);
    let touches_n = contact_n(robot);
    let bearing = bearing.filter(|(contact, _)| contact.normal_n() > touches_n);
    let least = bearing.min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let bound_drift = if drift.pushed {
        COM_DRIFT_PUSHED_MAX_M
    } else {
        COM_DRIFT_MAX_M
    };
    let mm = Unit::Millimetre;
    let plain = Unit::Plain("");
    let mut criteria = vec![
        Criterion::at_most("com drift", drift.all, bound_drift, mm),
        monitor.slip(SLIP_MAX_M, |closure| name(closure.patch)),
        peaks
            .torque_use
            .at_most("torque use", TORQUE_USE_MAX, plain),
        peaks
            .penetration_m
            .at_most("penetration", PENETRATION_MAX_M, mm),
        monitor.none_unplanned(),
    ];
    if let Some((_, (patch, force))) = least {
        let newton = Unit::Plain("N");
        let borne = Criterion::at_least("least contact force", *force, touches_n, newton);
        criteria.push(borne.on(Some(patch.clone())));
    }
    if !drift.pushed {
        let error = (peaks.vertical_sum_n / steps / weight - 1.0).abs();
        let (settled_m, settled_rad) = (drift.settled_com_m, drift.settled_tilt_rad);
        let (speed, rate) = (drift.speed, Unit::Plain("rad/s"));
        let at_most = Criterion::at_most;
        criteria.extend([
            at_most(
                "com drift, last second",
                drift.last,
                COM_DRIFT_LAST_MAX_M,
                mm,
            ),
            at_most("tilt", drift.tilt, HELD_TILT_MAX_RAD, Unit::Degree),
            at_most("joint speed at the end", speed, JOINT_SPEED_MAX_RAD_S, rate),
            at_most("weight error", error, WEIGHT_ERROR_MAX, plain),
            at_most("com shift, settling", settled_m, COM_ERROR_FINAL_MAX_M, mm),
            at_most("tilt, settling", settled_rad, TILT_MAX_RAD, Unit::Degree),
        ]);
    }
    Held {
        pass: criteria.iter().all(|c| c.pass),
        criteria,
        settled_com_mm: drift.settled_com_m * 1e3,
        settled_tilt_deg: drift.settled_tilt_rad.to_degrees(),
        normal_n,
    }
}
