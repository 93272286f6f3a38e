//! `scandent run [SCENE]`: scan to verified plan, with every result written.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use planner::Status as Ended;
use serde_json::json;

use crate::argument;
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
use crate::told::Told;
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
    #[arg(short, long, value_name = "FOLDER", value_parser = argument::folder)]
    output: Option<PathBuf>,
}

/// Plans for the scene and writes the results to `out/SCENE/`.
///
/// # Errors
/// As [`pipeline::plan`]; a plan that does not pass the verifier; a file that cannot be written.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let mut inputs = Inputs::default();
    let name = args.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let scene = asked(name, args.extrinsics.as_deref(), global, &mut inputs)?;
    let output = args.output.clone().unwrap_or_else(|| DEFAULT_OUTPUT.into());
    let folder = output.join(&scene.name);
    plan_with_progress(&scene, inputs, &folder, global, told)
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
    told: &mut Told,
) -> Result<Status> {
    let line = ProgressLine::default();
    let manner = RunOptions {
        threads: global.threads,
        stage: &|stage| line.stage(stage),
        progress: &|progress| line.show(progress),
        cancel: interrupt::listen(),
        robots: &Robots::default(),
    };
    plan_and_write(scene, inputs, folder, global, &manner, told)
}

/// Settings, search, results, verdict.
///
/// # Errors
/// As [`run`].
pub fn plan_and_write(
    scene: &Scene,
    inputs: Inputs,
    folder: &Path,
    global: &Global,
    manner: &RunOptions<'_>,
    told: &mut Told,
) -> Result<Status> {
    let config = Config::layered(Some((&scene.name, &scene.settings)), global)?;
    scene.will_read();
    let results = Folder::new(folder, results::NAMES)?;
    writeln!(told, "{}", scene.name)?;
    told.fact("scene", &scene.name)?;
    let planned = pipeline::plan(scene, &config, manner, inputs)?;
    (manner.stage)("writing");
    summary::print(&planned, told)?;
    results::write(results, &planned)?;
    told.written(folder)?;
    let ended = verdict(&planned, told);
    told.open(folder.join("view.html").display())?;
    ended
}

/// How the command ends; a plan that fails its verification is an error.
fn verdict(planned: &PlanOutcome, told: &mut Told) -> Result<Status> {
    match planned.status {
        Ended::NoPlan => Ok(Status::NoPlan),
        Ended::Exhausted | Ended::BudgetSpent | Ended::Interrupted => Ok(Status::Undecided),
        Ended::Found if planned.certificate.pass => {
            let rows: usize = planned.certificate.summary.iter().map(|s| s.rows).sum();
            let conditions = &planned.certificate.conditions;
            let conditionally = match conditions.is_empty() {
                true => "",
                false => ", conditionally",
            };
            writeln!(told, "verified{conditionally}: all of {rows} checks pass")?;
            for line in conditions.iter().chain(&planned.certificate.notes) {
                writeln!(told, "  {line}")?;
            }
            told.fact(
                "verified",
                json!({ "checks": rows, "conditions": conditions }),
            )?;
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
