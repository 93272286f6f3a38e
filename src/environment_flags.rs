//! The environment on the command line: surfaces, scans or a mesh.

use std::path::{Path, PathBuf};

use anyhow::Result;
use nalgebra::Isometry3;
use perception::is_depth_image;
use scenes::scene_file::ScanSource;

use crate::argument::{self, PoseFlag, SensorFlag, Times};
use crate::provenance::{self, Inputs};
use crate::scene::Environment;
use crate::status::UsageError;
use crate::{imu, mistakes};

/// How scans were taken.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct ScanFlags {
    /// Sensor of the scans: NAME, fx,fy,cx,cy or NAME:fx,fy,cx,cy, which may end in ,depth_scale_m; in the place of
    /// the numbers a file of Open3D's intrinsics (.json)
    #[arg(long, value_name = "SENSOR", value_parser = argument::sensor, allow_hyphen_values = true)]
    pub sensor: Option<SensorFlag>,
    /// Pose of each scan's optical frame (x right, y down, z forward) in the world, in the order of
    /// the scans: x,y,z,qx,qy,qz,qw or x,y,z,roll,pitch,yaw; or by a trajectory: FILE@TIME (TUM RGB-D),
    /// FILE.log@NUMBER (Open3D); default: what the file states
    #[arg(long, value_name = "POSE", value_parser = argument::sensor_pose, allow_hyphen_values = true)]
    pub pose: Vec<PoseFlag>,
    /// Take the pose of each scan from the ground that it shows: the world's origin is on the ground below
    /// the sensor, x ahead. With a --pose a scan: that of the first, the others keeping their places to it
    #[arg(long)]
    pub level: bool,
    /// Which way is up in the sensor's optical frame, as an accelerometer at rest in it measures (any
    /// unit), for --level
    #[arg(long, value_name = "X,Y,Z", value_parser = argument::place, allow_hyphen_values = true, requires = "level")]
    pub up: Option<[f64; 3]>,
    /// The file of an IMU at rest with the sensor (x forward, y left, z up), of which the accelerations say
    /// which way is up, for --level: names of columns, Acc[0-2] among them, before the numbers
    #[arg(long, value_name = "FILE", requires = "level", conflicts_with = "up")]
    pub imu: Option<PathBuf>,
    /// Where the sensor stood in the frame of clouds that were moved after the scan: x,y,z in m. A
    /// --pose is then that of the clouds' frame
    #[arg(long, value_name = "X,Y,Z", value_parser = argument::place, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// The topic of a ROS 2 bag (MCAP) that is the scan; default: its only one of depth images, else of clouds. Of an
    /// E57 file its scan, by name or number from 0; of an npz its array
    #[arg(long, value_name = "TOPIC")]
    pub topic: Option<String>,
    /// Time of the bag's message, s after the bag's first message or by its clock; again for several of one
    /// bag's messages, or as FROM:TO:EVERY; or one a scan
    #[arg(long, value_name = "TIME", value_parser = argument::times)]
    pub at: Vec<Times>,
    /// The frame of the bag's tf that is the world; default: map, odom or world
    #[arg(long, value_name = "FRAME", conflicts_with_all = ["pose", "level"])]
    pub frame: Option<String>,
    /// Calibration of the VLP-16 that took the scans, as `calibrate lidar` writes it; a --pose is then
    /// that of the calibration's world
    #[arg(long, value_name = "FILE.toml")]
    pub calibration: Option<PathBuf>,
}

impl ScanFlags {
    /// The files beside the scans that they name.
    pub fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let poses = self.pose.iter_mut().filter_map(|pose| match pose {
            PoseFlag::Stated(_) => None,
            PoseFlag::Of(file, _) => Some(file),
        });
        let camera = self.sensor.iter_mut().flat_map(|sensor| &mut sensor.file);
        poses
            .chain(camera)
            .chain(&mut self.imu)
            .chain(&mut self.calibration)
    }

    /// The scans, with sensor and pose; the files that state these are noted among the inputs.
    ///
    /// # Errors
    /// [`UsageError`] when there are poses, but not one a scan; files that do not state them.
    pub fn scans(&self, files: &[PathBuf], inputs: &mut Inputs) -> Result<Environment> {
        let at: Vec<f64> = self.at.iter().flat_map(|t| t.0.iter().copied()).collect();
        // Several messages of one bag are as many scans.
        let messages = if let [bag] = files {
            vec![bag.clone(); at.len().max(1)]
        } else {
            files.to_vec()
        };
        let (poses, times, scans) = (self.pose.len(), at.len(), messages.len());
        if times != 0 && times != scans {
            let what = format!("{times} --at for {scans} scans; give one a scan, or none");
            return Err(UsageError(what).into());
        }
        if poses != 0 && poses != scans {
            let what = format!("{poses} --pose for {scans} scans; give one a scan, or none");
            return Err(UsageError(what).into());
        }
        let poses = mistakes::all(self.pose.iter().map(|pose| pose.pose(inputs)));
        let flag = self.sensor.clone().unwrap_or_default().read(inputs);
        let imu = self.imu.as_deref();
        let imu = imu.map(|file| imu::up_V(file, inputs)).transpose();
        let ((poses, flag), imu) = mistakes::both(mistakes::both(poses, flag), imu)?;
        let up = self.up.or(imu);
        let sources = messages.iter().enumerate();
        let sources =
            sources.map(|(i, file)| self.source(file, at.get(i), poses.get(i), &flag, up));
        Ok(Environment::Scans(sources.collect()))
    }

    fn source(
        &self,
        file: &Path,
        at_s: Option<&f64>,
        pose: Option<&Isometry3<f64>>,
        flag: &SensorFlag,
        up: Option<[f64; 3]>,
    ) -> ScanSource {
        // Of the standard input and of numpy's arrays the bytes tell; what cannot be read is said where it is read.
        let is_array = file.extension().is_some_and(|e| e == "npy" || e == "npz");
        let told =
            (is_array || provenance::is_standard(file)).then(|| provenance::read("scan", file));
        let bytes = told.and_then(Result::ok).unwrap_or_default();
        let is_image = is_depth_image(file, &bytes, self.topic.as_deref());
        let name = file.display().to_string();
        let value = |i: usize| flag.pinhole.map(|values| values[i]);
        let lidar = self.calibration.as_ref();
        let lidar = lidar.map(|_| perception::lidar::SENSOR.to_owned());
        ScanSource {
            depth: is_image.then(|| name.clone()),
            cloud: (!is_image).then_some(name),
            sensor: flag.name.clone().or(lidar),
            fx: value(0),
            fy: value(1),
            cx: value(2),
            cy: value(3),
            depth_scale_m: flag.depth_scale_m,
            eye_m: self.eye,
            calibration: self.calibration.as_ref().map(|p| p.display().to_string()),
            topic: self.topic.clone(),
            at_s: at_s.copied(),
            frame: self.frame.clone(),
            position_m: pose.map(|pose| pose.translation.vector.into()),
            quat_xyzw: pose.map(|pose| pose.rotation.coords.into()),
            level: self.level,
            up,
            extrinsics: None,
        }
    }
}
