//! `scandent calibrate lidar CLOUD…`: where a LiDAR sits over the ground, and its rings' range errors.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use calibration::lidar::{Calibrated, calibrate};

use crate::argument;
use crate::cli::Global;
use crate::config::Config;
use crate::provenance::Inputs;
use crate::slope::calibration_file;
use crate::status::Status;
use crate::told::Told;

/// Flags of `calibrate lidar`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Clouds of one mount over flat ground (pcap, pcapng, PCD, PLY); walls tell of the rings' errors
    #[arg(value_name = "CLOUD", required = true)]
    clouds: Vec<PathBuf>,
    /// Place of a pole that the first cloud shows, in the world: x,y in m (two or more; without them
    /// the sensor's x is the world's)
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    pole: Vec<[f64; 2]>,
    /// Sweep of captures, counted from 0 (default: the first whole one)
    #[arg(long, value_name = "N")]
    sweep: Option<usize>,
    /// Where the calibration goes
    #[arg(short, long, value_name = "FILE.toml", default_value = "lidar.toml")]
    output: PathBuf,
}

fn point(text: &str) -> Result<[f64; 2], String> {
    let values = argument::numbers(text, &[2])?;
    Ok([values[0], values[1]])
}

/// Calibrates, prints the result and writes it.
///
/// # Errors
/// A cloud that cannot be read or used, with its name and the cause; poles that are not found.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let mut inputs = Inputs::default();
    let mut clouds = Vec::new();
    for path in &args.clouds {
        let bytes = inputs.read("cloud", path)?;
        let read = perception::parse_lidar(path, &bytes, args.sweep)?;
        for note in &read.notes {
            told.note(format_args!("{}: {note}", path.display()))?;
        }
        clouds.push(read.cloud);
    }
    let (mount, chain) = (&config.calibration.lidar, &config.perception.lidar);
    let calibrated = calibrate(&clouds, &args.pole, mount, chain).map_err(|error| {
        // A cloud's error names its file, any other the first cloud's.
        let number = match &error {
            calibration::Error::Cloud { number, .. } => *number,
            _ => 0,
        };
        let name = args.clouds.get(number).map(|p| p.display().to_string());
        anyhow!(error).context(name.unwrap_or_default())
    })?;
    print(&calibrated, &args.pole, told)?;
    calibration_file::write(&args.output, &calibrated.calibration).context("the calibration")?;
    told.fact("calibration", &calibrated.calibration)?;
    told.written(&args.output)?;
    Ok(Status::Done)
}

fn print(calibrated: &Calibrated, given: &[[f64; 2]], told: &mut Told) -> Result<()> {
    let (calibration, adjustment) = (&calibrated.calibration, &calibrated.adjustment);
    let (roll, pitch, yaw) = calibration.X_WV().rotation.euler_angles();
    let sigma = |i: usize| calibration.covariance[i][i].max(0.0).sqrt();
    for (name, angle, i) in [("roll", roll, 0), ("pitch", pitch, 1)] {
        let (angle, spread) = (angle.to_degrees(), sigma(i).to_degrees());
        writeln!(told, "{name:<8} {angle:8.3}° ± {spread:.3}°")?;
    }
    match &calibrated.drift {
        Some(drift) => {
            let (angle, spread) = (yaw.to_degrees(), drift.sigma_rad.to_degrees());
            writeln!(told, "heading  {angle:8.3}° ± {spread:.3}°")?;
        }
        None => writeln!(told, "heading  unknown: no pole given; x is the sensor's")?,
    }
    let (height_m, spread_mm) = (calibration.position_m[2], 1e3 * sigma(3));
    writeln!(told, "height   {height_m:8.4} m ± {spread_mm:.1} mm")?;
    if let Some(drift) = &calibrated.drift {
        for m in &drift.matches {
            let [x, y] = given[m.given];
            let off_mm = 1e3 * m.residual_m;
            writeln!(told, "pole at ({x:.3}, {y:.3}): found, {off_mm:.1} mm off")?;
        }
    }
    let [before, after] = adjustment.rms_m.map(|rms| 1e3 * rms);
    let rms = format!("rms {before:.2} mm, {after:.2} mm with the rings' errors");
    writeln!(told, "{} planes, {rms}", adjustment.planes)?;
    let (biases, sigmas) = (&adjustment.ring_bias_m, &adjustment.ring_bias_sigma_m);
    for (ring, (bias, sigma)) in biases.iter().zip(sigmas).enumerate() {
        let (bias, sigma) = (1e3 * bias, 1e3 * sigma);
        writeln!(told, "ring {ring:>2}  {bias:+6.1} ± {sigma:.1} mm")?;
    }
    Ok(())
}
