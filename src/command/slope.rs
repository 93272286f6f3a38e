//! `scandent slope CLOUD`: the slopes that a LiDAR sees, where they begin and how they rise, and what
//! else stands around.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use nalgebra::Isometry3;
use perception::lidar;

use crate::argument;
use crate::cli::Global;
use crate::config::Config;
use crate::output;
use crate::provenance::Inputs;
use crate::slope::calibration_file;
use crate::slope::record::{
    GroundRecord, SLOPE_FORMAT, SlopeFile, SlopeRecord, ThingRecord, WallRecord,
};
use crate::status::Status;
use crate::template::render;
use crate::told::Told;

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
    /// Where the sensor stood in the frame of a cloud that was moved after the scan: x,y,z in m; the
    /// cloud is taken to have the sensor's axes
    #[arg(long, value_name = "X,Y,Z", value_parser = argument::place, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// Headings to give the stepping angle for, degrees from x towards y
    #[arg(long, value_name = "DEG,…", value_delimiter = ',', default_value = "0")]
    #[arg(allow_hyphen_values = true)]
    heading: Vec<f64>,
    /// Where the description goes (without it it is only printed)
    #[arg(short, long, value_name = "SLOPE.json")]
    output: Option<PathBuf>,
}

/// Finds the slopes, prints them and writes them.
///
/// # Errors
/// A file that cannot be read, used or written, with its name and the cause.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let calibration = args.calibration.as_ref();
    let calibration = calibration.map(|path| calibration_file::read(path, &mut inputs));
    let calibration = calibration.transpose()?;
    let bytes = inputs.read("cloud", &args.cloud)?;
    let read = perception::parse_lidar(&args.cloud, &bytes, args.sweep)?;
    let name = args.cloud.display();
    for note in &read.notes {
        told.note(format_args!("{name}: {note}"))?;
    }
    let cloud = match args.eye {
        Some(eye_m) => read.cloud.seen_from(eye_m),
        None => read.cloud,
    };
    let seen = lidar::segment_cloud(&cloud, calibration.as_ref(), &config.perception.lidar)
        .with_context(|| name.to_string())?;
    let found = |scan: &lidar::SlopeScan| -> Vec<SlopeRecord> {
        let record = |slope| SlopeRecord::of(slope, &args.heading);
        scan.slopes.iter().map(record).collect()
    };
    let slopes = seen.scan.as_ref().map(found).unwrap_or_default();
    let walls: Vec<WallRecord> = seen.around.walls.iter().map(WallRecord::of).collect();
    let things: Vec<ThingRecord> = seen.around.things.iter().map(ThingRecord::of).collect();
    let scan = seen.scan.as_ref();
    let pose = scan.map_or_else(Isometry3::identity, |scan| scan.X_WV);
    let mut faces = scan.map(lidar::SlopeScan::faces).unwrap_or_default();
    faces.extend(seen.around.faces().cloned());
    let file = SlopeFile {
        format: SLOPE_FORMAT,
        program: crate::program(),
        inputs: inputs.into_list(),
        config: serde_json::to_value(&config.perception.lidar).context("the settings")?,
        calibrated: calibration.is_some(),
        eye_m: args.eye,
        sensor_position_m: pose.translation.vector.into(),
        sensor_quat_xyzw: pose.rotation.coords.into(),
        counts: seen.counts,
        ground: scan.map(GroundRecord::of),
        slopes,
        walls,
        things,
        faces,
    };
    let text = render("slope.txt", include_str!("../slope/slope.txt"), &file)?;
    told.write_all(text.as_bytes())?;
    told.fact("slope", &file)?;
    if let Some(path) = &args.output {
        output::write_json(path, &file)?;
        told.written(path)?;
    }
    Ok(Status::Done)
}
