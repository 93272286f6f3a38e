//! Whether a reference is executed: the robot starts at its first configuration and follows it to the end.
use robot_model::Robot;

use crate::Error;
use crate::clock::Clock;
use crate::config::Config;
use crate::control::{Control, servo};
use crate::monitor::Monitor;
use crate::outcome::Executed;
use crate::perturbation::Perturbation;
use crate::physics::Physics;
use crate::plant::Plant;
use crate::reference::{Reference, ReferenceContact, ReferenceState};
use crate::run::Run;
use crate::schedule::closures;
use crate::verdict::{CONTACT_DELAY_S, cause, contact_n, judge};
use crate::world::WorldBody;

/// Time held at the end of the motion, s.
const REST_S: f64 = 1.0;
/// Deviation of the centre of mass from which on the robot is taken to fall, m.
const FALL_M: f64 = 0.25;

/// One row of a run's trace.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceRow {
    /// Time, s.
    pub t_s: f64,
    /// Configuration [p_WB, quat_xyzw, joints…], m and rad.
    pub q: Vec<f64>,
    /// Normal force of each patch, N.
    pub normal_n: Vec<f64>,
    /// Deviation of the centre of mass from its reference, m.
    pub com_error_m: f64,
    /// Angle of the base to its reference, rad.
    pub tilt_rad: f64,
    /// Largest part of a torque limit that is used.
    pub torque_use: f64,
}

/// Sees every control step of a run, for traces and pictures.
pub trait Observer {
    /// The state after a step.
    fn see(&mut self, plant: &mut Plant, row: &TraceRow) -> Result<(), Error>;
}

/// An observer that keeps nothing.
pub struct Unobserved;

impl Observer for Unobserved {
    fn see(&mut self, _: &mut Plant, _: &TraceRow) -> Result<(), Error> {
        Ok(())
    }
}

/// Executes a reference.
///
/// The controller knows the planned robot; the simulated robot and world, and what it is told of them, differ
/// by the perturbation.
///
/// # Errors
/// As [`Plant::new`] and [`WholeBodyController::new`]; a program of the controller that has no
/// solution.
pub fn execute(
    robot: &Robot,
    world: &[WorldBody],
    reference: &impl Reference,
    config: &Config,
    perturbation: &Perturbation,
    observer: &mut impl Observer,
) -> Result<Executed, Error> {
    let physics = Physics::from(config);
    let kind = config.controller;
    let world = perturbation.applied(world);
    let plant = Plant::new(robot, &world, &physics, servo(kind), &perturbation.scales())?;

    let mut wanted = ReferenceState::at_rest(robot.neutral());
    reference.at(0.0, &mut wanted);
    let touches_n = contact_n(robot);
    let closed = closures(reference, &wanted, touches_n);
    let monitor = Monitor::new(robot, &world, closed, CONTACT_DELAY_S, touches_n);
    let mut run = Run::new(robot, plant, monitor, &wanted);
    let mut control = Control::new(robot, &physics, kind, &wanted, perturbation.sensing)?;
    let duration_s = reference.duration_s() + REST_S;
    let period_s = control.period as f64 * physics.dt_s;
    let mut clock = Clock::new();
    let mut fell_s = None;

    for step in 0_usize.. {
        let t_s = step as f64 * physics.dt_s;
        if step.is_multiple_of(control.period) {
            if clock.t_s >= duration_s {
                break;
            }
            reference.at(clock.t_s, &mut wanted);
            clock.slow(&mut wanted);
            control.command(&mut run, &wanted)?;
            clock.pass(period_s, &control.capture(&wanted));
        }
        run.plant.push(&perturbation.force_W(t_s));
        let stable = run.step(clock.t_s, &wanted);
        control.feel(&run, &wanted);
        let monitor = &run.monitor;
        if !stable || monitor.com_error_m.is_nan() || monitor.com_error_m > FALL_M {
            fell_s = Some(t_s);
            break;
        }
        if step.is_multiple_of(control.period) {
            let row = trace_row(robot, &run, t_s);
            observer.see(&mut run.plant, &row)?;
        }
    }
    let pushed = !perturbation.pushes.is_empty();
    let criteria = judge(robot, &run.monitor, pushed, fell_s, physics.dt_s);
    Ok(Executed {
        pass: criteria.iter().all(|c| c.pass),
        stands: fell_s.is_none() && stands(&wanted, &run.monitor, touches_n),
        cause: cause(&criteria, fell_s),
        criteria,
        fell_s,
        perturbation: perturbation.clone(),
        simulated_s: fell_s.unwrap_or(clock.t_s + clock.waited_s),
        waited_s: clock.waited_s,
    })
}

/// Whether every contact that is to bear does, from this force on.
fn stands(wanted: &ReferenceState, monitor: &Monitor, touches_n: f64) -> bool {
    let borne = |c: &ReferenceContact| monitor.normal_n[c.patch] >= touches_n;
    let mut loaded = wanted.contacts.iter().filter(|c| c.normal_n() >= touches_n);
    loaded.all(borne)
}

fn trace_row(robot: &Robot, run: &Run, t_s: f64) -> TraceRow {
    let used = run.plant.torques().iter().zip(robot.joint_bodies());
    let used = used.map(|(torque, body)| torque.abs() / body.effort);
    TraceRow {
        t_s,
        q: run.state.to_q(),
        normal_n: run.monitor.normal_n.clone(),
        com_error_m: run.monitor.com_error_m,
        tilt_rad: run.monitor.tilt_rad,
        torque_use: used.fold(0.0, f64::max),
    }
}
