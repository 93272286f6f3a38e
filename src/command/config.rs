//! `scandent config [SCENE]`: every setting with the value that a run would use.

use std::io::Write;

use anyhow::Result;

use crate::cli::Global;
use crate::config::{Config, documented};
use crate::provenance::Inputs;
use crate::scene::Scene;
use crate::status::Status;
use crate::told::Told;

/// Flags of `config`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene that ships or a scene.toml, whose settings are laid over the defaults
    scene: Option<String>,
}

/// Prints the settings as TOML, each below what it means; the output can be given back with `--config`.
///
/// # Errors
/// A scene or a setting that does not exist.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let mut inputs = Inputs::default();
    let scene = args.scene.as_deref();
    let scene = scene
        .map(|name| Scene::open(name, &mut inputs))
        .transpose()?;
    let layer = scene.as_ref().map(|s| (s.name.as_str(), &s.settings));
    let config = Config::layered(layer, global)?;
    told.write_all(documented(&config)?.as_bytes())?;
    told.fact("settings", &config)?;
    Ok(Status::Done)
}
