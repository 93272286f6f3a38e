//! Labels of pixels, written cell by cell.

use std::ops::Range;

use wide::bytemuck::cast;
use wide::{f32x8, i16x8, i32x8, u16x8};

use super::cell::{CellNoise, coefficients, unevenness};
use super::image::{CELL_PX, Grid, InverseImage};
use super::moments::Moments;
use super::moments::Region;
use super::words::packed_16;
use crate::segmentation::{NONE, ON_PLANE};
use crate::sensor::Noise;

/// Writes labels cell by cell.
pub(super) struct Labelling<'a> {
    image: &'a InverseImage,
    /// Coefficients of each region's plane, and what its unevenness adds to `limits`, as a part of the square of
    /// inverse depth.
    planes: Vec<([f32; 3], f32)>,
    /// Columns of cells.
    cols: usize,
    /// For each cell the square of the distance within which its pixels belong to an even plane, and that of its
    /// inverse depth.
    limits: Vec<(f32, f32)>,
    /// The label of every pixel; a margin of the image narrower than a cell has none.
    pub pixels: Vec<u16>,
    /// Of the row of cells that is being painted: what the planes take, and for each column of pixels
    /// how far its plane has risen since the first of the run, and the square of the distance within
    /// which pixels belong to it.
    runs: Vec<Run>,
    rise: Vec<f32>,
    limit: Vec<f32>,
}

impl<'a> Labelling<'a> {
    pub fn new(image: &'a InverseImage, grid: &Grid, regions: &[Region], noise: &Noise) -> Self {
        let lens = image.lens();
        let plane = |region: &Region| {
            let uneven = ON_PLANE.1 * ON_PLANE.1 * unevenness(&lens, &region.plane, noise);
            (coefficients(&region.plane), uneven as f32)
        };
        // First all means: the limits are then found side by side.
        let means: Vec<f64> = grid.cells.iter().map(Moments::mean).collect();
        let limits = (means.iter()).map(|w| (limit(*w, 0.0, noise) as f32, (w * w) as f32));
        Self {
            image,
            planes: regions.iter().map(plane).collect(),
            cols: grid.cols,
            limits: limits.collect(),
            pixels: vec![NONE; image.w.len()],
            runs: Vec::new(),
            rise: vec![0.0; image.width],
            limit: vec![0.0; image.width],
        }
    }

    /// A pixel's coordinates as planes have them.
    fn place(&self, u: usize, v: usize) -> (f32, f32) {
        let (u0, v0) = self.image.centre;
        ((u as f64 - u0) as f32, (v as f64 - v0) as f32)
    }

    /// Has a plane painted in some of a row of cells.
    pub fn take(&mut self, label: u16, y: usize, columns: Range<usize>) {
        let ([a, b, c], uneven) = self.planes[usize::from(label)];
        let (u0, end) = (columns.start * CELL_PX, columns.end * CELL_PX);
        let (x0, y0) = self.place(u0, y * CELL_PX);
        let rise = self.rise[u0..end].iter_mut();
        for (rise, i) in rise.zip(0..) {
            *rise = a * i as f32;
        }
        let limits = &self.limits[y * self.cols..][columns];
        let limit = self.limit[u0..end].as_chunks_mut::<CELL_PX>().0;
        for (limit, (even, square)) in limit.iter_mut().zip(limits) {
            *limit = [even + uneven * square; CELL_PX];
        }
        self.runs.push(Run {
            label,
            columns: u0..end,
            first: a * x0 + (b * y0 + c),
            down: b,
        });
    }

    /// Paints what the planes took of a row of cells, line by line: the image is far from any cache.
    pub fn paint(&mut self, y: usize) {
        self.runs.sort_unstable_by_key(|run| run.columns.start);
        for k in 0..CELL_PX {
            let start = (y * CELL_PX + k) * self.image.width;
            for run in &self.runs {
                let columns = run.columns.clone();
                let line = Line {
                    label: run.label,
                    first: run.first + run.down * k as f32,
                    rise: &self.rise[columns.clone()],
                    limit: &self.limit[columns.clone()],
                };
                let w = &self.image.w[start..][columns.clone()];
                line.paint(w, &mut self.pixels[start..][columns]);
            }
        }
        self.runs.clear();
    }

