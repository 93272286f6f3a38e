//! From a scan to planar surfaces.

mod config;
mod error;
mod extraction;
mod organised;
mod readers;
mod scan;
mod sensor;

pub use config::{Config, Method};
pub use error::Error;
pub use extraction::{Extraction, Segmentation, Statistics};
pub use organised::{
    CoverConfig, GrowthConfig, MaskConfig, MergeConfig, OrganisedConfig, OutlineConfig,
};
pub use readers::{SensorOptions, parse_scan, read_scan};
pub use scan::{DepthImage, Intrinsics, PointCloud, Scan};
pub use sensor::{Noise, SENSORS, Sensor};

use nalgebra::Isometry3;

/// The planar surfaces of one scan taken from `X_WV`, in W.
///
/// # Errors
/// [`Error::Config`]; [`Error::NotOrganised`] when the organised path was asked for on a scan
/// without an image; [`Error::Surface`].
#[allow(non_snake_case)]
pub fn extract(scan: &Scan, X_WV: &Isometry3<f64>, config: &Config) -> Result<Extraction, Error> {
    config.check()?;
    match (&scan.depth, config.method) {
        (Some(depth), Method::Auto | Method::Organised) => organised::extract(
            depth,
            &scan.noise,
            X_WV,
            config.range_max_m,
            &config.organised,
        ),
        (None, Method::Organised) => Err(Error::NotOrganised),
        _ => Err(Error::NotOrganised),
    }
}
