//! How strictly, and into what, a robot's files are read.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the loader.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Reads on, with a note, where an SRDF names unknown links, a moving link has no mass, or
    /// an inertia is none of a body's. Otherwise these are errors.
    pub lenient: bool,
    /// Stops watching all pairs of links that meet in the resting posture (nearer than 8 mm). Otherwise
    /// it stops where they are neighbours (over at most two joints, or over joints that meet in one point) or meet in every posture, and
    /// reports the others that overlap.
    pub disable_colliding_at_rest: bool,
}
