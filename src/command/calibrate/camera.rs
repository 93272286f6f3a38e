//! `scandent calibrate camera`: where a depth camera sits on a legged robot.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use calibration::camera::NextPose;
use calibration::camera::design::REACH_M;
use nalgebra::Isometry3;

use crate::argument::{self, SensorFlag};
use crate::cli::Global;
use crate::config::Config;
use crate::extrinsics::feet::Feet;
use crate::extrinsics::file::Extrinsics;
use crate::extrinsics::identify;
use crate::extrinsics::mistakes;
use crate::extrinsics::next;
use crate::extrinsics::report::Report;
use crate::extrinsics::stances_file::{self, StanceRow};
use crate::extrinsics::verdict;
use crate::output::Folder;
use crate::provenance::{self, Inputs};
use crate::report::Stages;
use crate::robot_files::RobotFiles;
use crate::status::Status;
use crate::told::Told;

/// Endings of the frames that are looked for.
const ENDINGS: [&str; 3] = ["png", "pcd", "ply"];
/// The sensor where only its intrinsics are given.
const UNNAMED: &str = "generic";

/// What is written.
const RESULTS: [&str; 3] = ["camera.toml", "stances.csv", "report.html"];

/// Flags of `calibrate camera`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    robot: RobotFiles,
    /// The stances: CSV with a column a joint (or height_m, roll_rad, pitch_rad), and `frame`
    #[arg(long, value_name = "POSES.csv")]
    poses: PathBuf,
    /// Folder of the frames; without a column `frame` in the table they go by their names' order
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// Sensor of the frames: NAME, fx,fy,cx,cy[,depth_scale_m] or NAME:fx,fy,cx,cy[,depth_scale_m]
    #[arg(long, value_name = "SENSOR", value_parser = argument::sensor, default_value = "kinect_v1")]
    sensor: SensorFlag,
    /// The link that the sensor is on (default: the floating base)
    #[arg(long, value_name = "LINK")]
    link: Option<String>,
    /// Patches that stand on the ground (default: all with the role foot)
    #[arg(long, value_name = "PATCH,…", value_delimiter = ',')]
    feet: Vec<String>,
    /// Folder of the results
    #[arg(short, long, value_name = "FOLDER", value_parser = argument::folder, default_value = "out/camera")]
    output: PathBuf,
}

/// Identifies the mount, prints it and writes `camera.toml`, `stances.csv` and `report.html`.
///
/// # Errors
/// A file that cannot be read, with its name and the cause; stances that do not determine the
/// mount, by name.
pub fn run(args: &Args, global: &Global, told: &mut Told) -> Result<Status> {
    let config = Config::layered(None, global)?;
    let calibration = &config.calibration;
    calibration.check()?;
    let mut inputs = Inputs::default();
    let mut stages = Stages::default();

    // Robot and table → where the feet say that the ground is.
    let robot = args.robot.load(&config.robot_model, &mut inputs)?;
    let feet = Feet::of(&robot, &args.feet, args.link.as_deref())?;
    let name = args.poses.display().to_string();
    let text = inputs.text("poses", &args.poses)?;
    let joints: Vec<&str> = robot.joint_names().collect();
    let rows = stances_file::parse(&text, &joints).with_context(|| name.clone())?;
    let work = || {
        let found = identify::stances(&robot, &feet, &rows);
        found.map_err(|error| mistakes::of_feet(&robot, &feet, &rows, error))
    };
    let stances = stages
        .measure("stances", work)
        .with_context(|| name.clone())?;

    // Frames → where the sensor saw it.
    let frames = frames(&args.frames, &rows).with_context(|| name.clone())?;
    let sensor = args.sensor.read(&mut inputs)?.options(UNNAMED);
    frames.iter().for_each(|frame| provenance::will_read(frame));
    let results = Folder::new(&args.output, RESULTS)?;
    let measured = told.during("looking for the ground in the frames", || {
        identify::measure(
            &stances.poses,
            &frames,
            &sensor,
            calibration,
            &mut stages,
            &mut inputs,
        )
    })?;

    // Both → the mount.
    let mistake = || mistakes::of_stances(&robot, &feet, &rows, &measured, calibration);
    if let Some(mistake) = stages.measure("checks", mistake) {
        bail!("{name}: {mistake}");
    }
    let mount = stages.measure("identification", || identify::mount(&measured, calibration));
    let checked = mount.map_err(|error| match error.downcast_ref() {
        Some(calibration::Error::NotConverged { .. }) => {
            error.context(mistakes::unexplained(&measured))
        }
        _ => error,
    })?;
    let doubts = verdict::doubts(&checked, &measured);
    let noticed = verdict::noticed(&checked.sensor, &measured);
    let found = checked.found;
    let footholds = stances.footholds.as_ref();
    let view = measured.first().and_then(|one| one.view.as_ref());
    let next = stages.measure("next stance", || {
        next::next(
            &robot,
            &feet,
            footholds,
            view,
            &measured,
            &found,
            calibration,
        )
    });
    let advice = next.map(|(pose, next)| advice(&pose, &next, REACH_M));
    let written = Extrinsics::of(&found, &robot.name, &feet.link, inputs.into_list());
    let report = Report::new(
        &measured,
        &found,
        &written,
        advice.as_deref(),
        &doubts,
        &noticed,
    )?;
    write!(told, "{}", report.text()?)?;
    if let Some(advice) = &advice {
        writeln!(told, "{advice}")?;
    }

    results.write("camera.toml", written.to_toml()?.as_bytes())?;
    results.write("stances.csv", report.csv()?.as_bytes())?;
    results.write("report.html", report.html()?.as_bytes())?;
    results.publish()?;
    let (count, all_s) = (measured.len(), 1e-3 * stages.ms.values().sum::<f64>());
    writeln!(told, "{count} frames in {all_s:.2} s: {}", stages.text())?;
    told.fact("report", &report)?;
    let [toml, csv, page] = RESULTS.map(|name| args.output.join(name));
    told.written(&toml)?;
    told.written(&csv)?;
    told.open(page.display())?;
    Ok(Status::Done)
}

/// The stance to add, in words.
fn advice(pose: &Isometry3<f64>, next: &NextPose, reach_m: f64) -> String {
    let (roll, pitch, _) = pose.rotation.euler_angles();
    let [before, after] = next.error_m.map(|error| 1e3 * error);
    format!(
        "the stance that would help most: roll {:.0}°, pitch {:.0}°, {:.3} m high; a point seen {reach_m} m \
         ahead would then be known to {after:.2} mm, now {before:.2} mm",
        roll.to_degrees(),
        pitch.to_degrees(),
        pose.translation.z
    )
}

/// The frame of every stance: the named ones, or those of the folder by name.
fn frames(folder: &Path, rows: &[StanceRow]) -> Result<Vec<PathBuf>> {
    if rows.iter().all(|row| row.frame.is_some()) {
        let names = rows.iter().flat_map(|row| &row.frame);
        return Ok(names.map(|name| folder.join(name)).collect());
    }
    let mut found = Vec::new();
    let unreadable = || format!("{}: cannot be read", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let path = entry.with_context(unreadable)?.path();
        let ending = path.extension().and_then(|e| e.to_str());
        if ending.is_some_and(|e| ENDINGS.iter().any(|known| e.eq_ignore_ascii_case(known))) {
            found.push(path);
        }
    }
    found.sort();
    if found.len() != rows.len() {
        bail!(
            "{} stances, but {} frames ({}) in {}; name them in a column \"frame\"",
            rows.len(),
            found.len(),
            ENDINGS.join(", "),
            folder.display()
        );
    }
    Ok(found)
}
