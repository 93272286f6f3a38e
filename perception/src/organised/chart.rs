//! Coordinates on a face's plane.

use nalgebra::{Point2, Point3, Rotation3, Vector3};

use super::image::InverseImage;
use super::plane::Plane;
use crate::scan::tangent_frame;

/// Where the plane has the points of pixels, in coordinates P that depend on the sensor only: its
/// origin is the foot of the sensor, z toward it.
pub(super) struct Chart<'a> {
    plane: &'a Plane,
    centre: (f64, f64),
    /// Orientation of P in V.
    pub R_VP: Rotation3<f64>,
    /// The plane's point that is nearest to the sensor, in V, m.
    pub foot: Point3<f64>,
    /// x and y of the ray (…, …, 1) of a pixel in P: a u + b v + c.
    rays: [[f64; 3]; 2],
}

impl<'a> Chart<'a> {
    pub fn new(image: &InverseImage, plane: &'a Plane) -> Self {
        let toward = -plane.normal;
        let frame = tangent_frame(&toward, &Vector3::z(), &-Vector3::y());
        let R_VP = Rotation3::from_matrix_unchecked(frame);
        let k = image.intrinsics;
        // The foot is on P's z axis: it moves neither x nor y.
        let ray = |axis: usize| {
            let r = R_VP.matrix().column(axis);
            let (a, b) = (r[0] / k.fx, r[1] / k.fy);
            [a, b, r[2] - a * k.cx - b * k.cy]
        };
        Self {
            plane,
            centre: image.centre,
            R_VP,
            foot: Point3::from(plane.normal * plane.distance),
            rays: [ray(0), ray(1)],
        }
    }

    /// The point of a pixel, and its inverse depth; `None` if the ray does not meet the plane.
    #[inline]
    pub fn at(&self, u: f64, v: f64) -> Option<(Point2<f64>, f64)> {
        let w = self.plane.inverse.at(u - self.centre.0, v - self.centre.1);
        let z = 1.0 / w;
        let q = self.rays.map(|[a, b, c]| (a * u + b * v + c) * z);
        (w > 1e-6).then_some((q.into(), w))
    }
}
