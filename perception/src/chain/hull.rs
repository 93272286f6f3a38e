//! The convex hull of a plane's points.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use surfaces::ConvexPolygon;

use crate::Error;
use crate::error::within;

/// The convex hull.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HullConfig {
    /// Most corners; corners are dropped, so that the hull only shrinks.
    pub vertices_max: usize,
    /// Smallest hull that is kept, m².
    pub area_min_m2: f64,
    /// Inset that the surfaces carry for what the points' edge does not tell, m.
    pub inset_m: f64,
}

impl Default for HullConfig {
    fn default() -> Self {
        Self {
            vertices_max: 16,
            area_min_m2: 0.005,
            inset_m: 0.02,
        }
    }
}

impl HullConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        within(
            "vertices_max",
            self.vertices_max as f64,
            3.0,
            1000.0,
            "must be in [3, 1000]",
        )?;
        within(
            "area_min_m2",
            self.area_min_m2,
            0.0,
            1e6,
            "must not be negative",
        )?;
        within("inset_m", self.inset_m, 0.0, 1e3, "must not be negative")
    }
}

/// The convex hull of the points, counter-clockwise; `None` if it is too small or has no area.
///
/// Source: [brossette2013] III-E. It covers what a concave face leaves open.
pub(super) fn hull(points: &[Point2<f64>], config: &HullConfig) -> Option<ConvexPolygon> {
    let polygon = ConvexPolygon::hull(points).ok()?;
    let polygon = polygon.simplified_inside(config.vertices_max);
    (polygon.area() >= config.area_min_m2).then_some(polygon)
}
