//! Whether a course is executed: the robot starts where it starts and follows it to the end.
#![allow(non_snake_case)]

use nalgebra::{DVector, Vector3};
use robot_model::{Configuration, Robot};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::config::{Config, Controller, Servo};
use crate::course::{Course, Wanted, WantedContact};
use crate::criteria::{Criterion, Unit};
use crate::footing::Footing;
use crate::monitor::{Monitor, Peak, Seen};
use crate::perturbation::Perturbation;
use crate::plant::{Plant, Touch};
use crate::schedule::closures;
use crate::whole_body::WholeBodyController;
use crate::world::WorldBody;

/// How a course was executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Executed {
    /// Every criterion.
    pub criteria: Vec<Criterion>,
    /// Whether all hold.
    pub pass: bool,
    /// Whether it stands at the end: it did not fall, and its last contacts bear it.
    pub stands: bool,
    /// When the robot fell, s.
    pub fell_s: Option<f64>,
    /// The first thing that went wrong, in words.
    pub cause: Option<String>,
    /// What was disturbed.
    pub perturbation: Perturbation,
    /// Simulated time, s.
    pub simulated_s: f64,
}

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

/// Executes a course.
///
/// The controller knows the planned robot and measures state and touch exactly; the simulated
/// robot and world differ from the planned ones by the perturbation.
///
/// # Errors
/// As [`Plant::new`] and [`WholeBodyController::new`]; a program of the controller that has no
/// solution.
pub fn execute(
    robot: &Robot,
    world: &[WorldBody],
    course: &impl Course,
    config: &Config,
    perturbation: &Perturbation,
    observer: &mut impl Observer,
) -> Result<Executed, Error> {
    let bounds = &config.execution;
    let physics = &config.physics;
    let servo = match config.controller {
        Controller::Servo => config.servo.clone(),
        Controller::WholeBody => Servo {
            kp: config.whole_body.joint_kp,
            kv: config.whole_body.joint_kv,
        },
    };
    let world = perturbation.applied(world);
    let mut plant = Plant::new(robot, &world, physics, &servo, &perturbation.scales())?;
    let mut controller = WholeBodyController::new(robot, &config.whole_body, physics)?;
    let mut footing = Footing::new(robot);

    let mut wanted = Wanted::at_rest(robot.neutral());
    course.at(0.0, &mut wanted);
    plant.reset(&wanted.configuration);
    let closed = closures(course, &wanted, bounds.contact_n);
    let mut monitor = Monitor::new(
        robot,
        &world,
        closed,
        bounds.contact_delay_s,
        bounds.contact_n,
    );
    let mut touching = Touching::new(robot, &wanted, config.whole_body.touch_n);
    let mut state = wanted.configuration.clone();
    let mut v = DVector::zeros(robot.nv());
    let mut torques = vec![0.0; robot.nj()];
    let (mut joints, mut rates) = (torques.clone(), torques.clone());
    let mut touches: Vec<Touch> = Vec::new();
    let period = ((config.whole_body.period_s / physics.dt_s).round() as usize).max(1);
    let duration_s = course.duration_s() + bounds.rest_s;
    let steps = (duration_s / physics.dt_s).round() as usize;
    let mut fell_s = None;

    for step in 0..steps {
        let t_s = step as f64 * physics.dt_s;
        if step % period == 0 {
            course.at(t_s, &mut wanted);
            let (found, followed) = match config.controller {
                Controller::WholeBody => {
                    let dt_s = period as f64 * physics.dt_s;
                    let followed = footing.followed(&state, &wanted, touching.now(), dt_s);
                    let found = controller.torques(&state, &v, &followed, touching.now())?;
                    (found, followed)
                }
                Controller::Servo => {
                    let (q, v) = (&wanted.configuration, &wanted.v);
                    let found = controller.torques(q, v, &wanted, touching.all())?;
                    (found, wanted.clone())
                }
            };
            torques.copy_from_slice(found);
            joints.copy_from_slice(followed.configuration.joints.as_slice());
            rates.copy_from_slice(&followed.v.as_slice()[6..]);
            if config.controller == Controller::WholeBody {
                // A limb that searches for its place beyond the reference is not held back.
                let searching = |c: &&WantedContact| touching.searches(c.patch);
                for contact in wanted.contacts.iter().filter(searching) {
                    let body = robot.patches[contact.patch].body;
                    for j in (0..joints.len()).filter(|j| robot.supports(j + 1, body)) {
                        (joints[j], rates[j]) = (state.joints[j], v[6 + j]);
                    }
                }
            }
            plant.command(&joints, &rates, &torques);
        }
        plant.push(&perturbation.force_W(t_s));
        let stable = plant.step();
        plant.state(&mut state, &mut v);
        plant.touches(&mut touches);
        monitor.see(&Seen {
            t_s,
            configuration: &state,
            wanted: &wanted,
            touches: &touches,
            torques: plant.torques(),
        });
        let lands = monitor.nears_landing(&wanted);
        touching.update(&monitor.normal_n, &wanted, lands, physics.dt_s);
        if !stable || monitor.com_error_m.is_nan() || monitor.com_error_m > bounds.fall_m {
            fell_s = Some(t_s);
            break;
        }
        if step % period == 0 {
            let row = trace_row(robot, &state, &monitor, plant.torques(), t_s);
            observer.see(&mut plant, &row)?;
        }
    }
    let simulated_s = fell_s.unwrap_or(duration_s);
    let criteria = judge(robot, config, &monitor, fell_s, simulated_s);
    Ok(Executed {
        pass: criteria.iter().all(|c| c.pass),
        stands: fell_s.is_none() && stands(&wanted, &monitor, bounds.contact_n),
        cause: cause(&criteria, fell_s),
        criteria,
        fell_s,
        perturbation: perturbation.clone(),
        simulated_s,
    })
}

