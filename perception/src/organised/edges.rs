//! What ends the faces of a depth image: the picture that [`crate::edges`] walks over.

use nalgebra::Point2;
use surfaces::EdgeKind;

use super::image::InverseImage;
use super::plane::Plane;
use crate::edges::{self, Picture, Shown};
use crate::scan::DepthImage;
use crate::sensor::Noise;

/// A depth image with its labels before edges were taken off.
pub(super) struct Seen<'a> {
    depth: &'a DepthImage,
    image: &'a InverseImage,
    labels: &'a [u16],
    planes: &'a [Option<Plane>],
    noise: &'a Noise,
    /// First column and row in which something was measured, and one past the last.
    columns: (f64, f64),
    rows: (f64, f64),
}

impl<'a> Seen<'a> {
    pub fn new(
        depth: &'a DepthImage,
        image: &'a InverseImage,
        labels: &'a [u16],
        planes: &'a [Option<Plane>],
        noise: &'a Noise,
    ) -> Self {
        let width = depth.width.max(1);
        let lines = || depth.z_m.chunks_exact(width);
        let measured = |z: &f32| *z > 0.0;
        let top = lines().position(|line| line.iter().any(measured));
        let bottom = lines().rposition(|line| line.iter().any(measured));
        // Columns to the left and to the right of all that was measured so far.
        let (mut left, mut right) = (width, 0);
        for line in lines() {
            if let Some(first) = line[..left].iter().position(measured) {
                left = first;
            }
            if let Some(last) = line[right..].iter().rposition(measured) {
                right += last;
            }
        }
        Self {
            depth,
            image,
            labels,
            planes,
            noise,
            columns: (left as f64, (right + 1) as f64),
            rows: (top.unwrap_or(0) as f64, (bottom.unwrap_or(0) + 1) as f64),
        }
    }
}

impl Picture for Seen<'_> {
    fn at(&self, p: &Point2<f64>) -> Shown {
        // Pixels have their middles at whole numbers; a call of `round` costs more than the rest.
        let (u, v) = (p.x + 0.5, p.y + 0.5);
        // Half a pixel before the first one is outside.
        let inside = |x: f64, (low, end): (f64, f64)| x > 0.0 && (low..end).contains(&x);
        if !inside(u, self.columns) || !inside(v, self.rows) {
            return Shown::Outside;
        }
        let i = v as usize * self.depth.width + u as usize;
        let z = f64::from(self.depth.z_m[i]);
        if z > 0.0 {
            Shown::Point {
                w: 1.0 / z,
                label: self.labels[i],
                used: self.image.w[i] > 0.0,
            }
        } else {
            Shown::Nothing
        }
    }

    fn plane(&self, label: u16, p: &Point2<f64>) -> Option<f64> {
        let plane = self.planes.get(usize::from(label))?.as_ref()?;
        let (u0, v0) = self.image.centre;
        Some(plane.inverse.at(p.x - u0, p.y - v0)).filter(|w| *w > 0.0)
    }

    fn pixel_rad(&self) -> f64 {
        1.0 / self.image.intrinsics.fx
    }

    fn noise(&self) -> &Noise {
        self.noise
    }
}

/// What ends a face at the edges of its rings.
#[derive(Clone)]
pub(super) struct Edges {
    /// The kind of each edge of each ring.
    pub kinds: Vec<Vec<EdgeKind>>,
    /// How far inside the true edge each lies, as an angle, rad.
    pub inside_rad: Vec<Vec<f64>>,
}

impl Edges {
    /// Of rings that have the face on their left where v is up.
    pub fn new(seen: &Seen, label: u16, rings: &[Vec<Point2<f64>>]) -> Self {
        let found: Vec<_> = (rings.iter())
            .map(|ring| edges::kinds(seen, label, ring, true))
            .collect();
        let pixel_rad = seen.pixel_rad();
        let inside = |(_, px): &(EdgeKind, f64)| px * pixel_rad;
        Self {
            kinds: (found.iter())
                .map(|ring| ring.iter().map(|(kind, _)| *kind).collect())
                .collect(),
            inside_rad: (found.iter())
                .map(|ring| ring.iter().map(inside).collect())
                .collect(),
        }
    }
}
