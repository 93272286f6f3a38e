//! Plans in the formats of others.
//!
//! | format | for |
//! |---|---|
//! | `mcc-yaml` | isri-aist/MultiContactController: contact, centroidal and posture lists |
//! | `json` | any controller: contacts with times, poses, wrenches; postures |
//! | `csv` | spreadsheets and plots: one row a stance |
//! | `motion-csv` | plots and players of trajectories: one row a sample of the motion |
//! | `npz` | numpy: plan and motion as arrays |
//! | `mcap` | Foxglove and other players of recordings |
//!
//! Times are those of the plan's motion; where there is none, the durations of [`Config`].

mod config;
mod csv;
pub use csv::quoted;
pub mod frames;
mod json;
mod limbs;
mod mcap;
mod mcc_yaml;
pub use mcc_yaml::balls_touched;
mod motion_csv;
mod npz;
mod swing;
pub mod timeline;

pub use config::Config;

use anyhow::{Context, Result};
use plan::{Motion, Plan};
use robot_model::Robot;

/// What a plan can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// The lists that isri-aist/MultiContactController reads
    MccYaml,
    /// Contacts with times, poses and wrenches, and postures
    Json,
    /// One row a stance
    Csv,
    /// One row a sample of the motion
    MotionCsv,
    /// Plan and motion as arrays of numpy
    Npz,
    /// Plan and motion as a recording that Foxglove plays
    Mcap,
}

impl std::str::FromStr for Format {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        clap::ValueEnum::from_str(name, false)
    }
}

/// The plan in the format, with the times of its motion: text, but for [`Format::Npz`] and [`Format::Mcap`].
///
/// # Errors
/// A plan of another robot or with values that are no numbers; settings that make no sense; two
/// patches with one limb's name; a form of the motion of a plan without one.
pub fn export(
    plan: &Plan,
    motion: Option<&Motion>,
    robot: &Robot,
    format: Format,
    config: &Config,
) -> Result<Vec<u8>> {
    config.validate()?;
    frames::check(plan, robot)?;
    let moves = || motion.context("the plan has no motion");
    let text = match format {
        Format::MccYaml => mcc_yaml::write(plan, motion, robot, config),
        Format::Json => json::write(plan, motion, robot, config),
        Format::Csv => csv::write(plan, motion, robot, config),
        Format::MotionCsv => motion_csv::write(moves()?, robot),
        Format::Mcap => return mcap::write(plan, moves()?, robot),
        Format::Npz => return npz::write(plan, moves()?, robot),
    };
    text.map(String::into_bytes)
}
