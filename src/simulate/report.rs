//! The file of a simulation's results.

use plan::{Change, Program};
use schemars::JsonSchema;
use serde::Serialize;
use simulation::criteria::Criterion;
use simulation::outcome::{Executed, Held};

/// The value of [`Report::format`].
pub const SIMULATION_FORMAT: &str = "scandent-simulation/1";

/// Everything that a simulation showed.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(title = "Simulation")]
pub struct Report {
    /// Always [`SIMULATION_FORMAT`].
    pub format: &'static str,
    /// The program that simulated.
    pub program: Program,
    /// SHA-256 of the plan's file, hexadecimal.
    pub plan_sha256: String,
    /// SHA-256 of the motion's file, hexadecimal.
    pub motion_sha256: Option<String>,
    /// Whether the world is the true one, or the one that was planned in.
    pub true_world: bool,
    /// Seed of the perturbations.
    pub seed: u64,
    /// The resolved settings.
    pub config: simulation::Config,
    /// The stances that were held.
    pub stances: Vec<HeldStance>,
    /// The motion as planned.
    pub execution: Option<Executed>,
    /// The motion perturbed, run by run.
    pub robust: Vec<Executed>,
    /// How many of those meet every criterion, and how many end standing; empty where there are none.
    pub robustness: Vec<Criterion>,
    /// Whether every criterion holds.
    pub pass: bool,
}

/// How one stance of the plan held.
#[derive(Clone, Debug, Serialize, JsonSchema)]
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
