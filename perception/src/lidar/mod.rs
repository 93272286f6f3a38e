//! Slopes from a spinning multi-beam range finder.
//!
//! ```text
//! cloud ─ crop, ring errors ─▶ statistical filter ─▶ normals ─▶ ground ─▶ slopes ─▶ joint fit ─▶ description
//! ```
//!
//! | step | where |
//! |---|---|
//! | points with ring, azimuth and time; the crop | [`LidarCloud`] |
//! | rings in order of azimuth | `rings` |
//! | D ≤ μ + κσ | `outliers` |
//! | normals, links | `field` |
//! | progressive sample consensus | `prosac` |
//! | the ground, the slopes on it | `ground`, `slopes` |
//! | planes and ring errors together | `joint_fit`, `refine` |
//! | what bends too much for a slope | `unevenness` |
//! | p₁, p₂, l, ψ, δ, stepping angle | [`Description`], `edges` |
//! | all planes, the rings' errors from them | [`extract_planes`], [`adjust`] |
//! | ground and slopes as faces | `faces` |
//! | walls and things around, to keep away from | [`Surroundings`] |
//! | from V to W | [`levelled`], [`LidarCalibration`] |
//!
//! Frames: V is the LiDAR's (x forward, y left, z up), W the world (z up, its origin on the ground
//! below the sensor).
//! Source: \[meng\], with its formulas corrected where they are wrong; each file says where.

/// Name of the sensor in scene files and on the command line.
pub const SENSOR: &str = "vlp16";

mod calibration;
mod cloud;
mod config;
mod describe;
mod description;
mod detect;
mod edges;
mod extract_planes;
mod faces;
mod field;
mod ground;
mod joint_fit;
mod outliers;
mod plane;
mod preparation;
mod prosac;
mod refine;
mod rings;
mod scan;
mod slopes;
mod surroundings;
mod unevenness;
mod world;

pub use calibration::{CALIBRATION_FORMAT, LidarCalibration};
pub use cloud::LidarCloud;
pub use config::LidarConfig;
pub use description::Description;
pub use detect::{SegmentedCloud, detect, segment_cloud};
pub use extract_planes::{Adjustment, ExtractedPlane, ExtractedPlanes, adjust, extract_planes};
pub use plane::Plane;
pub use scan::{Ground, LidarCounts, Slope, SlopeScan};
pub use surroundings::{ObstacleCluster, Surroundings, Wall, gathered};
pub use world::levelled;
