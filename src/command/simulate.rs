//! `scandent simulate PLAN.json`: stances held and the motion executed in MuJoCo.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
pub use simulation::MUJOCO_VERSION;

use crate::argument;
use crate::cli::{Cli, Command, Global};
use crate::plan_file::PlanRobotFlags;
use crate::provenance::will_read;
use crate::robot_files::Robots;
use crate::status::Status;
use crate::told::Told;
use crate::{interrupt, output, results};

/// Flags of `simulate`.
#[derive(Debug, clap::Args)]
#[cfg_attr(not(feature = "mujoco"), allow(dead_code))]
pub struct Args {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    #[command(flatten)]
    robot: PlanRobotFlags,
    /// Only hold the stances, plain and pushed
    #[arg(long, conflicts_with = "execute")]
    hold: bool,
    /// Only execute the motion
    #[arg(long)]
    execute: bool,
    /// The motion (default: motion.json beside the plan, where there is one)
    #[arg(long, value_name = "MOTION.json")]
    motion: Option<PathBuf>,
    /// The world that is simulated
    #[arg(long, value_enum, default_value_t)]
    world: World,
    /// A mesh (STL, OBJ, PLY, DAE, glTF) of what really stands there, in W, metres
    #[arg(long, value_name = "MESH", value_parser = argument::file, conflicts_with = "world")]
    mesh: Option<PathBuf>,
    /// Execute the motion perturbed, too
    #[arg(long, value_enum, value_delimiter = ',', value_name = "KIND")]
    perturb: Vec<Perturb>,
    /// How many perturbed runs
    #[arg(long, value_name = "N", default_value_t = 8)]
    runs: u64,
    /// Where the results go (default: simulation.json beside the plan); the trace goes beside it
    #[arg(short, long, value_name = "FILE.json")]
    output: Option<PathBuf>,
    /// Draw the executed motion into a folder, 25 pictures a second (needs the feature `render`)
    #[arg(long, value_name = "DIR", value_parser = argument::folder)]
    frames: Option<PathBuf>,
    /// Make a video of the executed motion (needs the feature `render`, and ffmpeg)
    #[arg(long, value_name = "FILE.mp4", conflicts_with = "hold")]
    video: Option<PathBuf>,
}

/// Which bodies stand in the simulated world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum World {
    /// What really stands there where it is known (scenes that ship), else as planned
    #[default]
    Known,
    /// What really stands there; an error where it is not known
    True,
    /// The bodies behind the plan's surfaces, and its obstacles
    Planned,
}

/// What is perturbed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Perturb {
    /// Everything
    All,
    /// Less friction
    Friction,
    /// Another mass of the robot
    Mass,
    /// Bodies elsewhere than planned
    Surfaces,
    /// Pushes on the base
    Pushes,
    /// Noise and delay of what the controller is told
    Sensing,
}

/// What a simulation showed.
#[derive(Debug)]
pub struct Simulated {
    /// The bytes of its `simulation.json`.
    pub json: Vec<u8>,
    /// The trace of the executed motion; nothing where none was.
    pub trace: Option<String>,
    /// The robot's name.
    pub robot: String,
    /// The criteria that do not hold, in words.
    pub failures: Vec<String>,
}

/// Simulates, prints the table of criteria and writes the results; ends with [`Status::NotExecuted`] where a
/// criterion does not hold.
///
/// # Errors
/// As [`simulate`]; a file that cannot be written.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let beside = || args.plan.with_file_name(results::SIMULATION);
    let output = args.output.clone().unwrap_or_else(beside);
    will_read(&args.plan);
    output::check(&output)?;
    let simulated = simulate(args, global, interrupt::listen(), &Robots::default(), told)?;
    if let (Some(trace), false) = (&simulated.trace, output == Path::new("-")) {
        let path = output.with_extension("csv");
        output::write(&path, trace.as_bytes())?;
        told.written(&path)?;
    }
    output::write(&output, &simulated.json)?;
    for failure in &simulated.failures {
        told.fails(failure);
    }
    told.written_fact("simulation", &simulated.json)?;
    told.written(&output)?;
    Ok(match simulated.failures.is_empty() {
        true => Status::Done,
        false => Status::NotExecuted,
    })
}

/// The flags and the settings of a command line of `simulate`.
///
/// # Errors
/// Flags that are none.
pub fn asked_by(flags: &[String]) -> Result<(Box<Args>, Global)> {
    let cli = Cli::of(flags)?;
    match cli.command {
        Some(Command::Simulate(args)) => Ok((args, cli.global)),
        _ => bail!("no flags of `simulate`"),
    }
}

/// Simulates; Ctrl-C or whoever raises `cancel` stops it between two runs.
///
/// # Errors
/// A program without the feature `mujoco`; a plan, a motion or a robot that cannot be read or simulated; that
/// it was stopped.
#[cfg(not(feature = "mujoco"))]
pub fn simulate(
    _: &Args,
    _: &Global,
    _: &std::sync::atomic::AtomicBool,
    _: &Robots,
    _: &mut dyn std::io::Write,
) -> Result<Simulated> {
    without()
}

/// The robot of a plan in its world as a model of MuJoCo's, with stiff servos at the joints.
///
/// # Errors
/// A program without the feature `mujoco`; a plan or a robot that cannot be read or simulated.
#[cfg(not(feature = "mujoco"))]
pub fn model(_: &Path) -> Result<String> {
    without()
}

#[cfg(not(feature = "mujoco"))]
fn without<T>() -> Result<T> {
    bail!(
        "this program was built without the physics simulation. In a checkout of the source:\n  \
         scripts/fetch-mujoco                        (fetches MuJoCo {} from PyPI, 10 MB)\n  \
         cargo build --release --features mujoco     (mujoco,render for pictures)",
        MUJOCO_VERSION
    )
}

#[cfg(feature = "mujoco")]
pub use simulated::{model, simulate};

#[cfg(feature = "mujoco")]
mod simulated;
