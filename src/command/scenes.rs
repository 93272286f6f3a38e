//! `scandent scenes`: the scenes that ship.

use std::collections::BTreeMap;
use std::io::Write;

use anyhow::{Context, Result};
use scenes::SceneFile;

use crate::status::Status;
use crate::told::Told;

/// Flags of `scenes`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Prints name and description of every scene.
pub fn run(_args: &Args, told: &mut Told) -> Result<Status> {
    let width = scenes::names().map(str::len).max().unwrap_or(0);
    let mut descriptions = BTreeMap::new();
    for name in scenes::names() {
        let scene = scenes::builtin(name).with_context(|| format!("scene {name} is missing"))?;
        let file = SceneFile::parse(scene.toml).with_context(|| format!("builtin:{name}"))?;
        writeln!(told, "{name:width$}  {}", file.description)?;
        descriptions.insert(name, file.description);
    }
    told.fact("scenes", descriptions)?;
    Ok(Status::Done)
}
