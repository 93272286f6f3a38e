//! What comes out of a scan.

use nalgebra::Vector3;
use serde::Serialize;
use surfaces::Face;

use crate::Method;

/// The faces of one scan, and how they came about.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Extraction {
    /// How they were found.
    pub method: Method,
    /// Connected plane faces in W, by falling area; ids f0, f1, …
    pub faces: Vec<Face>,
    /// Faces that are left out because their outlines cannot be used, and why.
    pub refused: Vec<surfaces::Error>,
    /// Counts along the way.
    pub statistics: Statistics,
    /// Which pixel or point belongs to which plane; not of [`crate::Method::Brossette2013`].
    pub segmentation: Option<Segmentation>,
    /// Which pixel a face surely holds; of an image only.
    pub on_face: Vec<bool>,
}

/// Counts of points and parts along the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Statistics {
    /// Points or pixels in the scan; of an image that is finer than needed, the blocks that are one.
    pub points: usize,
    /// Those that were measured.
    pub valid: usize,
    /// Those within range (and, on the chain, left by the voxel grid).
    pub used: usize,
    /// Regions (or clusters) that were grown.
    pub regions: usize,
    /// Planes that were fitted.
    pub planes: usize,
    /// Points or pixels that belong to one of them.
    pub assigned: usize,
}

/// A plane for every pixel, or for every point of a cloud: one without a grid is one row.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmentation {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major index of the pixel's plane, [`Self::NONE`] where there is none.
    pub labels: Vec<u16>,
    /// Index of the plane of each face, in the order of the faces.
    pub plane_of_face: Vec<u16>,
    /// Each plane in the sensor's frame: unit normal n toward the sensor and distance d, n·p = −d,
    /// positive where the sensor is at the origin; `None` for a plane that kept too few pixels.
    pub planes_V: Vec<Option<(Vector3<f64>, f64)>>,
}

impl Segmentation {
    /// The label of a pixel without a plane.
    pub const NONE: u16 = u16::MAX;
}
