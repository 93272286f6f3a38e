//! `scandent posture-sets`: posture problems drawn from a seed.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use robot_model::Robot;
use scenes::contact_sets::{self, Family, ProblemSet};

use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::posture_problem;
use crate::provenance::Inputs;
use crate::robot_files::{RobotFiles, UNPROPOSED};
use crate::status::Status;
use crate::told::Told;

/// Flags of `posture-sets`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    robot: RobotFiles,
    /// easy, free, steep, one-foot, chimney, spread, infeasible, or hard for steep to spread in
    /// turns
    #[arg(long, value_name = "NAME")]
    family: String,
    /// How many problems
    #[arg(long, value_name = "N", default_value_t = 120)]
    count: usize,
    /// Where the problems go
    #[arg(short, long, value_name = "PROBLEMS.json")]
    output: PathBuf,
}

/// Draws the problems from the seed of `--seed` (0 without it) and writes them.
///
/// # Errors
/// A robot that cannot be read or does not suit the family, an unknown family.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let files = &args.robot;
    let robot = files.load(&config.robot_model, &mut Inputs::default())?;
    let (seed, set) = (
        config.seed,
        draw(&robot, &args.family, args.count, &config)?,
    );
    output::write_json(&args.output, &set)?;
    let (count, robot, family) = (set.problems.len(), &set.robot, &set.family);
    writeln!(told, "{count} problems for {robot} ({family}), seed {seed}")?;
    told.fact("problems", count)?;
    told.written(&args.output)?;
    Ok(Status::Done)
}

/// The problems of a family by name.
///
/// # Errors
/// As [`run`].
pub fn draw(robot: &Robot, family: &str, count: usize, config: &Config) -> Result<ProblemSet> {
    let families = Family::named(family).ok_or_else(|| {
        let known: Vec<&str> = Family::ALL.iter().map(|f| f.name()).collect();
        let known = known.join(", ");
        anyhow!("no family {family:?}; there are {known} and hard")
    })?;
    let margins = posture_problem::margins(&config.posture);
    let set = contact_sets::generate(robot, &families, &margins, count, config.seed);
    set.map_err(|error| {
        // Why it has no patches, where that is so.
        let unproposed = robot.notes.iter().find(|n| n.starts_with(UNPROPOSED));
        anyhow!(unproposed.map_or(error.to_string(), |note| format!("{error}; {note}")))
    })
}
