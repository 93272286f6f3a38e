//! Every stance of a plan, held.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use plan::{Change, Plan};
use rayon::prelude::*;
use robot_model::Robot;
use serde::Serialize;
use simulation::hold::{Held, hold};
use simulation::world::WorldBody;

use super::stance;

/// How one stance of the plan held.
#[derive(Clone, Debug, Serialize)]
pub struct HeldStance {
    /// Index in the plan.
    pub stance: usize,
    /// How it differs from the one before.
    pub change: Change,
    /// Undisturbed.
    pub plain: Held,
    /// Pushed along +x, −x, +y and −y of W.
    pub pushed: Vec<Held>,
}

impl HeldStance {
    /// Whether it held undisturbed and pushed.
    pub fn pass(&self) -> bool {
        self.plain.pass && self.pushed.iter().all(|held| held.pass)
    }
}

/// Holds every stance, plain and pushed.
///
/// # Errors
/// A stance that does not fit the robot, a robot that cannot be simulated; that `cancel` was raised.
pub fn hold_all(
    plan: &Plan,
    robot: &Robot,
    world: &[WorldBody],
    config: &simulation::Config,
    cancel: &AtomicBool,
) -> Result<Vec<HeldStance>> {
    let (x, y) = (Vector3::x(), Vector3::y());
    let pushes = [x, -x, y, -y].map(|along| Some(along * config.hold_push_n));
    let directions = [&[None][..], &pushes].concat();
    let runs: Vec<Held> = (0..plan.stances.len() * directions.len())
        .into_par_iter()
        .map(|run| {
            ensure!(!cancel.load(Ordering::Relaxed), "interrupted");
            let (index, direction) = (run / directions.len(), run % directions.len());
            let standing = stance::standing(robot, &plan.stances[index])?;
            hold(robot, world, &standing, config, directions[direction])
                .with_context(|| format!("stance {index}"))
        })
        .collect::<Result<_>>()?;
    let held = runs.chunks(directions.len()).zip(&plan.stances);
    let held = held.map(|(chunk, stance)| HeldStance {
        stance: stance.index,
        change: stance.change.clone(),
        plain: chunk[0].clone(),
        pushed: chunk[1..].to_vec(),
    });
    Ok(held.collect())
}
