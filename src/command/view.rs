//! `scandent view PLAN.json` and `scandent view SURFACES.json`: one HTML page to look at.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use serde_json::Value;
use surfaces::Terrain;

use crate::cli::Global;
use crate::config::Config;
use crate::environment_flags::ScanFlags;
use crate::plan_file::{self, PlanRobotFlags};
use crate::scene::Files;
use crate::status::Status;
use crate::view::{self, SurfacesInput, ViewInput};
use crate::{environment, output, provenance, search_file};

/// Flags of `view`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A plan, or a file of surfaces
    #[arg(value_name = "PLAN.json|SURFACES.json")]
    file: PathBuf,
    /// The page (default: view.html beside a plan, SURFACES.html beside surfaces)
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    #[command(flatten)]
    robot: PlanRobotFlags,
    /// Scans to show with it
    #[arg(long, value_name = "SCAN", num_args = 1..)]
    scan: Vec<PathBuf>,
    #[command(flatten)]
    how: ScanFlags,
}

/// Writes the page.
///
/// # Errors
/// A plan, surfaces, a robot or a scan that cannot be read; a file that cannot be written.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let source = args.how.scans(&args.scan)?;
    let cloud_W = environment::points_W(&source, &Files::Folder(PathBuf::new()))?;
    let (page, beside) = if is_plan(&args.file)? {
        (
            args.plan_page(&cloud_W)?,
            args.file.with_file_name("view.html"),
        )
    } else {
        let terrain = open_surfaces(&args.file)?;
        let page = view::surfaces_page(&SurfacesInput {
            name: &args.file.file_name().unwrap_or_default().to_string_lossy(),
            terrain: &terrain,
            cloud_W: &cloud_W,
            config: &Config::layered(None, global)?,
            asked: &Value::Null,
            served: false,
        })?;
        (page, args.file.with_extension("html"))
    };
    let path = args.output.clone().unwrap_or(beside);
    output::write(&path, page.as_bytes())?;
    writeln!(out, "open in a browser: {}", path.display())?;
    Ok(Status::Done)
}

impl Args {
    fn plan_page(&self, cloud_W: &[[f32; 3]]) -> Result<String> {
        let plan = plan_file::open(&self.file)?;
        view::page(&ViewInput {
            plan: &plan,
            motion: plan_file::open_motion(&self.file, &plan)?.as_ref(),
            trace: search_file::beside(&self.file)?.as_ref(),
            robot: &self.robot.load(&plan)?,
            certificate: None,
            cloud_W,
        })
    }
}

/// Whether a file says that it is a plan, or is nothing that says what it is.
fn is_plan(path: &std::path::Path) -> Result<bool> {
    let bytes = provenance::read("plan or surfaces", path)?;
    let value: Option<Value> = serde_json::from_slice(&bytes).ok();
    let format = value.as_ref().and_then(|v| v["format"].as_str());
    Ok(!format.is_some_and(|format| format.contains("surfaces")))
}

/// Reads a file of surfaces.
///
/// # Errors
/// A file that cannot be read or is none.
pub fn open_surfaces(path: &std::path::Path) -> Result<Terrain> {
    let name = path.display();
    let text = String::from_utf8(provenance::read("surfaces", path)?);
    let text = text.with_context(|| format!("{name}: not a text file"))?;
    Terrain::from_json(&text).with_context(|| name.to_string())
}
