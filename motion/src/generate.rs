//! The motion of one phase: ways that are free for the swept link, the body on them, waypoints
//! where it cannot follow.

#![allow(non_snake_case)]

use posture::{Contact, Outcome, Place, Problem};

use crate::Error;
use crate::airborne::Airborne;
use crate::failure::{Failure, Reason};
use crate::problem::{Key, Setting, Task};
use crate::route::Router;
use crate::sweep::{self, Hit};
use crate::track::{self, Track};
use crate::way::{self, Way};

/// Waypoints nearer to another key than this would be passed at a jerk, part of the way.
const APART_MIN: f64 = 0.12;

/// Ways on which there is no posture just after leaving or just before landing, after which others
/// are not tried: that part all ways have in common.
const STUCK_MAX: usize = 2;
/// That part of a way.
const STRAIGHT: f64 = 0.15;

/// What samples may be faster by than they should be, and by how much at most where more time makes
/// them no slower.
const SPEED_TOLERANCE: f64 = 0.1;
const SPEED_TOLERANCE_MAX: f64 = 0.5;
/// More time makes a motion slower than this part of its speed.
const SLOWER: f64 = 0.8;

/// The samples of a task, or the worst violation on the best way.
///
/// # Errors
/// [`Error::Posture`] where a waypoint cannot be posed.
pub(crate) fn solve(setting: &Setting, task: &Task) -> Result<Result<Track, Failure>, Error> {
    let Some(swing) = &task.swing else {
        return follow(setting, task, None);
    };
    if swing.lands.is_none() {
        return follow(setting, task, Some(&Way::straight(swing)));
    }
    let mut nearest: Option<Failure> = None;
    let (mut tried, mut stuck) = (0, 0);
    for shape in way::shapes(setting.config) {
        if tried == setting.config.ways_max || stuck == STUCK_MAX {
            break;
        }
        let way = Way::new(setting.environment, setting.config, swing, shape);
        if let Some((hit, short, at)) = sweep::shortfall(setting, task, &way) {
            let link = setting.robot.patches[swing.patch].link.clone();
            let reason = match hit {
                Hit::Environment(obstacle) => Reason::Clearance {
                    link,
                    body: setting.environment.body_names[obstacle].clone(),
                },
                Hit::Robot(other) => Reason::SelfClearance { link, other },
            };
            let failure = setting.failure(task, reason, short, at);
            keep_least(&mut nearest, failure);
            continue;
        }
        tried += 1;
        match follow(setting, task, Some(&way))? {
            Ok(track) => return Ok(Ok(track)),
            Err(failure) => {
                tracing::debug!("{shape:?}: {}", failure.describe());
                let closure = matches!(failure.reason, Reason::Closure { .. });
                stuck +=
                    usize::from(closure && (failure.at < STRAIGHT || failure.at > 1.0 - STRAIGHT));
                keep_least(&mut nearest, failure);
            }
        }
    }
    let none = setting.failure(task, Reason::Equilibrium, 0.0, 0.0);
    Ok(Err(nearest.unwrap_or(none)))
}

fn keep_least(nearest: &mut Option<Failure>, failure: Failure) {
    if nearest
        .as_ref()
        .is_none_or(|n| failure.severity() < n.severity())
    {
        *nearest = Some(failure);
    }
}

/// The body on one way.
fn follow(
    setting: &Setting,
    task: &Task,
    way: Option<&Way>,
) -> Result<Result<Track, Failure>, Error> {
    let mut task = task.clone();
    let mut evades = false;
    let mut waypoints = 0;
    loop {
        let failure = match attempt(setting, &task, way, evades) {
            Ok(track) => return Ok(Ok(track)),
            Err(failure) => failure,
        };
        // The body first moves out of the way of what it would touch.
        let touches = matches!(
            failure.reason,
            Reason::Clearance { .. } | Reason::SelfClearance { .. }
        );
        if touches && !evades {
            evades = true;
            continue;
        }
        // Then the posture generator is asked for a posture on the way.
        if waypoints == setting.config.waypoints_max {
            return Ok(Err(failure));
        }
        waypoints += 1;
        match waypoint(setting, &task, way, failure.at)? {
            Some(key) => {
                let at = task.keys.partition_point(|k| k.u < key.u);
                task.keys.insert(at, key);
            }
            None => return Ok(Err(failure)),
        }
    }
}

