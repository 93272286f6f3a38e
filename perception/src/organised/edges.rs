//! What ends the faces of a depth image: the picture that [`crate::edges`] walks over.

use nalgebra::Point2;
use surfaces::EdgeKind;

use super::image::InverseImage;
use super::mask::EDGE_SEEN_PX;
use super::plane::Plane;
use crate::edges::{self, Found, Picture, Shown};
use crate::scan::DepthImage;
use crate::sensor::Noise;

/// A depth image with its labels before edges were taken off.
pub(super) struct Seen<'a> {
    /// Depth, inverse depth and label of each pixel, row by row.
    z_m: &'a [f32],
    w: &'a [f32],
    labels: &'a [u16],
    width: usize,
    /// Column and row of the origin of the planes' pixel coordinates.
    centre: (f64, f64),
    pixel_rad: f64,
    planes: &'a [Option<Plane>],
    noise: &'a Noise,
    /// First column and row in which something was measured, and how many there are from it on.
    first: (u32, u32),
    count: (u32, u32),
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
            z_m: &depth.z_m,
            w: &image.w,
            labels,
            width: image.width,
            centre: image.centre,
            pixel_rad: 1.0 / image.intrinsics.fx,
            planes,
            noise,
            first: (left as u32, top.unwrap_or(0) as u32),
            count: (
                (right + 1).saturating_sub(left) as u32,
                bottom.map_or(0, |bottom| bottom + 1 - top.unwrap_or(0)) as u32,
            ),
        }
    }

    /// The index of a pixel; `None` outside of what was measured.
    #[inline]
    fn index(&self, [u, v]: [i32; 2]) -> Option<usize> {
        let (u, v) = (u as u32, v as u32);
        let inside = (u.wrapping_sub(self.first.0) < self.count.0)
            & (v.wrapping_sub(self.first.1) < self.count.1);
        inside.then_some(v as usize * self.width + u as usize)
    }
}

impl Picture for Seen<'_> {
    #[inline]
    fn at(&self, label: u16, pixel: [i32; 2]) -> Shown {
        let Some(i) = self.index(pixel) else {
            return Shown::Outside;
        };
        // The labels first, which are all that most steps need: the images are far from any cache.
        let its = self.labels[i];
        if its == label {
            return Shown::Face;
        }
        let other = |w: f32, used| Shown::Other {
            w: w.into(),
            label: its,
            used,
        };
        let w = self.w[i];
        if w > 0.0 {
            return other(w, true);
        }
        let z = self.z_m[i];
        if z > 0.0 {
            other(1.0 / z, false)
        } else {
            Shown::Nothing
        }
    }

    #[inline]
    fn on(&self, label: u16, pixel: [i32; 2]) -> Option<f64> {
        let i = self.index(pixel).filter(|i| self.labels[*i] == label)?;
        Some(f64::from(self.w[i])).filter(|w| *w > 0.0)
    }

    #[inline]
    fn plane(&self, label: u16, p: &Point2<f64>) -> Option<f64> {
        let plane = self.planes.get(usize::from(label))?.as_ref()?;
        let (u0, v0) = self.centre;
        Some(plane.inverse.at(p.x - u0, p.y - v0)).filter(|w| *w > 0.0)
    }

    fn pixel_rad(&self) -> f64 {
        self.pixel_rad
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

/// More than this no outline is surely inside the true edge, px: what was taken off. What its label covers beyond may be
/// another's, within the noise of its plane: the front of a board, the floor at a ramp's foot. Where planes meet it is
/// known.
const INSIDE_MAX_PX: f64 = EDGE_SEEN_PX as f64;

impl Edges {
    /// Of rings that have the face on their left where v is up.
    pub fn new(seen: &Seen, label: u16, rings: &[Vec<Point2<f64>>]) -> Self {
        let pixel_rad = seen.pixel_rad();
        let inside_px = |end: &Found| match end.meet {
            true => end.at_px,
            false => end.at_px.min(INSIDE_MAX_PX),
        };
        let of_ring = |ring: &Vec<_>| -> (Vec<_>, Vec<_>) {
            let ends = edges::kinds(seen, label, ring, true);
            ends.map(|end| (end.kind, inside_px(&end) * pixel_rad))
                .unzip()
        };
        let (kinds, inside_rad) = rings.iter().map(of_ring).unzip();
        Self { kinds, inside_rad }
    }
}
