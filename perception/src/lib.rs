//! From a scan to planar surfaces.
//!
//! A depth image takes the *organised* path ([`OrganisedConfig`]): inverse depth is linear in the
//! pixel on a plane, so sums over cells of pixels give its planes without a nearest neighbour, and
//! each face is covered by convex polygons that hold no air. Any other cloud takes the same growth
//! over hashed voxels ([`VoxelConfig`]), or, where [`Method::Chain`] asks for it, the paper's *chain*
//! ([`ChainConfig`]): crop, voxel grid, region growing on normals, planes per cluster, projection,
//! convex hull, re-orientation.
//!
//! ```no_run
//! use perception::{Config, SensorOptions, extract, read_scan};
//!
//! let scan = read_scan("stairs_depth.png".as_ref(), &SensorOptions::default())?;
//! let extraction = extract(&scan, &scan.X_WV, &Config::default())?;
//! for surface in &extraction.surfaces {
//!     println!("{}: {:.2} m²", surface.id, surface.polygon.area());
//! }
//! # Ok::<(), perception::Error>(())
//! ```
//!
//! Frames: V is the sensor's optical frame (x right, y down, z forward), S a surface's (z_S toward
//! the sensor), W the world. Points stay in V; only the surfaces' frames are moved to W.

mod chain;
mod config;
mod directions;
mod edges;
mod error;
mod extraction;
mod inset;
pub mod lidar;
mod organised;
mod readers;
mod registration;
mod scan;
mod sensor;
mod several;
mod voxels;

pub use chain::{
    ChainConfig, HullConfig, NormalsConfig, PlaneExtractionConfig, RegionGrowingConfig,
    VoxelGridConfig,
};
pub use config::{Config, Method};
pub use error::Error;
pub use extraction::{Extraction, Segmentation, Statistics};
pub use inset::InsetConfig;
pub use organised::{
    BeyondConfig, CoverConfig, GrowthConfig, MaskConfig, MergeConfig, OrganisedConfig,
    OutlineConfig,
};
pub use readers::{LidarScan, SensorOptions, parse_lidar, parse_scan, read_lidar, read_scan};
pub use registration::{Registration, RegistrationConfig, register};
pub use scan::{DepthImage, Intrinsics, PointCloud, Scan};
pub use sensor::{Noise, SENSORS, Sensor};
pub use several::{SIGHT_STEP, Several, extract_all, sight};

pub use voxels::{VoxelConfig, VoxelGrowthConfig, VoxelOutlineConfig};

use nalgebra::Isometry3;

/// The planar surfaces of one scan taken from `X_WV`, in W.
///
/// A scan without a plane gives no surfaces; that is a result and no error. The result does not
/// depend on the number of threads.
///
/// # Errors
/// [`Error::Config`]; [`Error::NotOrganised`] when the organised path was asked for on a scan
/// without an image; [`Error::Neighbours`].
#[allow(non_snake_case)]
pub fn extract(scan: &Scan, X_WV: &Isometry3<f64>, config: &Config) -> Result<Extraction, Error> {
    config.check()?;
    let (range_max_m, inset) = (config.range_max_m, &config.inset);
    // What is not known of the edges of a cloud shrinks where its surfaces may be touched; in images
    // that is known edge by edge.
    let less = |mut found: Extraction, edge_m: f64| {
        let view = inset.of_cloud(X_WV, &scan.eye_V, edge_m);
        for surface in &mut found.surfaces {
            inset::apply(surface, &view);
        }
        found
    };
    match (&scan.depth, config.method) {
        (Some(depth), Method::Auto | Method::Organised) => {
            let (noise, organised) = (&scan.noise, &config.organised);
            let found = organised::extract(depth, noise, X_WV, range_max_m, organised, inset);
            Ok(found)
        }
        (None, Method::Organised) => Err(Error::NotOrganised),
        (_, Method::Auto | Method::Voxels) => {
            let found = voxels::extract(scan, X_WV, range_max_m, &config.voxels);
            Ok(less(found, config.voxels.outline.inset_m))
        }
        (_, Method::Chain) => {
            let found = chain::extract(scan, X_WV, range_max_m, &config.chain)?;
            Ok(less(found, config.chain.hull.inset_m))
        }
    }
}
