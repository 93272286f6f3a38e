//! The pinhole that the rays start from.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// An ideal pinhole camera: pixel (u, v) looks along ((u − cx)/fx, (v − cy)/fy, 1) in V.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pinhole {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Focal length along the columns, pixels.
    pub fx: f64,
    /// Focal length along the rows, pixels.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

/// The depth image of an Asus Xtion Pro: 640×480, 63° × 49°.
pub const XTION: Pinhole = Pinhole {
    width: 640,
    height: 480,
    fx: 525.0,
    fy: 525.0,
    cx: 319.5,
    cy: 239.5,
};

/// The depth image of a Kinect v1: 640×480, 58° × 45°.
pub const KINECT: Pinhole = Pinhole {
    width: 640,
    height: 480,
    fx: 575.8,
    fy: 575.8,
    cx: 314.5,
    cy: 235.5,
};

impl Pinhole {
    /// The same view on an image `n` times smaller both ways.
    #[must_use]
    pub fn smaller(&self, n: usize) -> Self {
        let scale = 1.0 / n as f64;
        Self {
            width: self.width / n,
            height: self.height / n,
            fx: self.fx * scale,
            fy: self.fy * scale,
            // Pixel centres are at integers.
            cx: (self.cx + 0.5) * scale - 0.5,
            cy: (self.cy + 0.5) * scale - 0.5,
        }
    }

    /// Direction of a (possibly fractional) pixel in V, its z component 1: the parameter along the
    /// ray is the depth.
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        Vector3::new((u - self.cx) / self.fx, (v - self.cy) / self.fy, 1.0)
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }
}
