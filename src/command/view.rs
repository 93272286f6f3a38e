//! `scandent view PLAN.json…` and `scandent view SURFACES.json`: one HTML page to look at.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use plan::{Motion, Plan, Trace};
use robot_model::Robot;
use serde_json::Value;
use surfaces::Terrain;

use crate::cli::Global;
use crate::config::Config;
use crate::environment_flags::ScanFlags;
use crate::plan_file::{self, PlanRobotFlags};
use crate::provenance::Inputs;
use crate::scene::Files;
use crate::status::Status;
use crate::told::Told;
use crate::view::{self, Compared, SurfacesInput, ViewInput};
use crate::{environment, output, provenance, search_file};

/// Flags of `view`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A plan, several to compare, or a file of surfaces
    #[arg(value_name = "PLAN.json…|SURFACES.json", required = true)]
    files: Vec<PathBuf>,
    /// The page (default: view.html beside a plan, compare.html beside the first of several, SURFACES.html
    /// beside surfaces)
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
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let source = args.how.scans(&args.scan, &mut Inputs::default())?;
    let cloud_W = environment::points_W(&source, &Files::Folder(PathBuf::new()))?;
    let (page, beside) = match &args.files[..] {
        [file] if !is_plan(file)? => (
            args.surfaces_page(file, &cloud_W, global)?,
            match provenance::is_standard(file) {
                true => "surfaces.html".into(),
                false => file.with_extension("html"),
            },
        ),
        [file] => (
            view::page(&args.plan(file)?.input(&cloud_W))?,
            file.with_file_name("view.html"),
        ),
        files => (
            args.compare_page(files, &cloud_W)?,
            files[0].with_file_name("compare.html"),
        ),
    };
    let path = args.output.clone().unwrap_or(beside);
    output::write(&path, page.as_bytes())?;
    told.open(path.display())?;
    Ok(Status::Done)
}

impl Args {
    fn plan(&self, file: &Path) -> Result<PlanFiles> {
        let plan = plan_file::open(file)?;
        Ok(PlanFiles {
            motion: plan_file::open_motion(file, &plan)?,
            trace: search_file::beside(file)?,
            robot: self.robot.load(&plan)?,
            plan,
        })
    }

    fn compare_page(&self, files: &[PathBuf], cloud_W: &[[f32; 3]]) -> Result<String> {
        // A folder of results says enough.
        let name = |file: &Path| match (file.ends_with("plan.json"), file.parent()) {
            (true, Some(folder)) if !folder.as_os_str().is_empty() => folder.display().to_string(),
            _ => file.display().to_string(),
        };
        let read = files.iter().map(|file| Ok((name(file), self.plan(file)?)));
        let read = read.collect::<Result<Vec<_>>>()?;
        let plans = read.iter().map(|(name, files)| Compared {
            name,
            input: files.input(cloud_W),
        });
        view::compare_page(&plans.collect::<Vec<_>>())
    }

    fn surfaces_page(&self, file: &Path, cloud_W: &[[f32; 3]], global: &Global) -> Result<String> {
        view::surfaces_page(&SurfacesInput {
            name: &file.file_name().unwrap_or_default().to_string_lossy(),
            terrain: &open_surfaces(file)?,
            cloud_W,
            config: &Config::layered(None, global)?,
            asked: &Value::Null,
            robots: &[],
            served: false,
        })
    }
}

/// A plan with what stands beside it.
struct PlanFiles {
    plan: Plan,
    motion: Option<Motion>,
    trace: Option<Trace>,
    robot: Robot,
}

impl PlanFiles {
    fn input<'a>(&'a self, cloud_W: &'a [[f32; 3]]) -> ViewInput<'a> {
        ViewInput {
            motion: self.motion.as_ref(),
            trace: self.trace.as_ref(),
            cloud_W,
            ..ViewInput::new(&self.plan, &self.robot)
        }
    }
}

/// Whether a file says that it is a plan, or is nothing that says what it is.
fn is_plan(path: &Path) -> Result<bool> {
    let bytes = provenance::read("plan or surfaces", path)?;
    let value: Option<Value> = serde_json::from_slice(&bytes).ok();
    let format = value.as_ref().and_then(|v| v["format"].as_str());
    Ok(!format.is_some_and(|format| format.contains("surfaces")))
}

/// Reads a file of surfaces.
///
/// # Errors
/// A file that cannot be read or is none.
pub fn open_surfaces(path: &Path) -> Result<Terrain> {
    let name = path.display();
    let text = provenance::text(&name, provenance::read("surfaces", path)?)?;
    Terrain::from_json(&text).with_context(|| name.to_string())
}
