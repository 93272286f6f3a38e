//! The environment on the command line: surfaces, scans or a mesh.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use scenes::scene_file::ScanSource;

use crate::argument::{self, SensorFlag};
use crate::scene::Environment;
use crate::status::UsageError;

/// How scans were taken.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ScanFlags {
    /// Sensor of the scans: NAME, fx,fy,cx,cy[,depth_scale_m] or NAME:fx,fy,cx,cy[,depth_scale_m]
    #[arg(long, value_name = "SENSOR", value_parser = argument::sensor, allow_hyphen_values = true)]
    pub sensor: Option<SensorFlag>,
    /// Pose of each scan's optical frame (x right, y down, z forward) in the world, in the order of
    /// the scans: x,y,z,qx,qy,qz,qw or x,y,z,roll,pitch,yaw; default: what the file states
    #[arg(long, value_name = "POSE", value_parser = argument::pose, allow_hyphen_values = true)]
    pub pose: Vec<Isometry3<f64>>,
    /// Where the sensor stood in the frame of clouds that were moved after the scan: x,y,z in m. A
    /// --pose is then that of the clouds' frame
    #[arg(long, value_name = "X,Y,Z", value_parser = argument::place, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// Calibration of the VLP-16 that took the scans, as `calibrate lidar` writes it; a --pose is then
    /// that of the calibration's world
    #[arg(long, value_name = "FILE.toml")]
    pub calibration: Option<PathBuf>,
}

impl ScanFlags {
    /// The scans, with sensor and pose.
    ///
    /// # Errors
    /// [`UsageError`] when there are poses, but not one a scan.
    pub fn scans(&self, files: &[PathBuf]) -> Result<Environment, UsageError> {
        if !self.pose.is_empty() && self.pose.len() != files.len() {
            return Err(UsageError(format!(
                "{} --pose for {} scans; give one a scan, or none",
                self.pose.len(),
                files.len()
            )));
        }
        let scan = |(i, file): (usize, &PathBuf)| {
            let pose = self
                .pose
                .get(i)
                .copied()
                .unwrap_or_else(Isometry3::identity);
            let mut source = source(file, self.sensor.as_ref(), &pose);
            source.eye_m = self.eye;
            if let Some(path) = &self.calibration {
                source.calibration = Some(path.display().to_string());
                source
                    .sensor
                    .get_or_insert_with(|| perception::lidar::SENSOR.to_owned());
            }
            source
        };
        Ok(Environment::Scans(
            files.iter().enumerate().map(scan).collect(),
        ))
    }
}

fn source(file: &Path, sensor: Option<&SensorFlag>, pose: &Isometry3<f64>) -> ScanSource {
    let is_image = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let name = file.display().to_string();
    let flag = sensor.cloned().unwrap_or_default();
    let value = |i: usize| flag.pinhole.map(|values| values[i]);
    ScanSource {
        depth: is_image.then(|| name.clone()),
        cloud: (!is_image).then_some(name),
        sensor: flag.name.clone(),
        fx: value(0),
        fy: value(1),
        cx: value(2),
        cy: value(3),
        depth_scale_m: flag.depth_scale_m,
        eye_m: None,
        calibration: None,
        position_m: Some(pose.translation.vector.into()),
        quat_xyzw: Some(pose.rotation.coords.into()),
        extrinsics: None,
    }
}
