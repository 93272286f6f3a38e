//! Scan files → [`Scan`]; one reader a file.
//!
//! Every reader works on the file's bytes and checks each size in the header against the number
//! of bytes that are there before anything is allocated, so that a lying header is an error and
//! neither a panic nor a gigabyte.

mod bag;
mod capture;
mod depth_png;
mod e57;
mod las;
mod npy;
mod npz;
mod pcd;
mod ply;
mod text;
mod tiff;
mod vlp16;

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

pub use bag::BagOptions;
use npy::Array;
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
/// [`Error::File`] when the file cannot be read; else as [`parse_scan`].
pub fn read_scan(path: &Path, options: &SensorOptions) -> Result<Scan, Error> {
    let bytes = std::fs::read(path).map_err(|cause| Error::file(path, cause.to_string()))?;
    parse_scan(path, &bytes, options)
}

/// The scan in `bytes`; `path` is for the messages and the extension only.
///
/// # Errors
/// [`Error::File`]; [`Error::UnknownSensor`] and [`Error::Config`] for bad options.
pub fn parse_scan(path: &Path, bytes: &[u8], options: &SensorOptions) -> Result<Scan, Error> {
    let sensor = Sensor::named(&options.sensor)?;
    let format = format_of(path, bytes);
    let (asked, topic) = (&options.bag, options.bag.topic.as_deref());
    let applies = match format {
        Some(Format::Mcap) => true,
        Some(Format::E57 | Format::Npz) => asked.at_s.is_none() && asked.frame.is_none(),
        _ => *asked == BagOptions::default(),
    };
    if !applies {
        let cause = "topic, time and frame are of a ROS 2 bag (MCAP), which this is not";
        return Err(Error::field(path, "format", cause));
    }
    let still = Isometry3::identity();
    let mut notes = Vec::new();
    let image = |size, units: Vec<f32>, unit_m| {
        let units = units.into_iter();
        let depth = depth_png::metric(path, size, units, unit_m, sensor, options)?;
        Ok((depth.to_cloud(), Some(depth), still))
    };
    let of_array = |array| match array {
        Array::Points(cloud) => {
            let depth = DepthImage::from_organised(&cloud);
            Ok((cloud, depth, still))
        }
        Array::Depths(depths) => {
            let unit_m = match depths.metres {
                true => 1.0,
                false => sensor.depth_scale_m,
            };
            image(depths.size, depths.units, unit_m)
        }
    };
    let (cloud, depth, pose) = match format {
        Some(Format::Png) => {
            let (size, units) = depth_png::decode(path, bytes)?;
            let units = units.into_iter().map(f32::from).collect();
            image(size, units, sensor.depth_scale_m)?
        }
        Some(Format::Tiff) => of_array(tiff::decode(path, bytes)?)?,
        Some(Format::Npy) => of_array(npy::decode(path, bytes)?)?,
        Some(Format::Npz) => of_array(npz::decode(path, bytes, topic, &mut notes)?)?,
        Some(Format::Pcd) => {
            let (cloud, stated) = pcd::parse(path, bytes)?;
            let depth = DepthImage::from_organised(&cloud);
            // PCL takes VIEWPOINT both ways: as the pose of the points' frame (its viewer), and as the sensor's among
            // points that are in the world (its normals and range images). An eye among them is the second.
            let is_among = options.eye_m.is_some();
            let pose = if is_among { still } else { stated };
            if stated != still {
                let (name, [x, y, z]) = (path.display(), stated.translation.vector.into());
                notes.push(match is_among {
                    true => format!("{name}: VIEWPOINT moves no points, which have their --eye"),
                    false => format!(
                        "{name}: VIEWPOINT is the pose of its points' frame where no --pose is given; give points that \
                         are in the world already their --eye {x},{y},{z}"
                    ),
                });
            }
            (cloud, depth, pose)
        }
        Some(Format::Ply) => (ply::parse(path, bytes)?, None, still),
        Some(Format::Las) => (
            near(path, las::parse(path, bytes)?, &mut notes),
            None,
            still,
        ),
        Some(Format::E57) => {
            let (points, pose) = e57::parse(path, bytes, topic)?;
            (near(path, points.into_iter(), &mut notes), None, pose)
        }
        Some(Format::Text) => {
            let points = text::parse(path, bytes)?;
            (near(path, points.into_iter(), &mut notes), None, still)
        }
        Some(Format::Mcap) => return bag::parse(path, bytes, sensor, options),
        None => return Err(unknown(path)),
    };
    let mut scan = scan(path, cloud, depth, pose, sensor, options)?;
    scan.notes = notes;
    Ok(scan)
}

/// The pose that a file states by a position, m, and a quaternion (x, y, z, w) of length 1 but for written decimals;
/// none beyond [`surfaces::WORLD_M`].
fn stated_pose(position_m: [f64; 3], quat_xyzw: [f64; 4]) -> Option<Isometry3<f64>> {
    let rotation = Quaternion::from_vector(quat_xyzw.into());
    let is_one = (0.99..=1.01).contains(&rotation.norm());
    (is_one && surfaces::beyond_world(&position_m).is_none()).then(|| {
        let rotation = UnitQuaternion::from_quaternion(rotation);
        Isometry3::from_parts(Vector3::from(position_m).into(), rotation)
    })
}

