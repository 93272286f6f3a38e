//! `scandent serve [FOLDER]`: surfaces, scenes and plans of a folder in a browser on this machine.

use std::path::PathBuf;

use anyhow::Result;

use crate::cli::Global;
use crate::status::Status;
use crate::told::Told;

/// Flags of `serve`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder whose files may be opened and in which results are written
    #[arg(value_name = "FOLDER", default_value = ".")]
    folder: PathBuf,
    /// The port (default: any that is free)
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
}

/// Serves until it is interrupted.
///
/// # Errors
/// A folder that is not there, a port that is taken.
#[cfg(not(target_os = "wasi"))]
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    use crate::serve::Server;
    use std::io::Write;

    let server = Server::bind(&args.folder, args.port, global)?;
    told.open(server.address())?;
    writeln!(told, "Ctrl-C ends it")?;
    told.end(&Ok(Status::Done));
    server.run();
    Ok(Status::Done)
}

/// Answers one request.
///
/// # Errors
/// As [`crate::serve::answer`].
#[cfg(target_os = "wasi")]
pub fn run(args: &Args, global: &Global, _: &mut Told) -> Result<Status> {
    crate::serve::answer(&args.folder, global)?;
    Ok(Status::Done)
}
