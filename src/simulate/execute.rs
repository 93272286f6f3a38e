//! The motion of a plan, executed: as planned and perturbed.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use robot_model::Robot;
use simulation::execution::{Unobserved, execute};
use simulation::outcome::Executed;
use simulation::perturbation::{Kinds, Perturbation};
use simulation::playback::Playback;
use simulation::reference::Reference;
use simulation::used_faces::used_faces;
use simulation::world::WorldBody;

/// Runs of a seed: each disturbed in its own way, in the order of their numbers. `done` is called after each.
///
/// # Errors
/// A robot that cannot be simulated, a controller without a solution; that `cancel` was raised.
pub fn robust_runs(
    robot: &Robot,
    world: &[WorldBody],
    playback: &Playback,
    (config, kinds, seed): (&simulation::Config, Kinds, u64),
    runs: u64,
    cancel: &AtomicBool,
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Executed>> {
    let used = used_faces(robot, world, playback);
    (0..runs)
        .into_par_iter()
        .map(|run| {
            ensure!(!cancel.load(Ordering::Relaxed), "interrupted");
            let duration_s = playback.duration_s();
            let push =
                Perturbation::draw(seed, run, &config.perturbation, kinds, &used, duration_s);
            let executed = execute(robot, world, playback, config, &push, &mut Unobserved);
            done();
            executed.with_context(|| format!("run {run}"))
        })
        .collect()
}
