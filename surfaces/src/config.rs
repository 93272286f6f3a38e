//! The settings of this crate, and what it takes for granted.

use serde::{Deserialize, Serialize};

use crate::role;

/// Smallest area of a face, or of a convex part of one, that is worth standing on, m².
pub const FACE_AREA_MIN_M2: f64 = 0.005;
/// Smallest width of either (diameter of the largest circle in it), m.
pub const FACE_WIDTH_MIN_M: f64 = 0.04;
/// Faces whose normals are at least this far from the vertical are walls, rad.
pub const WALL_RAD: f64 = 0.8;
/// Depth that what stands behind a wall is taken to have as far as nothing was seen of it, m.
pub const UNSEEN_DEPTH_M: f64 = 0.2;

/// Farthest that anything may be from the origin along an axis, m: what lies beyond is a mistake.
pub const WORLD_M: f64 = 1e4;

/// The first of the coordinates that is none of a place in the world: NaN, or beyond [`WORLD_M`].
pub fn beyond_world(coordinates: &[f64]) -> Option<f64> {
    let mut coordinates = coordinates.iter().copied();
    coordinates.find(|c| c.is_nan() || c.abs() > WORLD_M)
}

/// Every setting of the crate; the defaults work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How deep the bodies behind faces are.
    pub body: BodyConfig,
    /// Which faces serve which role.
    pub roles: role::Config,
}

/// How deep the bodies behind faces are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BodyConfig {
    /// Depth that every object is taken to have, m.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub thickness_m: f64,
}

impl Default for BodyConfig {
    fn default() -> Self {
        Self { thickness_m: 0.03 }
    }
}
