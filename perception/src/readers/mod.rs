//! Scan files → [`Scan`]; one reader a file.
//!
//! Every reader works on the file's bytes and checks each size in the header against the number
//! of bytes that are there before anything is allocated, so that a lying header is an error and
//! neither a panic nor a gigabyte.

mod bag;
mod capture;
mod depth_png;
mod pcd;
mod ply;
mod vlp16;

use std::path::Path;

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};

pub use bag::BagOptions;
pub use vlp16::LidarScan;

use crate::Error;
use crate::lidar::LidarCloud;
use crate::scan::{DepthImage, PointCloud, Scan};
use crate::sensor::{Intrinsics, Sensor};

/// What the file does not say about itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorOptions {
    /// Name in the sensor table; it gives the noise and what the fields below leave out.
    pub sensor: String,
    /// Intrinsics of a depth image, px; the sensor's own where absent.
    pub intrinsics: Option<Intrinsics>,
    /// Metres per unit of a depth image; the sensor's own where absent.
    pub depth_scale_m: Option<f64>,
    /// Where the sensor stood in the cloud's frame, m, for clouds that were moved after the scan.
    pub eye_m: Option<[f64; 3]>,
    /// Which message of a recording is the scan.
    pub bag: BagOptions,
}

impl Default for SensorOptions {
    fn default() -> Self {
        Self {
            sensor: "xtion".to_owned(),
            intrinsics: None,
            depth_scale_m: None,
            eye_m: None,
            bag: BagOptions::default(),
        }
    }
}

/// Reads the scan at `path`, in the format that its first bytes or its extension name.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; else as [`parse_scan`].
pub fn read_scan(path: &Path, options: &SensorOptions) -> Result<Scan, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io {
        path: path.to_owned(),
        source,
    })?;
    parse_scan(path, &bytes, options)
}

/// The scan in `bytes`; `path` is for the messages and the extension only.
///
/// # Errors
/// [`Error::UnknownFormat`]; [`Error::Field`] or [`Error::Parse`] for a file that contradicts its
/// format; [`Error::Empty`] when no valid point is left; [`Error::UnknownSensor`],
/// [`Error::NoIntrinsics`] and [`Error::Config`] for bad options.
pub fn parse_scan(path: &Path, bytes: &[u8], options: &SensorOptions) -> Result<Scan, Error> {
    let sensor = Sensor::named(&options.sensor)?;
    let format = format_of(path, bytes);
    if options.bag != BagOptions::default() && !matches!(format, Some(Format::Mcap)) {
        let cause = "topic, time and frame are of a ROS 2 bag (MCAP), which this is not";
        return Err(Error::field(path, "format", cause));
    }
    let (cloud, depth, pose) = match format {
        Some(Format::Png) => {
            let (size, units) = depth_png::decode(path, bytes)?;
            let units = units.into_iter().map(f32::from);
            let depth =
                depth_png::metric(path, size, units, sensor.depth_scale_m, sensor, options)?;
            (depth.to_cloud(), Some(depth), Isometry3::identity())
        }
        Some(Format::Pcd) => {
            let (cloud, pose) = pcd::parse(path, bytes)?;
            let depth = DepthImage::from_organised(&cloud);
            (cloud, depth, pose)
        }
        Some(Format::Ply) => (ply::parse(path, bytes)?, None, Isometry3::identity()),
        Some(Format::Mcap) => return bag::parse(path, bytes, sensor, options),
        None => {
            return Err(Error::UnknownFormat {
                path: path.to_owned(),
            });
        }
    };
    scan(path, cloud, depth, pose, sensor, options)
}

/// The scan of a depth image that is at hand: `size` is width and height, `units` its pixels row by row in
/// the unit of the sensor, 0 where nothing was measured; `name` is for the messages.
///
/// # Errors
/// [`Error::Field`] of another number of pixels or depths in another unit; else as [`parse_scan`].
pub fn depth_scan(
    name: &Path,
    size: (usize, usize),
    units: &[u16],
    options: &SensorOptions,
) -> Result<Scan, Error> {
    let sensor = Sensor::named(&options.sensor)?;
    if size.0.checked_mul(size.1) != Some(units.len()) {
        let cause = format!("{} pixels, not {} x {}", units.len(), size.0, size.1);
        return Err(Error::field(name, "size", cause));
    }
    let units = units.iter().copied().map(f32::from);
    let depth = depth_png::metric(name, size, units, sensor.depth_scale_m, sensor, options)?;
    let pose = Isometry3::identity();
    scan(name, depth.to_cloud(), Some(depth), pose, sensor, options)
}

