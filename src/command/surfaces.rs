//! `scandent surfaces SCAN…`: the surfaces of scans or of a mesh.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;

use crate::cli::Global;
use crate::config::Config;
use crate::environment::levelled::{doubt, levelled};
use crate::environment_flags::ScanFlags;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};
use crate::status::Status;
use crate::{environment, output, summary, threads};

/// Flags of `surfaces`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Depth images (16-bit PNG) or point clouds (PCD, PLY)
    #[arg(value_name = "SCAN", required_unless_present = "mesh")]
    scans: Vec<PathBuf>,
    #[command(flatten)]
    how: ScanFlags,
    /// A mesh of the environment (STL, OBJ) instead of scans
    #[arg(long, value_name = "MESH", conflicts_with_all = ["scans", "sensor", "pose"])]
    mesh: Option<PathBuf>,
    /// Where the surfaces go (without it they are only listed)
    #[arg(short, long, value_name = "SURFACES.json")]
    output: Option<PathBuf>,
}

/// Extracts the surfaces, lists them and writes them.
///
/// # Errors
/// As [`environment::perceive`]; a file that cannot be written.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let source = match &args.mesh {
        Some(mesh) => Environment::Mesh(mesh.display().to_string()),
        None => args.how.scans(&args.scans)?,
    };
    let mut stages = Stages::default();
    let mut inputs = Inputs::default();
    let files = Files::Folder(PathBuf::new());
    let (source, mut notes) = levelled(&source, &files, &config)?;
    let perceived = threads::pool(global.threads)?
        .install(|| environment::perceive(&source, &files, &config, &mut stages, &mut inputs))?;
    notes.extend(perceived.notes);
    notes.extend(doubt(&source, &perceived.terrain).map(|why| format!("warning: {why}")));
    for note in &notes {
        writeln!(out, "{note}")?;
    }
    let terrain = perceived.terrain;
    summary::faces(&terrain.faces, config.posture.edge_sigmas, out)?;
    writeln!(out, "{}", stages.text())?;
    if let Some(path) = &args.output {
        output::write(path, terrain.to_json()?.as_bytes())?;
        writeln!(out, "written: {}", path.display())?;
    }
    Ok(Status::Done)
}
