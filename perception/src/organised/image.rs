//! The inverse-depth image and its cells.

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
    /// The image of 1/z for points within `range_max_m` of the sensor (along the ray).
    pub fn new(depth: &DepthImage, range_max_m: f64) -> Self {
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
        let mut inverse = vec![0.0_f32; width * height];
        let rows = inverse
            .chunks_exact_mut(width.max(1))
            .zip(depth.z_m.chunks_exact(width.max(1)));
        for ((out, z), y) in rows.zip(&yy) {
            for ((out, &z), x) in out.iter_mut().zip(z).zip(&xx) {
                let w = 1.0 / z;
                let seen = (z > 0.0) & (w * w >= x + y + zz);
                *out = if seen { w } else { 0.0 };
            }
        }
        let centre = ((width / 2) as f64, (height / 2) as f64);
        Self {
            width,
            height,
            w: inverse,
            intrinsics: k,
            centre,
        }
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
    /// One pass over the pixels: the moments of every small cell.
    pub fn new(image: &InverseImage) -> Self {
        let (cols, rows) = (image.width / CELL_PX, image.height / CELL_PX);
        let mut cells = vec![Moments::default(); cols * rows];
        if cols == 0 {
            return Self {
                cols,
                rows,
                size: CELL_PX,
                cells,
            };
        }
        let bands = image.w.chunks_exact(image.width * CELL_PX);
        for (j, (row, band)) in cells.chunks_exact_mut(cols).zip(bands).enumerate() {
            let y0 = (j * CELL_PX) as f64 - image.centre.1;
            for (i, cell) in row.iter_mut().enumerate() {
                let x0 = (i * CELL_PX) as f64 - image.centre.0;
                let line = |k: usize| {
                    let start = k * image.width + i * CELL_PX;
                    let mut line = [0.0; CELL_PX];
                    line.copy_from_slice(&band[start..start + CELL_PX]);
                    line
                };
                *cell = moments(&[line(0), line(1), line(2), line(3)], x0, y0);
            }
        }
        Self {
            cols,
            rows,
            size: CELL_PX,
            cells,
        }
    }

    /// The grid of cells twice as large.
    pub fn coarser(&self) -> Self {
        let (cols, rows) = (self.cols / 2, self.rows / 2);
        let mut cells = vec![Moments::default(); cols * rows];
        for (i, cell) in cells.iter_mut().enumerate() {
            let corner = 2 * (i / cols) * self.cols + 2 * (i % cols);
            for k in [
                corner,
                corner + 1,
                corner + self.cols,
                corner + self.cols + 1,
            ] {
                if let Some(small) = self.cells.get(k) {
                    cell.add(small, 1.0);
                }
            }
        }
        Self {
            cols,
            rows,
            size: 2 * self.size,
            cells,
        }
    }

    /// The cells that touch cell `i` by a side (4) or also by a corner (8).
    pub fn neighbours(&self, i: usize, corners: bool) -> impl Iterator<Item = usize> + use<> {
        const AROUND: [(i32, i32); 8] = [
            (0, -1),
            (-1, 0),
            (1, 0),
            (0, 1),
            (-1, -1),
            (1, -1),
            (-1, 1),
            (1, 1),
        ];
        // 32 bits divide in half the time, and a grid has far fewer cells.
        let (cols, rows) = (self.cols as i32, self.rows as i32);
        let (x, y) = (i as i32 % cols, i as i32 / cols);
        let count = if corners { 8 } else { 4 };
        AROUND.into_iter().take(count).filter_map(move |(dx, dy)| {
            let (x, y) = (x + dx, y + dy);
            ((0..cols).contains(&x) && (0..rows).contains(&y)).then(|| (y * cols + x) as usize)
        })
    }
}

/// The moments of the pixels of one cell, whose first is at (x0, y0).
fn moments(lines: &[[f32; CELL_PX]; CELL_PX], x0: f64, y0: f64) -> Moments {
    let mut seen = [true; CELL_PX];
    for line in lines {
        for j in 0..CELL_PX {
            seen[j] &= line[j] > 0.0;
        }
    }
    if seen != [true; CELL_PX] {
        let mut sums = Moments::default();
        for (k, line) in lines.iter().enumerate() {
            for (j, &w) in line.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                sums.push(x0 + j as f64, y0 + k as f64, w.into());
            }
        }
        return sums;
    }
    // Four columns at once, of the differences to one pixel: small numbers, for which 32 bits do.
    let reference = lines[0][0];
    let less = |line: &[f32; CELL_PX]| line.map(|w| w - reference);
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| less(&lines[k]));
    let (mut sum, mut square, mut down) =
        ([0.0_f32; CELL_PX], [0.0_f32; CELL_PX], [0.0_f32; CELL_PX]);
    for j in 0..CELL_PX {
        sum[j] = (a[j] + b[j]) + (c[j] + d[j]);
        square[j] = (a[j] * a[j] + b[j] * b[j]) + (c[j] * c[j] + d[j] * d[j]);
        down[j] = b[j] + 2.0 * c[j] + 3.0 * d[j];
    }
    let across = |line: &[f32; CELL_PX]| f64::from((line[0] + line[1]) + (line[2] + line[3]));
    let along = f64::from(sum[1] + 2.0 * sum[2] + 3.0 * sum[3]);
    let (w0, sum, square, down) = (
        f64::from(reference),
        across(&sum),
        across(&square),
        across(&down),
    );
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_moments_of_its_pixels() {
        let mut lines = [[0.0_f32; CELL_PX]; CELL_PX];
        for (k, j) in (0..CELL_PX).flat_map(|k| (0..CELL_PX).map(move |j| (k, j))) {
            lines[k][j] = 0.4 + 0.003 * j as f32 - 0.001 * (k * k) as f32;
        }
        let mut holed = lines;
        (holed[1][2], holed[3][0]) = (0.0, 0.0);
        for lines in [lines, holed] {
            let (x0, y0) = (-120.0, 76.0);
            let mut sums = Moments::default();
            for (k, line) in lines.iter().enumerate() {
                for (j, &w) in line.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                    sums.push(x0 + j as f64, y0 + k as f64, w.into());
                }
            }
            let got = moments(&lines, x0, y0);
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
