//! `scandent verify PLAN.json`: everything that a plan promises, recomputed.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;

use crate::output;
use crate::plan_file::{self, PlanRobotFlags};
use crate::status::Status;

/// Flags of `verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    #[command(flatten)]
    robot: PlanRobotFlags,
    /// Where the certificate goes, with every check of every stance
    #[arg(short, long, value_name = "CERTIFICATE.json")]
    output: Option<PathBuf>,
}

/// Prints the table of margins; ends with [`Status::Failed`] where one does not hold.
///
/// # Errors
/// A plan or a robot that cannot be read; a file that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> Result<Status> {
    let plan = plan_file::open(&args.plan)?;
    let robot = args.robot.load(&plan)?;
    let motion = plan_file::open_motion(&args.plan, &plan)?;
    let options = verify::Options::default();
    let certificate = verify::verify_with(&plan, motion.as_ref(), &robot, &options);
    write!(out, "{}", certificate.table())?;
    if let Some(path) = &args.output {
        output::write(path, certificate.to_json()?.as_bytes())?;
    }
    for row in certificate.failures() {
        eprintln!("fails: {}", row.sentence());
    }
    Ok(match certificate.pass {
        true => Status::Done,
        false => Status::Failed,
    })
}
