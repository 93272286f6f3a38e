//! How far surfaces keep from their edges for what is not known of them.

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use surfaces::Surface;
use surfaces::covariance::{EdgeView, edge_insets_m};

use crate::Error;
use crate::error::within;

/// The inset of the surfaces of a scan ([`surfaces::covariance`]): an error of a plane moves its edges
/// along the rays on which they were seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct InsetConfig {
    /// k: number of standard deviations of an edge's place to keep off it.
    pub sigmas: f64,
}

/// Standard deviation of an edge's place in an image, px. Outlines of images lie inside the true edges
/// already, by what was taken off and what dropped out there: only what k σ of the image and the plane
/// together come to beyond that is left for the inset.
pub(crate) const EDGE_SIGMA_PX: f64 = 1.0;

impl Default for InsetConfig {
    fn default() -> Self {
        Self { sigmas: 2.0 }
    }
}

impl InsetConfig {
    pub(crate) fn check(&self) -> Result<(), Error> {
        within(
            "inset.sigmas",
            self.sigmas,
            0.0,
            100.0,
            "must be in [0, 100]",
        )
    }

    /// How the edges of an image are seen from `X_WV` that lie `inside_rad` inside the true ones, the
    /// pixels `pixel_rad` apart.
    #[allow(non_snake_case)]
    pub(crate) fn of_image<'a>(
        &self,
        X_WV: &Isometry3<f64>,
        pixel_rad: f64,
        inside_rad: &'a [Vec<f64>],
    ) -> EdgeView<'a> {
        EdgeView {
            eye_W: Point3::from(X_WV.translation.vector),
            k: self.sigmas,
            sigma_rad: EDGE_SIGMA_PX * pixel_rad,
            inside_rad,
            further_m: 0.0,
        }
    }

    /// How the edges of a cloud are seen from `eye_V`, whose points leave an edge open by `edge_m`.
    #[allow(non_snake_case)]
    pub(crate) fn of_cloud(
        &self,
        X_WV: &Isometry3<f64>,
        eye_V: &Vector3<f64>,
        edge_m: f64,
    ) -> EdgeView<'static> {
        EdgeView {
            eye_W: X_WV * Point3::from(*eye_V),
            k: self.sigmas,
            sigma_rad: 0.0,
            inside_rad: &[],
            further_m: edge_m,
        }
    }
}

/// Gives a surface its insets. The sensor is on the free side of all that it saw: there is no other
/// error than that it is not, and then nothing is known of how an edge was seen.
pub(crate) fn apply(surface: &mut Surface, view: &EdgeView) {
    if let Ok(insets_m) = edge_insets_m(surface, view) {
        surface.set_insets(insets_m);
    }
}
