//! `scandent surfaces SCAN…`: the surfaces of scans or of a mesh.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;
use serde_json::Value;
use surfaces::Terrain;

use crate::argument;
use crate::cli::Global;
use crate::config::Config;
use crate::environment::levelled::{doubt, levelled};
use crate::environment_flags::ScanFlags;
use crate::goal::suggested;
use crate::provenance::Inputs;
use crate::report::Stages;
use crate::scene::{Environment, Files};
use crate::status::Status;
use crate::told::Told;
use crate::view::{self, SurfacesInput};
use crate::{environment, output, summary, threads};

/// Flags of `surfaces`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Depth images (16-bit PNG, TIFF, npy, npz), point clouds (npy, npz, PCD, PLY, LAS, E57, text) or ROS 2 bags (MCAP)
    #[arg(value_name = "SCAN", required_unless_present = "mesh")]
    scans: Vec<PathBuf>,
    #[command(flatten)]
    how: ScanFlags,
    /// A mesh of the environment (STL, OBJ, PLY, DAE, glTF) instead of scans
    #[arg(long, value_name = "MESH", value_parser = argument::file, conflicts_with_all = ["scans", "sensor", "pose"])]
    mesh: Option<PathBuf>,
    /// Where the surfaces go (without it they are only listed)
    #[arg(short, long, value_name = "SURFACES.json")]
    output: Option<PathBuf>,
    /// Write a page to look at the surfaces and to edit them
    #[arg(long, value_name = "PAGE.html", num_args = 0..=1, default_missing_value = "surfaces.html")]
    view: Option<PathBuf>,
}

/// Extracts the surfaces, lists them and writes them.
///
/// # Errors
/// As [`environment::perceive`]; a file that cannot be written.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let source = match &args.mesh {
        Some(mesh) => Environment::Mesh(mesh.display().to_string()),
        None => args.how.scans(&args.scans, &mut inputs)?,
    };
    let mut stages = Stages::default();
    let files = Files::Folder(PathBuf::new());
    let (source, mut notes) = levelled(&source, &files, &config)?;
    let pool = threads::pool(global.threads)?;
    let perceived = told.during("extracting surfaces", || {
        pool.install(|| environment::perceive(&source, &files, &config, &mut stages, &mut inputs))
    })?;
    notes.extend(perceived.notes);
    notes.extend(doubt(&source, &perceived.terrain).map(|why| format!("warning: {why}")));
    for note in &notes {
        told.note(note)?;
    }
    let terrain = perceived.terrain;
    summary::faces(&terrain.faces, config.posture.edge_sigmas, told)?;
    writeln!(told, "{}", stages.text())?;
    let json = terrain.to_json()?;
    told.written_fact("surfaces", json.as_bytes())?;
    told.fact("stages_ms", &stages.ms)?;
    if let Some(path) = &args.output {
        output::write(path, json.as_bytes())?;
        told.written(path)?;
    }
    if let Some(path) = &args.view {
        let page = view::surfaces_page(&SurfacesInput {
            name: &args.named(),
            terrain: &terrain,
            cloud_W: &perceived.cloud_W,
            config: &config,
            asked: &Value::Null,
            robots: &[],
            served: false,
        })?;
        output::write(path, page.as_bytes())?;
        told.open(path.display())?;
    }
    if let Some(next) = args.next(&terrain, &config) {
        writeln!(told, "then, or with your URDF as --robot: {next}")?;
        told.fact("next", next)?;
    }
    Ok(Status::Done)
}

impl Args {
    /// What the surfaces are called: the files that they come from.
    fn named(&self) -> String {
        let files = self.scans.iter().chain(&self.mesh);
        let names = files.filter_map(|file| Some(file.file_name()?.to_str()?.to_owned()));
        names.collect::<Vec<String>>().join(", ")
    }

    /// A command that plans on what was seen, to a goal that is suggested, with the flags of this one.
    fn next(&self, terrain: &Terrain, config: &Config) -> Option<String> {
        let [x, y] = suggested(terrain, config)?;
        let ours = ["-o", "--output", "--view", "--json"];
        let outputs: Vec<String> = [&self.output, &self.view]
            .into_iter()
            .flatten()
            .map(|path| path.display().to_string())
            .collect();
        let mut flags = Vec::new();
        let mut given = std::env::args().skip(1).peekable();
        while let Some(flag) = given.next() {
            let name = flag.split_once('=').map_or(flag.as_str(), |(name, _)| name);
            if ours.contains(&name) {
                given.next_if(|value| outputs.contains(value));
            } else if flag != "surfaces" && !self.scans.iter().any(|scan| *scan == *flag) {
                flags.push(quoted(&flag));
            }
        }
        let scans: Vec<String> = self
            .scans
            .iter()
            .map(|scan| quoted(&scan.display().to_string()))
            .collect();
        if !scans.is_empty() {
            flags.insert(0, format!("--scan {}", scans.join(" ")));
        }
        let flags = flags.join(" ");
        Some(format!(
            "scandent plan {flags} --robot builtin:hrp2 --goal {x},{y} -o out/plan"
        ))
    }
}

/// A word as a shell takes it for one.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+".contains(c);
    match word.chars().all(plain) && !word.is_empty() {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}
