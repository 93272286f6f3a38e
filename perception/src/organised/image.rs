//! The inverse-depth image and its cells.

use wide::f32x4;

use super::moments::Moments;
use crate::scan::{DepthImage, Intrinsics};

/// Side of the small cells, px; large cells are 2 × 2 of them.
pub(super) const CELL_PX: usize = 4;

/// Inverse depth on the pixel grid, 1/m; 0 where nothing was measured or beyond the range.
pub(super) struct InverseImage {
    pub width: usize,
    pub height: usize,
    pub w: Vec<f32>,
    pub intrinsics: Intrinsics,
    /// Column and row of the origin of the planes' pixel coordinates.
    pub centre: (f64, f64),
}

impl InverseImage {
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
    pub cells: Vec<Moments>,
}

impl Grid {
    /// One pass over the pixels: the moments of every small cell, in the room of a vector that is no
    /// longer needed.
    pub fn new(image: &InverseImage, mut cells: Vec<Moments>) -> Self {
        let (cols, rows) = (image.width / CELL_PX, image.height / CELL_PX);
        cells.resize(cols * rows, Moments::default());
        let bands = image.w.chunks_exact((image.width * CELL_PX).max(1));
        for (j, (row, band)) in cells.chunks_exact_mut(cols.max(1)).zip(bands).enumerate() {
            let lines = [0, 1, 2, 3].map(|k| &band[k * image.width..][..cols * CELL_PX]);
            let y0 = (j * CELL_PX) as f64 - image.centre.1;
            for (i, cell) in row.iter_mut().enumerate() {
                let x0 = (i * CELL_PX) as f64 - image.centre.0;
                *cell = of_cell(lines.map(|line| line.as_chunks().0[i]), x0, y0);
            }
        }
        Self {
            cols,
            rows,
            size: CELL_PX,
            cells,
        }
    }