/// Whether every contact that is to bear does.
fn stands(wanted: &Wanted, monitor: &Monitor, contact_n: f64) -> bool {
    let borne = |c: &WantedContact| monitor.normal_n[c.patch] >= contact_n;
    let mut loaded = wanted.contacts.iter().filter(|c| c.normal_n() >= contact_n);
    loaded.all(borne)
}

/// Which patches touch, as force sensors tell, with some patience against chatter.
struct Touching {
    now: Vec<bool>,
    all: Vec<bool>,
    unloaded_s: Vec<f64>,
    /// Which patches in the air have left what they stood on.
    left: Vec<bool>,
    /// For how long each patch should have touched and has not, s.
    missing_s: Vec<f64>,
    touch_n: f64,
}

/// A contact that bears nothing for this long is lost, s.
const LOST_AFTER_S: f64 = 0.05;
/// A patch that should touch for this long and does not is to search for its surface, s.
const MISSING_AFTER_S: f64 = 0.1;

impl Touching {
    fn new(robot: &Robot, start: &Wanted, touch_n: f64) -> Self {
        let mut now = vec![false; robot.patches.len()];
        for contact in &start.contacts {
            now[contact.patch] = true;
        }
        Self {
            all: vec![true; now.len()],
            unloaded_s: vec![0.0; now.len()],
            left: vec![false; now.len()],
            missing_s: vec![0.0; now.len()],
            now,
            touch_n,
        }
    }

    fn now(&self) -> &[bool] {
        &self.now
    }

    fn all(&self) -> &[bool] {
        &self.all
    }

    /// Whether a patch is not where its surface was planned to be.
    fn searches(&self, patch: usize) -> bool {
        self.missing_s[patch] > MISSING_AFTER_S
    }

    /// `lands` says whether the patch in the air would land early if it touched now.
    fn update(&mut self, normal_n: &[f64], wanted: &Wanted, lands: bool, dt_s: f64) {
        for (patch, &force) in normal_n.iter().enumerate() {
            let planned = wanted.contacts.iter().any(|c| c.patch == patch);
            self.unloaded_s[patch] = if force > 0.0 {
                0.0
            } else {
                self.unloaded_s[patch] + dt_s
            };
            let lost = self.unloaded_s[patch] > LOST_AFTER_S;
            self.left[patch] = !planned && (self.left[patch] || lost);
            // Once down, it stays down.
            let swings = self.left[patch] && wanted.swing == Some(patch);
            let early = swings && (lands || self.now[patch]);
            if lost || !(planned || early) {
                self.now[patch] = false;
            } else if force >= self.touch_n {
                self.now[patch] = true;
            }
            self.missing_s[patch] = if planned && !self.now[patch] {
                self.missing_s[patch] + dt_s
            } else {
                0.0
            };
        }
    }
}

fn trace_row(
    robot: &Robot,
    state: &Configuration,
    monitor: &Monitor,
    torques: &[f64],
    t_s: f64,
) -> TraceRow {
    let torque_use = torques
        .iter()
        .zip(robot.joint_bodies())
        .map(|(torque, body)| torque.abs() / body.effort)
        .fold(0.0, f64::max);
    TraceRow {
        t_s,
        q: state.to_q(),
        normal_n: monitor.normal_n.clone(),
        com_error_m: monitor.com_error_m,
        tilt_rad: monitor.tilt_rad,
        torque_use,
    }
}

