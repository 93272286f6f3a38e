//! `scandent calibrate WHAT`: where a sensor sits on a robot.

pub mod camera;
pub mod lidar;

use anyhow::Result;

use crate::cli::Global;
use crate::status::Status;
use crate::told::Told;

/// Flags of `calibrate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

/// The sensors that can be calibrated.
#[derive(Debug, clap::Subcommand)]
enum What {
    /// A depth camera on a legged robot, from the ground that it sees in several stances
    Camera(Box<camera::Args>),
    /// A LiDAR over the ground: roll, pitch, height, heading by poles, and its rings' range errors
    Lidar(lidar::Args),
}

/// Runs the calibration that was asked for.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    match &args.what {
        What::Camera(args) => camera::run(args, global, told),
        What::Lidar(args) => lidar::run(args, global, told),
    }
}
