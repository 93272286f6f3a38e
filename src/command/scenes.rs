//! `scandent scenes`: the scenes that ship.

use std::io::Write;

use anyhow::{Context, Result};
use scenes::SceneFile;

use crate::status::Status;

/// Flags of `scenes`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Prints name and description of every scene.
///
/// # Errors
/// When it cannot be printed.
pub fn run(_args: &Args, out: &mut dyn Write) -> Result<Status> {
    let width = scenes::names().map(str::len).max().unwrap_or(0);
    for name in scenes::names() {
        let scene = scenes::builtin(name).with_context(|| format!("scene {name} is missing"))?;
        let file = SceneFile::parse(scene.toml).with_context(|| format!("builtin:{name}"))?;
        writeln!(out, "{name:width$}  {}", file.description)?;
    }
    Ok(Status::Done)
}
