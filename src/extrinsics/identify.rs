//! Stances and frames → the mount of the sensor.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use calibration::Config;
use calibration::camera::{Checked, PlanePair, identify_checked};
use calibration::ground::{Ground, ground};
use calibration::stance::footprint;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use perception::{Intrinsics, Noise, Scan, SensorOptions};
use robot_model::{Configuration, Robot};

use super::feet::Feet;
use super::stances_file::{Reading, StanceRow};
use crate::provenance::Inputs;
use crate::report::Stages;

/// The sensor's image and noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Columns and rows.
    pub size_px: (usize, usize),
    /// Pinhole model.
    pub intrinsics: Intrinsics,
    /// Noise model.
    pub noise: Noise,
}

impl View {
    /// The view of a scan that has an image.
    pub fn of(scan: &Scan) -> Option<Self> {
        scan.depth.as_ref().map(|image| Self {
            size_px: (image.width, image.height),
            intrinsics: image.intrinsics,
            noise: scan.noise,
        })
    }
}

/// One stance, measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Name of the frame.
    pub frame: String,
    /// Pose of the link R over the ground.
    pub X_GR: Isometry3<f64>,
    /// Root mean square by which the feet miss their places, m; 0 for a pose that was given.
    pub foot_error_m: f64,
    /// The ground that the sensor saw.
    pub ground: Ground,
    /// Both planes.
    pub pair: PlanePair,
    /// The sensor's image, where the frame is one.
    pub view: Option<View>,
}

/// Where the feet stand, for stances that are known by joint readings.
pub struct Footholds {
    /// Places of the feet's points in G, m.
    pub feet_G: Vec<Point3<f64>>,
    /// A configuration to start from.
    pub near: Configuration,
}

/// The stances over the ground.
pub struct Stances {
    /// Pose of the link R in G of each, and root mean square by which the feet miss their places,
    /// m; 0 for a pose that was given.
    pub poses: Vec<(Isometry3<f64>, f64)>,
    /// Where the feet stand, where joints were read.
    pub footholds: Option<Footholds>,
}

/// The poses of the link over the ground.
///
/// # Errors
/// Readings that miss joints; feet that do not fit.
pub fn stances(robot: &Robot, feet: &Feet, rows: &[StanceRow]) -> Result<Stances> {
    let mut postures = Vec::new();
    let mut near = None;
    let mut given = Vec::new();
    for row in rows {
        match &row.reading {
            Reading::Joints(values) => {
                let line = || format!("line {}", row.line);
                let configuration = feet.configuration(robot, values).with_context(line)?;
                postures.push(feet.in_R(robot, &configuration).with_context(line)?);
                near.get_or_insert(configuration);
            }
            Reading::Pose([height_m, roll_rad, pitch_rad]) => given.push(Isometry3::from_parts(
                Vector3::new(0.0, 0.0, *height_m).into(),
                UnitQuaternion::from_euler_angles(*roll_rad, *pitch_rad, 0.0),
            )),
        }
    }
    let Some(near) = near else {
        return Ok(Stances {
            poses: given.into_iter().map(|pose| (pose, 0.0)).collect(),
            footholds: None,
        });
    };
    let found = footprint(&postures, &feet.heights_m(robot))?;
    Ok(Stances {
        poses: found.X_GR.into_iter().zip(found.error_m).collect(),
        footholds: Some(Footholds {
            feet_G: found.feet_G,
            near,
        }),
    })
}

/// The ground of every stance, as the feet and as the frames have it.
///
/// # Errors
/// A frame that cannot be read or shows no ground, with its name.
pub fn measure(
    poses: &[(Isometry3<f64>, f64)],
    frames: &[impl AsRef<Path>],
    sensor: &SensorOptions,
    config: &Config,
    stages: &mut Stages,
    inputs: &mut Inputs,
) -> Result<Vec<Measured>> {
    let measured = poses
        .iter()
        .zip(frames)
        .map(|((X_GR, foot_error_m), frame)| {
            let path = frame.as_ref();
            let name = path.display().to_string();
            let bytes = stages.measure("files", || inputs.read("frame", path))?;
            let scan =
                stages.measure("decoding", || perception::parse_scan(path, &bytes, sensor))?;
            let seen = stages.measure("planes", || ground(&scan, &config.ground));
            let seen = seen.with_context(|| name.clone())?;
            let file = path.file_name();
            Ok(Measured {
                frame: file.map_or(name, |file| file.to_string_lossy().into_owned()),
                X_GR: *X_GR,
                foot_error_m: *foot_error_m,
                pair: PlanePair {
                    robot: config.camera.robot_plane(X_GR),
                    sensor: seen.plane,
                    common: seen.common.clone(),
                },
                ground: seen,
                view: View::of(&scan),
            })
        });
    measured.collect()
}

/// The mount from what was measured.
///
/// # Errors
/// As [`calibration::camera::identify_checked`].
pub fn mount(measured: &[Measured], config: &Config) -> Result<Checked> {
    let pairs: Vec<PlanePair> = measured.iter().map(|one| one.pair.clone()).collect();
    identify_checked(&pairs, &config.camera).map_err(|error| anyhow!(error))
}
