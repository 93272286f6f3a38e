//! The inverse-depth image and its cells.

use nalgebra::Vector3;

use super::moments::{InversePlane, Moments};
pub(super) use super::pixels::CELL_PX;
use super::pixels::{Column, of_row};
use crate::scan::DepthImage;
use crate::sensor::Intrinsics;

/// Inverse depth on the pixel grid, 1/m; 0 where nothing was measured or beyond the range.
pub(super) struct InverseImage {
    pub width: usize,
    pub height: usize,
    pub w: Vec<f32>,
    pub intrinsics: Intrinsics,
    /// Column and row of the origin of the planes' pixel coordinates.
    pub centre: (f64, f64),
}

/// How the pixels of planes become rays: focal lengths, and the principal point as planes count, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    f: (f64, f64),
    axis: (f64, f64),
}

impl Lens {
    /// n/d of the plane n·p = d in the sensor's frame, with its normal n away from the sensor, 1/m.
    pub fn normal(&self, plane: &InversePlane) -> Vector3<f64> {
        let at_axis = plane.at(self.axis.0, self.axis.1);
        Vector3::new(plane.0.x * self.f.0, plane.0.y * self.f.1, at_axis)
    }
}

impl InverseImage {
    /// How its pixels become rays.
    pub fn lens(&self) -> Lens {
        let (k, (u0, v0)) = (self.intrinsics, self.centre);
        Lens {
            f: (k.fx, k.fy),
            axis: (k.cx - u0, k.cy - v0),
        }
    }

    /// The image of 1/z for points within `range_max_m` of the sensor (along the ray), in the room
    /// of a vector that is no longer needed; and how many pixels were measured, and how many of these
    /// are within the range.
    pub fn new(
        depth: &DepthImage,
        range_max_m: f64,
        mut inverse: Vec<f32>,
    ) -> (Self, usize, usize) {
        let k = depth.intrinsics;
        let (width, height) = (depth.width, depth.height);
        // |p| = z |ray| ≤ range  ⇔  w ≥ |ray| / range; |ray|² splits into a column's and a row's part.
        let squares = |n: usize, f: f64, c: f64| -> Vec<f32> {
            (0..n)
                .map(|i| (((i as f64 - c) / f / range_max_m).powi(2)) as f32)
                .collect()
        };
        let (xx, yy) = (squares(width, k.fx, k.cx), squares(height, k.fy, k.cy));
        let zz = (1.0 / (range_max_m * range_max_m)) as f32;
        inverse.resize(width * height, 0.0);
        let rows = inverse
            .chunks_exact_mut(width.max(1))
            .zip(depth.z_m.chunks_exact(width.max(1)));
        let (mut measured, mut used) = (0, 0);
        for ((out, z), y) in rows.zip(&yy) {
            // Counted in 32 bits, of which four fit side by side.
            let (mut measured_here, mut used_here) = (0_u32, 0_u32);
            for ((out, &z), x) in out.iter_mut().zip(z).zip(&xx) {
                let w = 1.0 / z;
                let seen = (z > 0.0) & (w * w >= x + y + zz);
                *out = if seen { w } else { 0.0 };
                measured_here += u32::from(z > 0.0);
                used_here += u32::from(seen);
            }
            measured += measured_here as usize;
            used += used_here as usize;
        }
        let centre = ((width / 2) as f64, (height / 2) as f64);
        let image = Self {
            width,
            height,
            w: inverse,
            intrinsics: k,
            centre,
        };
        (image, measured, used)
    }
}

/// Moments of square cells; a margin of the image narrower than a cell belongs to none.
pub(super) struct Grid {
    pub cols: usize,
    pub rows: usize,
    /// Side of a cell, px.
    pub size: usize,
    /// The number of pixels measured in the median cell that has any, by the small ones.
    pub usual: f64,
    pub cells: Vec<Moments>,
}

impl Grid {
    /// One pass over the pixels: the moments of every small cell, and of the cells twice as large, in the
    /// room of vectors that are no longer needed.
    pub fn both(image: &InverseImage, [mut small, mut large]: [Vec<Moments>; 2]) -> (Self, Self) {
        let (cols, rows) = (image.width / CELL_PX, image.height / CELL_PX);
        small.resize(cols * rows, Moments::default());
        large.resize((cols / 2) * (rows / 2), Moments::default());
        let places = (0..cols).map(|i| (i * CELL_PX) as f64 - image.centre.0);
        let columns: Vec<Column> = places.map(Column::new).collect();
        // How many cells, of every fourth, have so many pixels.
        let mut counts = [0_usize; CELL_PX * CELL_PX + 1];
        let mut larger = large.chunks_exact_mut((cols / 2).max(1));
        for (i, pair) in small.chunks_mut((2 * cols).max(1)).enumerate() {
            for (row, j) in pair.chunks_exact_mut(cols).zip(2 * i..) {
                let band = &image.w[j * CELL_PX * image.width..];
                let lines = [0, 1, 2, 3].map(|k| &band[k * image.width..][..cols * CELL_PX]);
                of_row(lines, &columns, (j * CELL_PX) as f64 - image.centre.1, row);
                (row.iter().step_by(4)).for_each(|cell| counts[cell.n as usize] += 1);
            }
            // Added up while they are near.
            let (above, below) = pair.split_at(cols);
            let (above, below) = (above.as_chunks().0, below.as_chunks().0);
            let row = larger.next().into_iter().flatten();
            for (cell, ([a, b], [c, d])) in row.zip(above.iter().zip(below)) {
                *cell = *a;
                [b, c, d].iter().for_each(|part| cell.add(part, 1.0));
            }
        }
        let mut fewer = 0;
        let middle = counts[1..].iter().sum::<usize>() / 2;
        let usual = (1..counts.len()).find(|n| {
            fewer += counts[*n];
            fewer > middle
        });
        let grid = |cells, times: usize| Self {
            cols: cols / times,
            rows: rows / times,
            size: times * CELL_PX,
            usual: (times * times * usual.unwrap_or(0)) as f64,
            cells,
        };
        (grid(small, 1), grid(large, 2))
    }

    /// Column and row of cell `i`.
    #[inline]
    pub fn place(&self, i: usize) -> (usize, usize) {
        // 32 bits divide in half the time, and a grid has far fewer cells.
        let (i, cols) = (i as u32, self.cols as u32);
        ((i % cols) as usize, (i / cols) as usize)
    }

    /// The cells that touch cell `i` by a side; itself where the grid ends.
    #[inline]
    pub fn beside(&self, i: usize) -> [usize; 4] {
        let (x, _) = self.place(i);
        let cell = |is: bool, k: usize| if is { k } else { i };
        [
            cell(i >= self.cols, i.wrapping_sub(self.cols)),
            cell(x > 0, i.wrapping_sub(1)),
            cell(x + 1 < self.cols, i + 1),
            cell(i + self.cols < self.cells.len(), i + self.cols),
        ]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The small and the large cells of a small image of these depths, m.
    pub fn grids_of(z: impl Fn(usize, usize) -> f64) -> (Lens, Grid, Grid) {
        let (width, height) = (160, 120);
        let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let depth = DepthImage {
            width,
            height,
            z_m: pixels.map(|(u, v)| z(u, v) as f32).collect(),
            intrinsics: Intrinsics {
                fx: 525.0,
                fy: 525.0,
                cx: 80.0,
                cy: 60.0,
            },
        };
        let (image, ..) = InverseImage::new(&depth, 10.0, Vec::new());
        let (small, large) = Grid::both(&image, Default::default());
        (image.lens(), small, large)
    }
}
