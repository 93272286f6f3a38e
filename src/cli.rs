//! The command line: flags, dispatch to a command, logging and the exit code.

use std::io::{ErrorKind, IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::command;
use crate::status::{Status, UsageError};
use crate::threads;
use crate::told::Told;

/// Plans multi-contact climbs for legged robots from a single scan.
#[derive(Debug, Parser)]
#[command(name = "scandent", version, about, after_help = EXIT_CODES)]
pub struct Cli {
    /// What to do; without a command: `run`.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What every command understands.
    #[command(flatten)]
    pub global: Global,
}

const EXIT_CODES: &str = "Exit codes: 0 done (a plan was found), 1 error, 2 usage, \
    3 there is no plan, or a simulated plan misses a criterion (the reason is printed), 4 no plan was found and none is excluded.\n\
    RUST_LOG=info (or debug, scandent=debug, …) logs to stderr.";

/// Flags that every command understands.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Settings")]
pub struct Global {
    /// Change one setting, such as planner.nodes_max=200 (repeatable; `scandent config` lists all)
    #[arg(long, global = true, value_name = "TABLE.KEY=VALUE")]
    pub set: Vec<String>,
    /// Settings to lay over the defaults and the scene's, as `scandent config` prints them
    #[arg(long, global = true, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// After the first plan spend this many nodes on shorter ones
    #[arg(long, global = true, value_name = "NODES")]
    pub improve: Option<usize>,
    /// Threads for the search (default: all; the plan does not depend on it)
    #[arg(long, global = true, value_name = "N", value_parser = threads::count)]
    pub threads: Option<NonZeroUsize>,
    /// Seed of every random stream
    #[arg(long, global = true, value_name = "N")]
    pub seed: Option<u64>,
    /// Print one JSON document in the place of words, errors too (docs/commands.md)
    #[arg(long, global = true)]
    pub json: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Scan to plan for a scene that ships or a scene.toml, with every result written
    Run(command::run::Args),
    /// List the scenes that ship
    Scenes(command::scenes::Args),
    /// Extract the surfaces of scans or of a mesh
    Surfaces(command::surfaces::Args),
    /// Find the slopes that a LiDAR sees: start line, orientation, angle
    Slope(command::slope::Args),
    /// Solve a file of independent posture problems
    Posture(command::posture::Args),
    /// Draw posture problems from a seed, to measure solvers with
    PostureSets(command::posture_sets::Args),
    /// Plan from surfaces, scans or a mesh given on the command line, or from a scene.toml
    Plan(Box<command::plan::Args>),
    /// Plan in worlds drawn from seeds, and in given scenes, and tabulate what came of it
    Bench(command::bench::Args),
    /// Plan items by the thousand, as a manifest lists them; goes on where it was
    Batch(command::batch::Args),
    /// Recompute everything that a plan promises and print the margins
    Verify(command::verify::Args),
    /// Hold the stances of a plan and execute its motion in a physics simulation
    Simulate(Box<command::simulate::Args>),
    /// Convert a plan for a controller or a spreadsheet
    Export(command::export::Args),
    /// Write a plan, or surfaces, as one HTML page to look at
    View(command::view::Args),
    /// Look at surfaces, edit and plan on them in a browser on this machine
    Serve(command::serve::Args),
    /// Find where a sensor sits on a robot
    Calibrate(command::calibrate::Args),
    /// Show what was read of a robot
    Robot(command::robot::Args),
    /// Print the resolved settings as TOML
    Config(command::config::Args),
    /// Write the JSON Schemas of the files that are read and written
    Schemas(command::schemas::Args),
    /// Print the completions for a shell
    Completions(command::completions::Args),
    /// Write the manual pages
    Man(command::man::Args),
}

impl Cli {
    /// What flags ask for, as if they stood on the command line.
    ///
    /// # Errors
    /// Flags that are none.
    pub fn of(flags: &[String]) -> Result<Self> {
        let program = std::iter::once("scandent");
        let words = program.chain(flags.iter().map(String::as_str));
        Ok(Self::try_parse_from(words)?)
    }
}

/// Parses the command line, runs the command and reports how it ended.
pub fn main() -> ExitCode {
    // The one thread of a browser's worker is in our pool before anything makes rayon take it into another.
    if cfg!(target_os = "wasi") {
        let _ = threads::pool(None);
    }
    let mut stdout = Words(Some(std::io::stdout()));
    let parsed = Cli::command().try_get_matches();
    let parsed = parsed.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(error) if error.use_stderr() && std::env::args().any(|word| word == "--json") => {
            let error = UsageError(error.to_string().replacen("error: ", "", 1));
            return Told::document("", &mut stdout).end(&Err(error.into()));
        }
        Err(error) => error.exit(),
    };
    tracing_subscriber::fmt()
        .with_env_filter(tracing_subscriber::EnvFilter::from_default_env())
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
    let (name, flags) = asked(&matches);
    let (to_stdout, mut stderr) = (is_result_on_stdout(flags), std::io::stderr());
    let told = match (cli.global.json, to_stdout) {
        (true, _) => Told::document(&name, &mut stdout),
        (false, true) => Told::words(&mut stderr),
        (false, false) => Told::words(&mut stdout),
    };
    let mut told = told.awaited();
    let ended = match cli.global.json && to_stdout {
        true => Err(UsageError(TWO_ON_STDOUT.to_owned()).into()),
        false => dispatch(&cli, &mut told),
    };
    told.end(&ended)
}