fn attempt(
    setting: &Setting,
    task: &Task,
    way: Option<&Way>,
    evades: bool,
) -> Result<Track, Failure> {
    let router = Router {
        setting,
        task,
        way,
        evades,
    };
    let mut route = router.solve()?;
    let mut steps = track::steps(setting, task, way, &mut route);
    // The samples close their contacts once more and may be faster than what the time was set by.
    let mut before = f64::INFINITY;
    let track = loop {
        let track = track::sample(setting, task, way, &mut route, steps)?;
        let fastest = track::fastest(setting, &track);
        let over = fastest.over;
        // In more time a motion is slower by as much; a leap is as far as before.
        let leaps = over > SLOWER * before;
        if over <= 1.0 + SPEED_TOLERANCE || (leaps && over <= 1.0 + SPEED_TOLERANCE_MAX) {
            break track;
        }
        if leaps {
            return Err(track::leap(setting, task, &track, &fastest));
        }
        before = over;
        steps = (steps as f64 * over).ceil() as usize;
    };
    let slower = track::slower_for_lift(setting.config, &track);
    if slower <= 1.0 {
        return Ok(track);
    }
    let steps = (steps as f64 * slower).ceil() as usize;
    track::sample(setting, task, way, &mut route, steps)
}

/// A posture on the closed contacts with the patch in the air where it is at `u`.
fn waypoint(
    setting: &Setting,
    task: &Task,
    way: Option<&Way>,
    u: f64,
) -> Result<Option<Key>, Error> {
    let (low, high) = (APART_MIN, 1.0 - APART_MIN);
    let u = u.clamp(low, high);
    if task.keys.iter().any(|k| (k.u - u).abs() < 0.9 * APART_MIN) {
        return Ok(None);
    }
    let robot = setting.robot;
    let mut contacts: Vec<Contact> = task
        .closed
        .iter()
        .map(|closed| Contact {
            patch: closed.patch,
            place: Place::Fixed {
                X_WC: closed.X_WC,
                yaw_free: false,
                surface: Some(closed.surface),
            },
            loaded: true,
            friction: robot.patches[closed.patch].friction,
        })
        .collect();
    if let (Some(swing), Some(way)) = (&task.swing, way) {
        let pose = way.pose(u);
        contacts.push(Contact {
            patch: swing.patch,
            place: Place::Fixed {
                X_WC: pose,
                yaw_free: false,
                surface: Airborne::new(setting, swing, &pose).surface(setting),
            },
            loaded: false,
            friction: robot.patches[swing.patch].friction,
        });
    }
    let mut reference = task.keys[0].q.clone();
    crate::blend::Blend::new(&task.keys).configuration(u, &mut reference);
    let problem = Problem {
        robot,
        environment: setting.environment,
        contacts,
        base_goal: None,
        reference: &reference,
        guess: &reference,
    };
    let outcome = posture::solve(&problem, setting.posture)?;
    if let Some(violation) = outcome.violation() {
        tracing::debug!("no waypoint at {u:.2}: {}", violation.describe(&problem));
    }
    let Outcome::Feasible(posture) = outcome else {
        return Ok(None);
    };
    let forces_W = posture.contacts[..task.closed.len()]
        .iter()
        .map(|contact| contact.forces_W.clone())
        .collect();
    Ok(Some(Key {
        u,
        q: posture.q,
        com_W: posture.com_W,
        forces_W,
    }))
}
