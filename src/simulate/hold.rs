//! Every stance of a plan, held.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use plan::Plan;
use rayon::prelude::*;
use robot_model::Robot;
use simulation::hold::hold;
use simulation::outcome::Held;
use simulation::world::WorldBody;

use super::report::HeldStance;
use super::stance;

/// How often each stance is held.
pub const HOLDS: usize = 5;

/// Holds every stance, plain and pushed; `done` is called after each of the [`HOLDS`].
///
/// # Errors
/// A stance that does not fit the robot, a robot that cannot be simulated; that `cancel` was raised.
pub fn hold_all(
    plan: &Plan,
    robot: &Robot,
    world: &[WorldBody],
    config: &simulation::Config,
    cancel: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<HeldStance>> {
    let (none, x, y) = (Vector3::zeros(), Vector3::x(), Vector3::y());
    let pushes = [none, x, -x, y, -y].map(|along| along * config.hold_push_n);
    let runs: Vec<Held> = (0..plan.stances.len() * HOLDS)
        .into_par_iter()
        .map(|run| {
            ensure!(!cancel.load(Ordering::Relaxed), "interrupted");
            let (index, direction) = (run / HOLDS, run % HOLDS);
            let standing = stance::standing(robot, &plan.stances[index])?;
            let push = Some(pushes[direction]).filter(|_| direction > 0);
            let held = hold(robot, world, &standing, config, push);
            done();
            held.with_context(|| format!("stance {index}"))
        })
        .collect::<Result<_>>()?;
    let held = runs.chunks(HOLDS).zip(&plan.stances);
    let held = held.map(|(chunk, stance)| HeldStance {
        stance: stance.index,
        change: stance.change.clone(),
        plain: chunk[0].clone(),
        pushed: chunk[1..].to_vec(),
    });
    Ok(held.collect())
}
