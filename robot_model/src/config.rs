//! How strictly, and into what, a robot's files are read.

use serde::{Deserialize, Serialize};

/// Settings of the loader. The defaults work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Most vertices of a collision mesh's convex hull; a mesh with more is simplified to the
    /// most telling ones, and a note says by how much the rest stick out.
    pub hull_vertices: usize,
    /// Reads on, with a note, where an SRDF names unknown links, a moving link has no mass, or
    /// an inertia is none of a body's. Otherwise these are errors.
    pub lenient: bool,
    /// Stops watching the pairs of links that overlap in the resting posture. Otherwise they are
    /// reported, and stay watched unless the SRDF disables them.
    pub disable_colliding_at_rest: bool,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            hull_vertices: 64,
            lenient: false,
            disable_colliding_at_rest: false,
        }
    }
}
