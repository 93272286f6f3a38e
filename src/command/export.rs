//! `scandent export PLAN.json`: a plan for a controller or a spreadsheet.

use std::path::PathBuf;

use anyhow::Result;

use crate::cli::Global;
use crate::config::Config;
use crate::export::{self, Format};
use crate::output;
use crate::plan_file::{self, PlanRobotFlags};
use crate::status::Status;
use crate::told::Told;

/// Flags of `export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// What to write
    #[arg(long, value_enum)]
    format: Format,
    /// Where it goes (default: the standard output)
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    #[command(flatten)]
    robot: PlanRobotFlags,
}

/// Writes the plan in the format.
///
/// # Errors
/// A plan or a robot that cannot be read; as [`export::export`]; a file that cannot be written.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let plan = plan_file::open(&args.plan)?;
    let robot = args.robot.load(&plan)?;
    let motion = plan_file::open_motion(&args.plan, &plan)?;
    let bytes = export::export(&plan, motion.as_ref(), &robot, args.format, &config.export)?;
    output::write(&args.output, &bytes)?;
    told.written(&args.output)?;
    Ok(Status::Done)
}
