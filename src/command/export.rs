//! `scandent export PLAN.json`: a plan for a controller or a spreadsheet.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;

use crate::cli::Global;
use crate::config::Config;
use crate::export::{self, Format};
use crate::output;
use crate::plan_file::{self, PlanRobotFlags};
use crate::status::Status;

/// Flags of `export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// What to write
    #[arg(long, value_enum)]
    format: Format,
    /// Where it goes (default: the terminal)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    robot: PlanRobotFlags,
}

/// Writes the plan in the format.
///
/// # Errors
/// A plan or a robot that cannot be read; as [`export::export`]; a file that cannot be written.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let plan = plan_file::open(&args.plan)?;
    let robot = args.robot.load(&plan)?;
    let motion = plan_file::open_motion(&args.plan, &plan)?;
    let bytes = export::export(&plan, motion.as_ref(), &robot, args.format, &config.export)?;
    match &args.output {
        Some(path) => {
            output::write(path, &bytes)?;
            writeln!(out, "written: {}", path.display())?;
        }
        None => out.write_all(&bytes)?,
    }
    Ok(Status::Done)
}