fn unknown(path: &Path) -> Error {
    let known = "depth images (16-bit PNG, TIFF, npy, npz), PCD, PLY, LAS, E57, MCAP, text (xyz, csv, txt, asc, pts), \
                 and pcap of a LiDAR";
    Error::file(path, format!("unknown scan format; known are {known}"))
}

fn empty(path: &Path, total: usize) -> Error {
    let cause = format!("no valid point ({total} read, all zero, NaN or infinite)");
    Error::file(path, cause)
}

/// The scan of a depth image that is at hand: `size` is width and height, `units` its pixels row by row in
/// the unit of the sensor, 0 where nothing was measured; `name` is for the messages.
///
/// # Errors
/// [`Error::File`] of another number of pixels or depths in another unit; else as [`parse_scan`].
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
        return Err(empty(path, total));
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
/// [`Error::File`] when the file cannot be read; else as [`parse_lidar`].
pub fn read_lidar(path: &Path, sweep: Option<usize>) -> Result<LidarScan, Error> {
    let bytes = std::fs::read(path).map_err(|cause| Error::file(path, cause.to_string()))?;
    parse_lidar(path, &bytes, sweep)
}

/// The LiDAR's points in `bytes`; `path` is for the messages and the extension only.
///
/// # Errors
/// [`Error::File`].
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
            Some(_) => {
                let cause = "is no file of a LiDAR's sweeps";
                return Err(Error::field(path, "format", cause));
            }
            None => return Err(unknown(path)),
        }
    };
    if scan.cloud.is_empty() {
        return Err(empty(path, scan.cloud.invalid));
    }
    Ok(scan)
}

#[derive(Clone, Copy)]
enum Format {
    Png,
    Tiff,
    Npy,
    Npz,
    Pcd,
    Ply,
    Las,
    E57,
    Mcap,
    Text,
}

/// Whether a file is a depth image, by its bytes, else by its extension. Only their bytes tell what numpy's arrays
/// hold: without any they are taken to be images. `topic` names one of several.
pub fn is_depth_image(path: &Path, bytes: &[u8], topic: Option<&str>) -> bool {
    let array = match format_of(path, bytes) {
        Some(Format::Png | Format::Tiff) => return true,
        Some(Format::Npy) => npy::decode(path, bytes),
        Some(Format::Npz) => npz::decode(path, bytes, topic, &mut Vec::new()),
        _ => return false,
    };
    !matches!(array, Ok(Array::Points(_)))
}

/// The format by the first bytes, else by the extension.
fn format_of(path: &Path, bytes: &[u8]) -> Option<Format> {
    if bag::is_mcap(bytes) {
        return Some(Format::Mcap);
    }
    let begins: [(&[u8], Format); 11] = [
        (b"\x89PNG\r\n\x1a\n", Format::Png),
        (tiff::MAGIC[0], Format::Tiff),
        (tiff::MAGIC[1], Format::Tiff),
        (npy::MAGIC, Format::Npy),
        (npz::MAGIC, Format::Npz),
        (b"ply\n", Format::Ply),
        (b"ply\r", Format::Ply),
        (b"# .PCD", Format::Pcd),
        (b"VERSION", Format::Pcd),
        (las::MAGIC, Format::Las),
        (e57::MAGIC, Format::E57),
    ];
    if let Some((_, format)) = begins.into_iter().find(|(m, _)| bytes.starts_with(m)) {
        return Some(format);
    }
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "png" => Some(Format::Png),
        "tif" | "tiff" => Some(Format::Tiff),
        "npy" => Some(Format::Npy),
        "npz" => Some(Format::Npz),
        "pcd" => Some(Format::Pcd),
        "ply" => Some(Format::Ply),
        "las" => Some(Format::Las),
        "e57" => Some(Format::E57),
        text if text::is_text(text) => Some(Format::Text),
        _ => None,
    }
}

/// Farther from the origin than this, m, single precision is coarser than .1 mm.
const FAR_M: f64 = 1e3;

/// The cloud of points that may have a survey's coordinates, and a note where they are counted from elsewhere then.
fn near(
    path: &Path,
    points: impl Iterator<Item = [f64; 3]> + Clone,
    notes: &mut Vec<String>,
) -> PointCloud {
    let finite = |p: &[f64; 3]| p.iter().all(|c| c.is_finite());
    let least = points.clone().filter(finite);
    let least = least.fold([f64::MAX; 3], |least, p| {
        [0, 1, 2].map(|i| least[i].min(p[i]))
    });
    let far = least.iter().any(|c| c.abs() > FAR_M && *c < f64::MAX);
    let origin = least.map(|c| if far { c.floor() } else { 0.0 });
    if far {
        let [x, y, z] = origin;
        let name = path.display();
        notes.push(format!(
            "{name}: coordinates are counted from {x}, {y}, {z}"
        ));
    }
    let moved = points.map(|p| [0, 1, 2].map(|i| (p[i] - origin[i]) as f32));
    tidy(moved.collect(), None)
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
