//! The body behind a surface, for collision avoidance.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::Surface;

/// A surface's polygon extruded against its normal: a convex prism.
#[allow(non_snake_case)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThinBody {
    /// Id of the surface.
    pub surface: String,
    /// The n vertices of the polygon in W, then the same n shifted by the thickness, m.
    pub points_W: Vec<Point3<f64>>,
}

impl ThinBody {
    /// The prism of depth `thickness_m` behind the surface.
    ///
    ///   { p_W − t z_S : p in the polygon, 0 ≤ t ≤ thickness }
    ///
    /// Source: [brossette2013] section IV-B.
    #[allow(non_snake_case)]
    pub fn new(surface: &Surface, thickness_m: f64) -> Self {
        let inward: Vector3<f64> = -surface.normal_W() * thickness_m;
        let mut points_W = surface.vertices_W();
        points_W.extend_from_within(..);
        let count = points_W.len() / 2;
        for p in &mut points_W[count..] {
            *p += inward;
        }
        Self {
            surface: surface.id.clone(),
            points_W,
        }
    }
}