fn judge(
    robot: &Robot,
    config: &Config,
    monitor: &Monitor,
    fell_s: Option<f64>,
    simulated_s: f64,
) -> Vec<Criterion> {
    let bounds = &config.execution;
    let peaks = &monitor.peaks;
    let mm = Unit::Millimetre;
    let plain = Unit::Plain("");
    let most = |name: &str, peak: &Peak, bound: f64, unit: Unit| {
        Criterion::at_most(name, peak.value, bound, unit).on(peak.detail.clone())
    };
    let at = |patch: usize, t_s: f64| format!("{} of {t_s:.2} s", robot.patches[patch].name);
    let pairs = || monitor.closures().iter().zip(&monitor.tracks);
    let slip = pairs().max_by(|a, b| a.1.slip_m.total_cmp(&b.1.slip_m));
    let delay = pairs()
        .filter_map(|(closure, track)| {
            let due_s = closure.loaded_from_s.filter(|due| *due < simulated_s)?;
            let loaded_s = track.loaded_s.unwrap_or(closure.end_s.min(simulated_s));
            Some((
                (loaded_s - due_s).max(0.0),
                at(closure.patch, closure.start_s),
            ))
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let fallen = f64::from(u8::from(fell_s.is_some()));
    vec![
        Criterion::at_most("falls", fallen, 0.0, plain).on(fell_s.map(|t| format!("at {t:.2} s"))),
        most("com error", &peaks.com_error_m, bounds.com_error_m, mm),
        Criterion::at_most(
            "com error at the end",
            monitor.com_error_m,
            bounds.com_error_final_m,
            mm,
        ),
        Criterion::at_most("slip", slip.map_or(0.0, |s| s.1.slip_m), bounds.slip_m, mm)
            .on(slip.map(|s| at(s.0.patch, s.0.start_s))),
        most("tilt", &peaks.tilt_rad, bounds.tilt_rad, Unit::Degree),
        most(
            "swing error",
            &peaks.swing_error_m,
            bounds.swing_error_m,
            mm,
        ),
        most("torque use", &peaks.torque_use, bounds.torque_use, plain),
        most(
            "penetration",
            &peaks.penetration_m,
            bounds.penetration_m,
            mm,
        ),
        Criterion::at_most(
            "unplanned contacts",
            monitor.unplanned.len() as f64,
            0.0,
            plain,
        )
        .on(monitor.unplanned_words()),
        Criterion::at_most(
            "contact delay",
            delay.as_ref().map_or(0.0, |d| d.0),
            bounds.contact_delay_s,
            Unit::Plain("s"),
        )
        .on(delay.map(|d| d.1)),
    ]
}

/// What to say of a run that failed: a fall says less than what led to it.
fn cause(criteria: &[Criterion], fell_s: Option<f64>) -> Option<String> {
    let failed: Vec<&Criterion> = criteria.iter().filter(|c| !c.pass).collect();
    let first = failed
        .iter()
        .find(|c| c.name == "unplanned contacts")
        .or_else(|| failed.first())?;
    let place = first.detail.clone().unwrap_or_default();
    Some(match fell_s {
        Some(t) if first.name != "falls" => format!("fell at {t:.2} s; {}: {place}", first.name),
        Some(t) => format!("fell at {t:.2} s"),
        None => format!("{}: {:.3} {} {place}", first.name, first.value, first.unit),
    })
}

/// The normal of the first contact that uses each body of the world; `None` for bodies that
/// nothing touches and for those that carry the robot at the start.
///
/// A contact uses the body of which the surface is nearest to its place.
pub fn touched_normals_W(
    robot: &Robot,
    world: &[WorldBody],
    course: &impl Course,
) -> Vec<Option<Vector3<f64>>> {
    let mut wanted = Wanted::at_rest(robot.neutral());
    let mut normals = vec![None; world.len()];
    let mut fixed = vec![false; world.len()];
    let steps = (course.duration_s() / 0.05).ceil() as usize;
    for step in 0..=steps {
        course.at(step as f64 * 0.05, &mut wanted);
        for contact in &wanted.contacts {
            let patch = &robot.patches[contact.patch];
            let normal_W = contact.X_WC.rotation * Vector3::z();
            let p_W =
                contact.X_WC.translation.vector - normal_W * patch.point_radius_m().unwrap_or(0.0);
            let nearest = world
                .iter()
                .enumerate()
                .map(|(k, body)| (k, body.face_distance_m(&p_W, &normal_W)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((k, _)) = nearest {
                fixed[k] |= step == 0;
                normals[k].get_or_insert(normal_W);
            }
        }
    }
    normals
        .into_iter()
        .zip(fixed)
        .map(|(normal, fixed)| normal.filter(|_| !fixed))
        .collect()
}
