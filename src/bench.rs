//! Worlds planned one after the other, for `scandent bench`.

pub mod table;
pub mod world;

use std::time::Instant;

use planner::Status;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cli::Global;
use crate::config::Config;
use crate::interrupt;
use crate::pipeline::{self, PlanOutcome, RunOptions};
use crate::provenance::Inputs;
use crate::robot_files::Robots;
use crate::scene::Scene;

/// A world to plan in.
#[derive(Clone, Debug)]
pub struct Item {
    /// What it is called; unique in a run.
    pub name: String,
    /// Its family, or the scene's name.
    pub family: String,
    /// The robot.
    pub robot: String,
    /// Seed of the world; nothing where it was not drawn.
    pub seed: Option<u64>,
    /// Whether it is meant to be within what the robot can do; nothing where it was not drawn.
    pub likely: Option<bool>,
    /// The scene file.
    pub scene: String,
}

/// How the planning of a world ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// A plan that the verifier passes.
    Solved,
    /// A plan that the verifier does not pass.
    Refused,
    /// A proof that there is none.
    NoPlan,
    /// Everything was tried, and none is excluded: ideas ran out.
    Exhausted,
    /// The budget ran out, or the user stopped it.
    BudgetSpent,
    /// Simulated, and every criterion holds.
    Executed,
    /// Simulated, and a criterion does not hold.
    NotExecuted,
    /// The scene could not be used.
    #[default]
    Error,
}

impl Ended {
    /// Its name in the results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Refused => "refused",
            Self::NoPlan => "no-plan",
            Self::Exhausted => "exhausted",
            Self::BudgetSpent => "budget-spent",
            Self::Executed => "executed",
            Self::NotExecuted => "not-executed",
            Self::Error => "error",
        }
    }
}

/// One line of the results.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Name of the world.
    pub world: String,
    /// Its family, or the scene's name.
    pub family: String,
    /// The robot.
    pub robot: String,
    /// Seed of the world.
    pub seed: Option<u64>,
    /// Whether it is meant to be within what the robot can do.
    pub likely: Option<bool>,
    /// How it ended.
    pub ended: Ended,
    /// What blocks the way, or the error.
    pub reason: Option<String>,
    /// Contact sets in the tree.
    pub nodes: usize,
    /// Posture problems solved.
    pub problems: usize,
    /// Stances of the plan.
    pub stances: usize,
    /// How long its motion takes, s.
    pub motion_s: f64,
    /// Time of search and motion, ms.
    pub planning_ms: f64,
    /// Time of verification, ms.
    pub verify_ms: f64,
    /// Time of everything, ms.
    pub total_ms: f64,
    /// Smallest distance from the environment over all stances, m.
    pub clearance_m: Option<f64>,
    /// Largest used part of the torque limits over all stances.
    pub torque_use: f64,
    /// Largest used part of the friction over all stances.
    pub friction_use: f64,
}

impl Row {
    /// An error without a reason: nothing is known yet.
    pub fn of(world: &str, family: &str, robot: &str) -> Self {
        Self {
            world: world.to_owned(),
            family: family.to_owned(),
            robot: robot.to_owned(),
            ..Self::default()
        }
    }
}

/// Plans in a world.
pub fn run(item: &Item, global: &Global, robots: &Robots) -> Row {
    let begin = Instant::now();
    let planned = plan(item, global, robots);
    let total_ms = begin.elapsed().as_secs_f64() * 1e3;
    let row = Row {
        seed: item.seed,
        likely: item.likely,
        total_ms,
        ..Row::of(&item.name, &item.family, &item.robot)
    };
    match planned {
        Ok(planned) => of_outcome(row, &planned),
        Err(error) => Row {
            reason: Some(format!("{error:#}")),
            ..row
        },
    }
}

fn plan(item: &Item, global: &Global, robots: &Robots) -> anyhow::Result<PlanOutcome> {
    let mut inputs = Inputs::default();
    let scene = Scene::open(&item.scene, &mut inputs)?;
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    let options = RunOptions {
        threads: global.threads,
        stage: &|_| {},
        progress: &|_| {},
        cancel: interrupt::listen(),
        robots,
    };
    pipeline::plan(&scene, &config, &options, inputs)
}

/// The row with what came of the planning.
pub fn of_outcome(row: Row, planned: &PlanOutcome) -> Row {
    let ended = match planned.status {
        Status::Found if planned.certificate.pass => Ended::Solved,
        Status::Found => Ended::Refused,
        Status::NoPlan => Ended::NoPlan,
        Status::Exhausted => Ended::Exhausted,
        Status::BudgetSpent | Status::Interrupted => Ended::BudgetSpent,
    };
    let unsolved = planned.report.unsolved.as_ref();
    let reason = unsolved.and_then(|unsolved| unsolved.reasons.first().cloned());
    let (report, plan) = (&planned.report, &planned.plan);
    let found = planned.status == Status::Found;
    let stances = || plan.stances.iter().filter(|_| found).map(|s| &s.margins);
    let ms = |stage: &str| report.stages_ms.get(stage).copied().unwrap_or(0.0);
    Row {
        ended,
        reason,
        nodes: report.nodes_generated,
        problems: plan.search.candidates_solved,
        stances: report.path_stances,
        motion_s: report.motion_s,
        planning_ms: ms("planning") + ms("motion"),
        verify_ms: ms("verify"),
        clearance_m: stances().filter_map(|m| m.clearance_m).reduce(f64::min),
        torque_use: stances().map(|m| m.torque_use).fold(0.0, f64::max),
        friction_use: stances().map(|m| m.friction_use).fold(0.0, f64::max),
        ..row
    }
}
