//! `scandent completions SHELL`: the completion script of a shell.

use std::io::Write;

use anyhow::Result;
use clap::CommandFactory;

use crate::cli::Cli;
use crate::status::Status;
use crate::told::Told;

/// Flags of `completions`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    shell: clap_complete::Shell,
}

/// Prints the script.
pub fn run(args: &Args, told: &mut Told) -> Result<Status> {
    // Into memory first: the generator panics when its writer fails.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "scandent", &mut script);
    told.write_all(&script)?;
    told.fact("script", String::from_utf8(script)?)?;
    Ok(Status::Done)
}
