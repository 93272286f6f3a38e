//! Everything a robot may touch and everything it must avoid.

use serde::{Deserialize, Serialize};

use crate::{Obstacle, Surface};

/// Surfaces to touch and obstacles to avoid, each with an id of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceSet {
    /// The surfaces.
    pub surfaces: Vec<Surface>,
    /// Convex bodies that are only avoided.
    #[serde(default)]
    pub obstacles: Vec<Obstacle>,
}
