//! The settings of this crate.

use serde::{Deserialize, Serialize};

use crate::{level, merge, role, thin_body};

/// Smallest area of a face, or of a convex piece of one, that is worth standing on, m².
pub const FACE_AREA_MIN_M2: f64 = 0.005;
/// Smallest width of either (diameter of the largest circle in it), m.
pub const FACE_WIDTH_MIN_M: f64 = 0.04;
/// Faces whose normals are at least this far from the vertical are walls, rad.
pub const WALL_RAD: f64 = 0.8;

/// Every setting of the crate; the defaults work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How deep the bodies behind surfaces are.
    pub body: thin_body::Config,
    /// How strongly scanned faces that may be level are taken to be.
    pub level: level::Config,
    /// How faces of several scans are made one.
    pub merge: merge::Config,
    /// Which surfaces serve which role.
    pub roles: role::Config,
}