    /// The nearest of several planes to each pixel of a cell.
    pub fn cell(&mut self, x: usize, y: usize, candidates: &[u16]) {
        let (u0, v0) = (x * CELL_PX, y * CELL_PX);
        let (x0, y0) = self.place(u0, v0);
        let start = |k: usize| (v0 + k) * self.image.width + u0;
        // Square of the distance to the nearest plane, and which it is; four pixels at once.
        let (even, square_w) = self.limits[y * self.cols + x];
        let mut best = [[f32::INFINITY; CELL_PX]; CELL_PX];
        let mut won = [[u32::from(NONE); CELL_PX]; CELL_PX];
        let mut lines = [[0.0_f32; CELL_PX]; CELL_PX];
        for (k, line) in lines.iter_mut().enumerate() {
            line.copy_from_slice(&self.image.w[start(k)..][..CELL_PX]);
        }
        for &candidate in candidates {
            let ([a, b, c], uneven) = self.planes[usize::from(candidate)];
            let limit = even + uneven * square_w;
            let first = a * x0 + (b * y0 + c);
            for k in 0..CELL_PX {
                let first = first + b * k as f32;
                for j in 0..CELL_PX {
                    let w = lines[k][j];
                    let e = a * j as f32 + first - w;
                    let square = e * e;
                    let better = (square < best[k][j].min(limit)) & (w > 0.0);
                    best[k][j] = if better { square } else { best[k][j] };
                    won[k][j] = if better { candidate.into() } else { won[k][j] };
                }
            }
        }
        for (k, won) in won.iter().enumerate() {
            let labels = won.map(|label| label as u16);
            self.pixels[start(k)..][..CELL_PX].copy_from_slice(&labels);
        }
    }

    /// The first of the candidates that half of a cell's pixels have at least, or [`NONE`].
    pub fn most(&self, x: usize, y: usize, candidates: &[u16]) -> u16 {
        let mut labels = [NONE; CELL_PX * CELL_PX];
        for (k, line) in labels.chunks_exact_mut(CELL_PX).enumerate() {
            let start = (y * CELL_PX + k) * self.image.width + x * CELL_PX;
            line.copy_from_slice(&self.pixels[start..][..CELL_PX]);
        }
        let half = |label: &&u16| {
            let same = packed_16(&labels, &labels, |its, _| its == **label);
            2 * same.count_ones() as usize >= labels.len()
        };
        candidates.iter().find(half).copied().unwrap_or(NONE)
    }
}

/// One plane in some columns of the image.
struct Run {
    label: u16,
    columns: Range<usize>,
    /// Its inverse depth at the first pixel, and how far it rises from line to line.
    first: f32,
    down: f32,
}

/// One plane along a line of pixels.
struct Line<'a> {
    label: u16,
    /// Its inverse depth at the first pixel, and how far it has risen at each.
    first: f32,
    rise: &'a [f32],
    /// Square of the distance within which a pixel belongs to it.
    limit: &'a [f32],
}

impl Line<'_> {
    /// The label to the pixels that lie on the plane, [`NONE`] to the others; all slices are of one
    /// length.
    fn paint(&self, w: &[f32], out: &mut [u16]) {
        let (rises, rise) = self.rise.as_chunks();
        let (limits, limit) = self.limit.as_chunks();
        let ((ws, w), (outs, out)) = (w.as_chunks(), out.as_chunks_mut());
        for (((out, w), rise), limit) in outs.iter_mut().zip(ws).zip(rises).zip(limits) {
            *out = self.eight(w, rise, limit);
        }
        for (((out, &w), rise), &limit) in out.iter_mut().zip(w).zip(rise).zip(limit) {
            let e = self.first + rise - w;
            let on = (e * e < limit) & (w > 0.0);
            *out = if on { self.label } else { NONE };
        }
    }

    /// The labels of eight pixels.
    fn eight(&self, w: &[f32; 8], rise: &[f32; 8], limit: &[f32; 8]) -> [u16; 8] {
        let [w, rise, limit] = [w, rise, limit].map(|eight| f32x8::from(*eight));
        let e = rise + self.first - w;
        // All bits are set where a pixel is not on the plane, as they are in NONE.
        let on: i32x8 = cast((e * e).simd_lt(limit) & w.simd_gt(f32x8::ZERO));
        let off: u16x8 = cast(!i16x8::from_i32x8_saturate(on));
        (off | u16x8::splat(self.label)).to_array()
    }
}

/// The square of the distance within which a plane may claim pixels, 1/m², for those of a cell of mean inverse depth `w`, 1/m,
/// and a plane's [`unevenness`]; nothing
/// is nearer than that of a cell without a pixel.
#[inline]
pub(super) fn limit(w: f64, uneven: f64, noise: &Noise) -> f64 {
    CellNoise::at(noise, w, uneven).square(ON_PLANE.0, ON_PLANE.1)
}