/// Why a result and the document do not both go to the standard output.
const TWO_ON_STDOUT: &str = "--json takes the standard output, and so does a result named -: give the result a file with -o";

/// The command in words, as `calibrate camera`, and its own flags.
fn asked(mut matches: &ArgMatches) -> (String, &ArgMatches) {
    let mut names = Vec::new();
    while let Some((name, of)) = matches.subcommand() {
        names.push(name);
        matches = of;
    }
    if names.is_empty() {
        names.push("run");
    }
    (names.join(" "), matches)
}

/// Whether a file of results is `-`.
fn is_result_on_stdout(matches: &ArgMatches) -> bool {
    let is_stdout = |flag: &&str| {
        let values = matches.try_get_raw(flag).ok().flatten();
        values.is_some_and(|mut values| values.any(|value| value == "-"))
    };
    ["output", "view"].iter().any(is_stdout)
}

fn dispatch(cli: &Cli, told: &mut Told) -> Result<Status> {
    let global = &cli.global;
    match &cli.command {
        None => command::run::run(&command::run::Args::default(), global, told),
        Some(Command::Run(args)) => command::run::run(args, global, told),
        Some(Command::Scenes(args)) => command::scenes::run(args, told),
        Some(Command::Surfaces(args)) => command::surfaces::run(args, global, told),
        Some(Command::Slope(args)) => command::slope::run(args, global, told),
        Some(Command::Posture(args)) => command::posture::run(args, global, told),
        Some(Command::PostureSets(args)) => command::posture_sets::run(args, global, told),
        Some(Command::Plan(args)) => command::plan::run(args, global, told),
        Some(Command::Bench(args)) => command::bench::run(args, global, told),
        Some(Command::Batch(args)) => command::batch::run(args, global, told),
        Some(Command::Verify(args)) => command::verify::run(args, global, told),
        Some(Command::Simulate(args)) => command::simulate::run(args, global, told),
        Some(Command::Export(args)) => command::export::run(args, global, told),
        Some(Command::View(args)) => command::view::run(args, global, told),
        Some(Command::Serve(args)) => command::serve::run(args, global, told),
        Some(Command::Calibrate(args)) => command::calibrate::run(args, global, told),
        Some(Command::Robot(args)) => command::robot::run(args, global, told),
        Some(Command::Config(args)) => command::config::run(args, global, told),
        Some(Command::Schemas(args)) => command::schemas::run(args, told),
        Some(Command::Completions(args)) => command::completions::run(args, told),
        Some(Command::Man(args)) => command::man::run(args, told),
    }
}

/// What is said to the user. Once the reader has seen enough, as of `scandent scenes | head -1`, it goes nowhere:
/// results are still written.
struct Words<W>(Option<W>);

impl<W: Write> Words<W> {
    fn say<T>(
        &mut self,
        said: impl FnOnce(&mut W) -> std::io::Result<T>,
        unheard: T,
    ) -> std::io::Result<T> {
        match self.0.as_mut().map(said) {
            None => Ok(unheard),
            Some(Err(error)) if error.kind() == ErrorKind::BrokenPipe => {
                self.0 = None;
                Ok(unheard)
            }
            Some(ended) => ended,
        }
    }
}

impl<W: Write> Write for Words<W> {
    fn write(&mut self, words: &[u8]) -> std::io::Result<usize> {
        self.say(|out| out.write(words), words.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.say(W::flush, ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
