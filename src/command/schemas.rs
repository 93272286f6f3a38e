//! `scandent schemas -o DIR`: the JSON Schemas of the files that are read and written.

use std::path::PathBuf;

use anyhow::Result;

use crate::status::Status;
use crate::told::Told;
use crate::{argument, output, schemas};

/// Flags of `schemas`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the schemas: plan.schema.json, scene.schema.json, …
    #[arg(short, long, value_name = "DIR", value_parser = argument::folder)]
    output: PathBuf,
}

/// Writes a schema for each kind of file.
///
/// # Errors
/// A folder that cannot be written.
pub fn run(args: &Args, told: &mut Told) -> Result<Status> {
    for (name, schema) in schemas::all() {
        let path = args.output.join(format!("{name}.schema.json"));
        output::write_json(&path, &schema)?;
        told.written(&path)?;
    }
    Ok(Status::Done)
}
