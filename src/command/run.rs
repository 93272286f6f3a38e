//! `scandent run [SCENE]`: scan to verified plan, with every result written.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use planner::Status as Ended;

use crate::cli::Global;
use crate::config::Config;
use crate::extrinsics::placement;
use crate::output::Folder;
use crate::pipeline::{self, PlanOutcome, RunOptions};
use crate::progress::ProgressLine;
use crate::provenance::Inputs;
use crate::robot_files::Robots;
use crate::scene::Scene;
use crate::status::Status;
use crate::{interrupt, results, summary};

/// The scene that runs where none is named.
const DEFAULT_SCENE: &str = "irregular-stairs";
/// Where results go where no folder is named.
const DEFAULT_OUTPUT: &str = "out";

/// Flags of `run`.
#[derive(Debug, Default, clap::Args)]
pub struct Args {
    /// A scene that ships (see `scandent scenes`) or a scene.toml; default: irregular-stairs
    scene: Option<String>,
    /// Take the sensor's place from this file, as `calibrate` writes it, instead of the scene's
    #[arg(long, value_name = "MOUNT.toml")]
    extrinsics: Option<PathBuf>,
    /// Folder of the results; each scene gets a folder in it (default: out)
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Plans for the scene and writes the results to `out/SCENE/`.
///
/// # Errors
/// As [`pipeline::plan`]; a plan that does not pass the verifier; a file that cannot be written.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let mut inputs = Inputs::default();
    let name = args.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let scene = asked(name, args.extrinsics.as_deref(), global, &mut inputs)?;
    let output = args.output.clone().unwrap_or_else(|| DEFAULT_OUTPUT.into());
    let folder = output.join(&scene.name);
    plan_with_progress(&scene, inputs, &folder, global, out)
}

/// The scene of a name, its scans where its mounts, or the one given, say.
///
/// # Errors
/// As [`Scene::open`] and [`placement::place`].
pub fn asked(
    name: &str,
    mount: Option<&Path>,
    global: &Global,
    inputs: &mut Inputs,
) -> Result<Scene> {
    let mut scene = Scene::open(name, inputs)?;
    placement::place(&mut scene, mount, global, inputs)?;
    Ok(scene)
}

/// What `run` and `plan` have in common: [`plan_and_write`] with a line of progress.
///
/// # Errors
/// As [`run`].
pub fn plan_with_progress(
    scene: &Scene,
    inputs: Inputs,
    folder: &Path,
    global: &Global,
    out: &mut dyn Write,
) -> Result<Status> {
    let line = ProgressLine::default();
    let asked = Asked {
        scene,
        inputs,
        folder,
        global,
    };
    let manner = RunOptions {
        threads: global.threads,
        stage: &|stage| line.stage(stage),
        progress: &|progress| line.show(progress),
        cancel: interrupt::listen(),
        robots: &Robots::default(),
    };
    plan_and_write(asked, &manner, out)
}

/// A scene to plan for, and where its results go.
pub struct Asked<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What was read so far.
    pub inputs: Inputs,
    /// The folder of the results.
    pub folder: &'a std::path::Path,
    /// The settings of the command line.
    pub global: &'a Global,
}

/// Settings, search, results, verdict.
///
/// # Errors
/// As [`run`].
pub fn plan_and_write(
    asked: Asked<'_>,
    manner: &RunOptions<'_>,
    out: &mut dyn Write,
) -> Result<Status> {
    let Asked {
        scene,
        inputs,
        folder,
        global,
    } = asked;
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    scene.will_read();
    let results = Folder::new(folder, results::NAMES)?;
    writeln!(out, "{}", scene.name)?;
    let planned = pipeline::plan(scene, &config, manner, inputs)?;
    (manner.stage)("writing");
    summary::print(&planned, out)?;
    results::write(results, &planned)?;
    writeln!(out, "results: {}", folder.display())?;
    let ended = verdict(&planned, out);
    let page = folder.join("view.html");
    writeln!(out, "open in a browser: {}", page.display())?;
    ended
}

/// How the command ends; a plan that fails its verification is an error.
fn verdict(planned: &PlanOutcome, out: &mut dyn Write) -> Result<Status> {
    match planned.status {
        Ended::NoPlan => Ok(Status::NoPlan),
        Ended::Exhausted | Ended::BudgetSpent | Ended::Interrupted => Ok(Status::Undecided),
        Ended::Found if planned.certificate.pass => {
            let rows: usize = planned.certificate.summary.iter().map(|s| s.rows).sum();
            writeln!(out, "verified: all of {rows} checks pass")?;
            for condition in &planned.certificate.conditions {
                writeln!(out, "  {condition}")?;
            }
            Ok(Status::Done)
        }
        Ended::Found => {
            let failures = planned.certificate.failures().take(5);
            let failures: Vec<String> = failures.map(|row| row.sentence()).collect();
            let failures = failures.join("; ");
            bail!("the plan that was found does not pass verification: {failures}")
        }
    }
}