    /// The grid of cells twice as large, in the room of a vector that is no longer needed.
    pub fn coarser(&self, mut cells: Vec<Moments>) -> Self {
        let (cols, rows) = (self.cols / 2, self.rows / 2);
        cells.resize(cols * rows, Moments::default());
        let bands = self.cells.chunks_exact((2 * self.cols).max(1));
        for (row, band) in cells.chunks_exact_mut(cols.max(1)).zip(bands) {
            let (above, below) = band.split_at(self.cols);
            let (above, below) = (above.as_chunks().0, below.as_chunks().0);
            for (cell, ([a, b], [c, d])) in row.iter_mut().zip(above.iter().zip(below)) {
                *cell = *a;
                [b, c, d].iter().for_each(|part| cell.add(part, 1.0));
            }
        }
        Self {
            cols,
            rows,
            size: 2 * self.size,
            cells,
        }
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

/// The moments of a cell's pixels, the first of which is at (x0, y0).
fn of_cell(lines: [[f32; CELL_PX]; CELL_PX], x0: f64, y0: f64) -> Moments {
    let [a, b, c, d] = lines.map(f32x4::from);
    let least = a.fast_min(b).fast_min(c.fast_min(d)).to_array();
    if least.iter().any(|w| *w <= 0.0) {
        return holed(lines, x0, y0);
    }
    // Differences to one of them are small numbers, for which 32 bits do.
    let base = lines[0][0];
    let [e, f, g, h] = [a, b, c, d].map(|line| line - f32x4::splat(base));
    let sums = ((e + f) + (g + h)).to_array();
    let squares = ((e * e + f * f) + (g * g + h * h)).to_array();
    let down = (f + f32x4::splat(2.0) * g + f32x4::splat(3.0) * h).to_array();
    let (w0, sum) = (f64::from(base), across(sums));
    let (square, down, along) = (across(squares), across(down), along(sums));
    // Of 16 pixels: Σ 1 = 16, Σ k = 24, Σ k² = 56, Σ j k = 36.
    let (n, one, two, both) = (16.0, 24.0, 56.0, 36.0);
    let w = sum + n * w0;
    Moments {
        n,
        u: one + n * x0,
        v: one + n * y0,
        uu: two + x0 * (2.0 * one + n * x0),
        uv: both + one * (x0 + y0) + n * x0 * y0,
        vv: two + y0 * (2.0 * one + n * y0),
        w,
        uw: along + one * w0 + w * x0,
        vw: down + one * w0 + w * y0,
        ww: square + w0 * (2.0 * sum + n * w0),
    }
}

/// The moments of those of a cell's pixels that were measured; the first is at (x0, y0).
pub(super) fn holed(lines: [[f32; CELL_PX]; CELL_PX], x0: f64, y0: f64) -> Moments {
    let [a, b, c, d] = lines.map(f32x4::from);
    // About the largest, so that the sums are of small numbers, for which 32 bits do.
    let [e, f, g, h] = a.fast_max(b).fast_max(c.fast_max(d)).to_array();
    let base = e.max(f).max(g.max(h));
    if base <= 0.0 {
        return Moments::default();
    }
    // One where there is a measurement, and its difference.
    let one = |line: f32x4| line.simd_gt(f32x4::ZERO) & f32x4::ONE;
    let (p, q, r, s) = (one(a), one(b), one(c), one(d));
    let rest = f32x4::splat(base);
    let (a, b, c, d) = (
        (a - rest) * p,
        (b - rest) * q,
        (c - rest) * r,
        (d - rest) * s,
    );
    // Down the columns, k the row: Σ 1, Σ k, Σ k², Σ w, Σ k w and Σ w²; then along the row of sums.
    let (two, three) = (f32x4::splat(2.0), f32x4::splat(3.0));
    let n = ((p + q) + (r + s)).to_array();
    let down = (q + two * r + three * s).to_array();
    let downs = (q + f32x4::splat(4.0) * r + f32x4::splat(9.0) * s).to_array();
    let w = ((a + b) + (c + d)).to_array();
    let down_w = (b + two * c + three * d).to_array();
    let square = ((a * a + b * b) + (c * c + d * d)).to_array();
    let (count, u, v) = (across(n), along(n), across(down));
    let (sum, base) = (across(w), f64::from(base));
    let local = Moments {
        n: count,
        u,
        v,
        uu: f64::from(n[1] + 4.0 * n[2] + 9.0 * n[3]),
        uv: along(down),
        vv: across(downs),
        w: sum + count * base,
        uw: along(w) + u * base,
        vw: across(down_w) + v * base,
        ww: across(square) + base * (2.0 * sum + count * base),
    };
    local.moved(x0, y0)
}

/// Sum of a row.
fn across([a, b, c, d]: [f32; CELL_PX]) -> f64 {
    f64::from((a + b) + (c + d))
}

/// Sum of a row, each times its column.
fn along([_, b, c, d]: [f32; CELL_PX]) -> f64 {
    f64::from(b + 2.0 * c + 3.0 * d)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_moments_of_its_pixels() {
        let mut lines = [[0.0_f32; CELL_PX]; CELL_PX];
        for (k, j) in (0..CELL_PX).flat_map(|k| (0..CELL_PX).map(move |j| (k, j))) {
            lines[k][j] = 0.4 + 0.003 * j as f32 - 0.001 * (k * k) as f32;
        }
        let mut other = lines;
        (other[1][2], other[3][0]) = (0.0, 0.0);
        for lines in [lines, other] {
            let (x0, y0) = (-120.0, 76.0);
            let mut sums = Moments::default();
            for (k, line) in lines.iter().enumerate() {
                for (j, &w) in line.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    sums.push(x0 + j as f64, y0 + k as f64, w.into());
                }
            }
            let got = of_cell(lines, x0, y0);
            for (a, b) in [
                (got.n, sums.n),
                (got.u, sums.u),
                (got.v, sums.v),
                (got.uu, sums.uu),
                (got.uv, sums.uv),
                (got.vv, sums.vv),
                (got.w, sums.w),
                (got.uw, sums.uw),
                (got.vw, sums.vw),
                (got.ww, sums.ww),
            ] {
                // Differences of 0.01 in 32 bits.
                assert!((a - b).abs() <= 1e-9 * b.abs(), "{got:?} {sums:?}");
            }
        }
    }
}
