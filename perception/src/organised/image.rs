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
                let seen = z > 0.0 && w > 0.0 && w * w >= x + y + zz;
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

    /// Inverse depth at a pixel that lies in the image; 0 where nothing was measured.
    pub fn at(&self, u: usize, v: usize) -> f32 {
        self.w.get(v * self.width + u).copied().unwrap_or(0.0)
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
        for (v, line) in image
            .w
            .chunks_exact(image.width)
            .take(rows * CELL_PX)
            .enumerate()
        {
            let y = v as f64 - image.centre.1;
            let start = (v / CELL_PX) * cols;
            let Some(row) = cells.get_mut(start..start + cols) else {
                break;
            };
            for (i, (cell, pixels)) in row.iter_mut().zip(line.chunks_exact(CELL_PX)).enumerate() {
                // Sums over the four pixels of this row of the cell, about its first column.
                let (mut n, mut k, mut kk) = (0.0, 0.0, 0.0);
                let (mut w, mut kw, mut ww) = (0.0, 0.0, 0.0);
                for (j, &pixel) in pixels.iter().enumerate() {
                    let x = j as f64;
                    let p = f64::from(pixel);
                    let seen = if pixel > 0.0 { 1.0 } else { 0.0 };
                    n += seen;
                    k += seen * x;
                    kk += seen * x * x;
                    w += p;
                    kw += p * x;
                    ww += p * p;
                }
                let x0 = (i * CELL_PX) as f64 - image.centre.0;
                let u = k + n * x0;
                cell.n += n;
                cell.u += u;
                cell.v += n * y;
                cell.uu += kk + 2.0 * x0 * k + n * x0 * x0;
                cell.uv += u * y;
                cell.vv += n * y * y;
                cell.w += w;
                cell.uw += kw + w * x0;
                cell.vw += w * y;
                cell.ww += ww;
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
        const AROUND: [(i64, i64); 8] = [
            (0, -1),
            (-1, 0),
            (1, 0),
            (0, 1),
            (-1, -1),
            (1, -1),
            (-1, 1),
            (1, 1),
        ];
        let (cols, rows) = (self.cols as i64, self.rows as i64);
        let (x, y) = (i as i64 % cols, i as i64 / cols);
        let count = if corners { 8 } else { 4 };
        AROUND.into_iter().take(count).filter_map(move |(dx, dy)| {
            let (x, y) = (x + dx, y + dy);
            ((0..cols).contains(&x) && (0..rows).contains(&y)).then(|| (y * cols + x) as usize)
        })
    }
}
