//! `scandent slope CLOUD`: the slopes that a LiDAR sees, where they begin and how they rise.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use perception::lidar;

use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::provenance::Inputs;
use crate::slope::record::{GroundRecord, SLOPE_FORMAT, SlopeFile, SlopeRecord};
use crate::slope::{calibration_file, table};
use crate::status::Status;

/// Flags of `slope`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The cloud of a VLP-16: a capture of its packets (pcap, pcapng), PCD or PLY
    #[arg(value_name = "CLOUD")]
    cloud: PathBuf,
    /// The sensor's calibration, as `calibrate lidar` writes it; without it the ground gives the
    /// world's axes
    #[arg(long, value_name = "FILE.toml")]
    calibration: Option<PathBuf>,
    /// Sweep of a capture, counted from 0 (default: the first whole one)
    #[arg(long, value_name = "N")]
    sweep: Option<usize>,
    /// Headings to give the stepping angle for, degrees from x towards y
    #[arg(
        long,
        value_name = "DEG,…",
        value_delimiter = ',',
        default_value = "0",
        allow_hyphen_values = true
    )]
    heading: Vec<f64>,
    /// Where the description goes (without it it is only printed)
    #[arg(short, long, value_name = "SLOPE.json")]
    output: Option<PathBuf>,
}

/// Finds the slopes, prints them and writes them.
///
/// # Errors
/// A file that cannot be read, used or written, with its name and the cause.
pub fn run(args: &Args, global: &Global, out: &mut dyn Write) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let calibration = match &args.calibration {
        Some(path) => Some(calibration_file::read(path, &mut inputs)?),
        None => None,
    };
    let bytes = inputs.read("cloud", &args.cloud)?;
    let read = perception::parse_lidar(&args.cloud, &bytes, args.sweep)?;
    let name = args.cloud.display();
    for note in &read.notes {
        writeln!(out, "{name}: {note}")?;
    }
    let scan = lidar::detect(&read.cloud, calibration.as_ref(), &config.perception.lidar)
        .with_context(|| name.to_string())?;
    let slopes: Vec<SlopeRecord> = scan
        .slopes
        .iter()
        .map(|slope| SlopeRecord::of(slope, &args.heading))
        .collect();
    table::print(&scan, &slopes, out)?;
    if let Some(path) = &args.output {
        let pose = scan.X_WV;
        let file = SlopeFile {
            format: SLOPE_FORMAT,
            program: crate::program(),
            inputs: inputs.into_list(),
            config: serde_json::to_value(&config.perception.lidar).context("the settings")?,
            calibrated: calibration.is_some(),
            sensor_position_m: pose.translation.vector.into(),
            sensor_quat_xyzw: pose.rotation.coords.into(),
            counts: scan.counts,
            ground: GroundRecord::of(&scan),
            slopes,
            surfaces: scan.surfaces(),
        };
        output::write_json(path, &file)?;
        writeln!(out, "written: {}", path.display())?;
    }
    Ok(Status::Done)
}
