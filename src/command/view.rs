//! `scandent view PLAN.json`: one HTML page to look at.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;

use crate::environment;
use crate::environment_flags::ScanFlags;
use crate::output;
use crate::plan_file::{self, PlanRobotFlags};
use crate::scene::Files;
use crate::status::Status;
use crate::view::{self, ViewInput};

/// Flags of `view`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// The page (default: view.html beside the plan)
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    #[command(flatten)]
    robot: PlanRobotFlags,
    /// Scans to show with the plan
    #[arg(long, value_name = "SCAN", num_args = 1..)]
    scan: Vec<PathBuf>,
    #[command(flatten)]
    how: ScanFlags,
}

/// Writes the page.
///
/// # Errors
/// A plan, a robot or a scan that cannot be read; a file that cannot be written.
pub fn run(args: &Args, out: &mut dyn Write) -> Result<Status> {
    let plan = plan_file::open(&args.plan)?;
    let motion = plan_file::open_motion(&args.plan, &plan)?;
    let robot = args.robot.load(&plan)?;
    let source = args.how.scans(&args.scan)?;
    let files = Files::Folder(PathBuf::new());
    let cloud_W = environment::points_W(&source, &files)?;
    let page = view::page(&ViewInput {
        plan: &plan,
        motion: motion.as_ref(),
        robot: &robot,
        certificate: None,
        cloud_W: &cloud_W,
    })?;
    let beside = || args.plan.with_file_name("view.html");
    let path = args.output.clone().unwrap_or_else(beside);
    output::write(&path, page.as_bytes())?;
    writeln!(out, "written: {}", path.display())?;
    Ok(Status::Done)
}