fn scan(
    path: &Path,
    cloud: PointCloud,
    depth: Option<DepthImage>,
    X_WV: Isometry3<f64>,
    sensor: &Sensor,
    options: &SensorOptions,
) -> Result<Scan, Error> {
    let eye = options.eye_m.unwrap_or([0.0; 3]);
    if eye.iter().any(|c| !c.is_finite()) {
        return Err(Error::Config {
            key: "eye_m",
            value: f64::NAN,
            cause: "must be finite",
        });
    }
    if cloud.finite().next().is_none() {
        let total = cloud.points.len().max(cloud.invalid);
        return Err(Error::Empty {
            path: path.to_owned(),
            total,
        });
    }
    Ok(Scan {
        cloud,
        depth,
        X_WV,
        eye_V: Vector3::from(eye),
        noise: sensor.noise,
        notes: Vec::new(),
    })
}

/// The points of a LiDAR's file: a capture of a VLP-16's packets (pcap, pcapng), PCD, or PLY.
///
/// `sweep` picks one of a capture's sweeps; without it the first whole one is taken.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; else as [`parse_lidar`].
pub fn read_lidar(path: &Path, sweep: Option<usize>) -> Result<LidarScan, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io {
        path: path.to_owned(),
        source,
    })?;
    parse_lidar(path, &bytes, sweep)
}

/// The LiDAR's points in `bytes`; `path` is for the messages and the extension only.
///
/// # Errors
/// [`Error::UnknownFormat`]; [`Error::Field`] or [`Error::Parse`] for a file that contradicts its
/// format; [`Error::Empty`] when no valid point is left.
pub fn parse_lidar(path: &Path, bytes: &[u8], sweep: Option<usize>) -> Result<LidarScan, Error> {
    let whole = |cloud| LidarScan {
        cloud,
        sweeps: 1,
        notes: Vec::new(),
    };
    let scan = if capture::is_capture(bytes) {
        vlp16::parse(path, bytes, sweep)?
    } else {
        match format_of(path, bytes) {
            Some(Format::Pcd) => whole(pcd::parse_lidar(path, bytes)?),
            Some(Format::Ply) => {
                let points = ply::parse(path, bytes)?;
                let mut cloud = LidarCloud::from_points(points.points.iter().copied());
                // Those that the reader dropped.
                cloud.invalid = cloud.invalid.max(points.invalid);
                whole(cloud)
            }
            Some(Format::Png | Format::Mcap) => {
                let cause = "is no file of a LiDAR's cloud";
                return Err(Error::field(path, "format", cause));
            }
            None => {
                return Err(Error::UnknownFormat {
                    path: path.to_owned(),
                });
            }
        }
    };
    if scan.cloud.is_empty() {
        return Err(Error::Empty {
            path: path.to_owned(),
            total: scan.cloud.invalid,
        });
    }
    Ok(scan)
}

enum Format {
    Png,
    Pcd,
    Ply,
    Mcap,
}

/// The format by the first bytes, else by the extension.
fn format_of(path: &Path, bytes: &[u8]) -> Option<Format> {
    let extension = path
        .extension()
        .and_then(|e| e.to_str())
        .map(str::to_ascii_lowercase);
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some(Format::Png)
    } else if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
        Some(Format::Ply)
    } else if bytes.starts_with(b"# .PCD") || bytes.starts_with(b"VERSION") {
        Some(Format::Pcd)
    } else if bag::is_mcap(bytes) {
        Some(Format::Mcap)
    } else {
        match extension.as_deref() {
            Some("png") => Some(Format::Png),
            Some("pcd") => Some(Format::Pcd),
            Some("ply") => Some(Format::Ply),
            _ => None,
        }
    }
}

/// Drops the invalid points of a cloud without a grid, marks them all NaN in one with a grid.
fn tidy(points: Vec<[f32; 3]>, organised: Option<(usize, usize)>) -> PointCloud {
    let finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
    let invalid = points.iter().filter(|p| !finite(p)).count();
    let points = match organised {
        Some(_) => points
            .into_iter()
            .map(|p| if finite(&p) { p } else { [f32::NAN; 3] })
            .collect(),
        None => points.into_iter().filter(finite).collect(),
    };
    PointCloud {
        points,
        organised,
        invalid,
    }
}
