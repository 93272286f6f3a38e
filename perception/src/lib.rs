//! From a scan to plane faces.
//!
//! A depth image takes the *organised* path ([`Method::Organised`]): inverse depth is linear in the
//! pixel on a plane, so sums over cells of pixels give its planes without a nearest neighbour. Any other
//! cloud, and an image with too many pixels missing, takes the same growth over hashed voxels ([`Method::Voxels`]), or, where [`Method::Brossette2013`] asks for it, the chain of that paper
//! ([`Brossette2013Config`]): crop, voxel grid, region growing on normals, planes per cluster, projection,
//! convex hull, re-orientation.
//!
//! ```
//! use perception::{Config, DepthImage, Scan, Sensor, extract};
//!
//! // A camera 1 m over a floor that looks down by 45°: z = 1 / (sin 45° + y cos 45°) on the ray (x, y, 1).
//! let sensor = Sensor::named("xtion")?;
//! let (width, height) = (320, 240);
//! let intrinsics = sensor.intrinsics_for(width, height).expect("it scales");
//! let down = std::f64::consts::FRAC_1_SQRT_2;
//! let z_of_row = |v: usize| 1.0 / (down * (1.0 + (v as f64 - intrinsics.cy) / intrinsics.fy));
//! let z_m = (0..width * height).map(|pixel| z_of_row(pixel / width) as f32).collect();
//! let scan = Scan::of_image(DepthImage { width, height, z_m, intrinsics }, sensor.noise);
//! let found = extract(&scan, &scan.X_WV, &Config::default())?;
//! assert_eq!(found.faces.len(), 1);
//! assert!((found.faces[0].normal_W().y + down).abs() < 1e-3);
//! # Ok::<(), perception::Error>(())
//! ```
//!
//! Frames: V is the sensor's optical frame (x right, y down, z forward), F a face's (z_F toward
//! the sensor), W the world. Points stay in V; only the faces' frames are moved to W.
#![forbid(unsafe_code)]

mod brossette2013;
mod config;
mod density;
mod edges;
mod error;
mod extraction;
mod face;
mod ground_pose;
pub mod lidar;
mod looked;
mod organised;
mod perceive;
mod plane_covariance;
mod plausible;
mod readers;
mod registration;
mod scan;
mod segmentation;
mod sensor;
mod spherical_range_image;
mod voxels;

pub use brossette2013::Brossette2013Config;
pub use config::{Config, Method};
pub use error::Error;
pub use extraction::{Extraction, Segmentation, Statistics};
pub use ground_pose::{GroundPose, ground_pose, up_by_planes};
pub use perceive::{Notice, Perception, PosedScan, perceive};
pub use readers::{
    BagOptions, LidarScan, SensorOptions, depth_scan, is_depth_image, parse_lidar, parse_scan,
    read_lidar, read_scan,
};
pub use registration::{Registration, RegistrationConfig, register};
pub use scan::{DepthImage, PointCloud, Scan};
pub use sensor::{Intrinsics, Noise, SENSORS, Sensor};

use nalgebra::Isometry3;

/// The faces of one scan taken from `X_WV`, in W.
///
/// A scan without a plane gives no faces; that is a result and no error. The result does not
/// depend on the number of threads.
///
/// # Errors
/// [`Error::Config`]; [`Error::NotOrganised`] when the organised path was asked for on a scan
/// without an image; [`Error::Neighbours`].
pub fn extract(scan: &Scan, X_WV: &Isometry3<f64>, config: &Config) -> Result<Extraction, Error> {
    config.check()?;
    if let (Some(depth), Method::Auto | Method::Organised) = (&scan.depth, config.method)
        && let Some(found) = organised::extract(depth, &scan.noise, X_WV, config)
    {
        return Ok(found);
    }
    match config.method {
        Method::Organised => Err(Error::NotOrganised),
        Method::Auto | Method::Voxels => Ok(voxels::extract(scan, X_WV, config)),
        Method::Brossette2013 => {
            brossette2013::extract(scan, X_WV, config.range_max_m, &config.brossette2013)
        }
    }
}
