//! `scandent man -o DIR`: the manual pages.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;
use clap::CommandFactory;
use clap_mangen::Man;

use crate::argument;
use crate::cli::Cli;
use crate::output;
use crate::status::Status;
use crate::told::Told;

/// Flags of `man`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the pages: scandent.1, and one for each command
    #[arg(short, long, value_name = "DIR", value_parser = argument::folder)]
    output: PathBuf,
}

/// Writes a page for the program and one for each of its commands.
///
/// # Errors
/// A folder that cannot be written.
pub fn run(args: &Args, told: &mut Told) -> Result<Status> {
    let mut program = Cli::command();
    // Gives every command the flags that all of them have.
    program.build();
    let mut waiting = vec![program];
    while let Some(command) = waiting.pop() {
        let own = command.get_subcommands().filter(|c| c.get_name() != "help");
        waiting.extend(own.cloned());
        let man = Man::new(command);
        let mut page = Vec::new();
        man.render(&mut page)?;
        output::write(&args.output.join(man.get_filename()), &page)?;
    }
    writeln!(told, "man -l {}", args.output.join("scandent.1").display())?;
    told.fact("pages", &args.output)?;
    Ok(Status::Done)
}
