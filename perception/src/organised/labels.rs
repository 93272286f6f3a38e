//! Every pixel to the nearest of the planes around it.

use nalgebra::Vector3;

use super::bits::Bits;
use super::growth::{CellNoise, Region};
use super::image::{CELL_PX, Grid, InverseImage};
use super::moments::Moments;
use super::window::{OPEN, common, packed, single};
use crate::extraction::Segmentation;
use crate::sensor::Noise;

/// The label of a pixel that belongs to no plane.
pub(super) const NONE: u16 = Segmentation::NONE;

/// How far from the cells that were grown a plane may claim pixels, in cells.
const RINGS: usize = 3;
/// A pixel belongs to a plane within √((3σ)² + (2κw)²) of it.
pub(super) const SIGMAS: f64 = 3.0;
/// See [`SIGMAS`].
pub(super) const SYSTEMATICS: f64 = 2.0;

/// Index of the region that has most of each small cell, or [`NONE`].
pub(super) struct CellLabels(Vec<u16>);

/// The index of the region, or [`NONE`], for every pixel and for every small cell.
///
/// The pixels of a cell may go to the planes of the cell and of the eight cells around it, to the
/// nearest one; cells that went to no plane so far are reached ring by ring.
pub(super) fn label(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    noise: &Noise,
) -> (Vec<u16>, CellLabels) {
    let mut cells = vec![NONE; grid.cells.len()];
    for (r, region) in regions.iter().enumerate() {
        for &cell in &region.cells {
            cells[cell] = r as u16;
        }
    }
    let planes: Vec<[f32; 3]> = regions
        .iter()
        .map(|region| region.plane.0.map(|x| x as f32).into())
        .collect();
    let mut painter = Painter::new(image, grid, planes, noise);
    let mut several = Vec::new();
    // The grown cells: as many of a row at once as have one plane and no other around.
    let around = around(grid, &cells, 1);
    let mut left = Vec::new();
    let mut cell = 0;
    while cell < cells.len() {
        if cells[cell] == NONE {
            left.push(cell);
            cell += 1;
        } else if let Some(label) = single(around[cell]) {
            let end = (cell / grid.cols + 1) * grid.cols;
            let all = around[cell..end].iter().zip(&cells[cell..end]);
            let same = |(near, own): &(&u32, &u16)| **near == around[cell] && **own != NONE;
            let count = all.take_while(same).count();
            painter.run(cell, count, label);
            cell += count;
        } else {
            distinct::<3>(grid, &cells, cell, &mut several);
            painter.cell(cell, &several);
            cell += 1;
        }
    }
    // Then ring by ring what touches them.
    for _ in 0..RINGS {
        let mut more = Vec::new();
        left.retain(|&cell| {
            distinct::<3>(grid, &cells, cell, &mut several);
            if !several.is_empty() {
                painter.cell(cell, &several);
                more.push((cell, painter.most(cell, &several)));
            }
            several.is_empty()
        });
        for (cell, label) in more {
            cells[cell] = label;
        }
    }
    let pixels = painter.pixels;
    (pixels, CellLabels(cells))
}

/// The labels of the `N` × `N` cells around a cell, in ascending order.
fn distinct<const N: usize>(grid: &Grid, cells: &[u16], cell: usize, labels: &mut Vec<u16>) {
    let (x, y) = (
        cell as u32 % grid.cols as u32,
        cell as u32 / grid.cols as u32,
    );
    let (x, y, r) = (x as usize, y as usize, N / 2);
    labels.clear();
    let mut last = NONE;
    let mut add = |label: u16| {
        if label != last && label != NONE && !labels.contains(&label) {
            labels.push(label);
        }
        last = label;
    };
    let (left, right) = (x.saturating_sub(r), (x + r + 1).min(grid.cols));
    let mut before = [NONE; N];
    for y in y.saturating_sub(r)..(y + r + 1).min(grid.rows) {
        let row = &cells[y * grid.cols..][left..right];
        match row.first_chunk::<N>() {
            // Rows are often alike.
            Some(row) if *row == before => {}
            Some(row) => {
                row.iter().for_each(|label| add(*label));
                before = *row;
            }
            None => row.iter().for_each(|label| add(*label)),
        }
    }
    if labels.len() > 1 {
        labels.sort_unstable();
    }
}

/// What the labels of the cells within `r` of each cell have in common, those without one left out.
fn around(grid: &Grid, cells: &[u16], r: usize) -> Vec<u32> {
    let mut all = Vec::with_capacity(cells.len());
    let row = |y: usize, out: &mut [u32]| {
        for (out, &label) in out.iter_mut().zip(&cells[y * grid.cols..]) {
            *out = if label == NONE { OPEN } else { packed(label) };
        }
    };
    common((grid.cols, grid.rows), r, row, |_, line| all.extend(line));
    all
}

/// Takes off the sure pixels those where the plane of a neighbouring region is so close to theirs
/// that the slowly varying error may have drawn the border anywhere between: those within two
/// cells of that region where both planes agree to `doubt` κ w.
#[allow(clippy::too_many_arguments)]
pub(super) fn drop_doubtful(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    cells: &CellLabels,
    labels: &[u16],
    sure: &mut Bits,
    doubt: f64,
    noise: &Noise,
) {
    let near = around(grid, &cells.0, 2);
    let ratio = doubt * noise.systematic_ratio;
    let mixed = |cell: &usize| near[*cell] != OPEN && single(near[*cell]).is_none();
    let (mut owns, mut planes, mut doubtful) = (Vec::new(), Vec::new(), Vec::new());
    for cell in (0..near.len()).filter(mixed) {
        let (u0, v0) = ((cell % grid.cols) * CELL_PX, (cell / grid.cols) * CELL_PX);
        // The planes of its own pixels, against all those around.
        owns.clear();
        for v in v0..v0 + CELL_PX {
            for label in &labels[v * image.width + u0..][..CELL_PX] {
                if *label != NONE && owns.last() != Some(label) && !owns.contains(label) {
                    owns.push(*label);
                }
            }
        }
        if owns.is_empty() {
            continue;
        }
        distinct::<5>(grid, &cells.0, cell, &mut planes);
        let (x0, y0) = (u0 as f64 - image.centre.0, v0 as f64 - image.centre.1);
        let plane = |label: u16| regions[usize::from(label)].plane;
        // Where two planes are apart by more than the limit at all corners, to the same side, they
        // are in the whole cell: both differences are linear.
        let close = |own: u16, other: u16| {
            let (own, other) = (plane(own).0, plane(other).0);
            let last = (CELL_PX - 1) as f64;
            let positive = |difference: Vector3<f64>| {
                let [a, b, c]: [f64; 3] = difference.into();
                let least = (a * last).min(0.0) + (b * last).min(0.0);
                a * x0 + b * y0 + c + least >= 0.0
            };
            !positive(other - own * (1.0 + ratio)) && !positive(own * (1.0 - ratio) - other)
        };
        doubtful.clear();
        for &own in &owns {
            let others = planes.iter().filter(|other| **other != own);
            doubtful.extend(others.filter(|o| close(own, **o)).map(|o| (own, *o)));
        }
        if doubtful.is_empty() {
            continue;
        }
        let at = |label: u16, u: usize, v: usize| {
            let (x, y) = (u as f64 - image.centre.0, v as f64 - image.centre.1);
            plane(label).at(x, y)
        };
        for (u, v) in (v0..v0 + CELL_PX).flat_map(|v| (u0..u0 + CELL_PX).map(move |u| (u, v))) {
            let label = labels[v * image.width + u];
            let mut others = doubtful.iter().filter(|(own, _)| *own == label);
            if others.any(|&(own, other)| {
                let w = at(own, u, v);
                (at(other, u, v) - w).abs() < ratio * w
            }) {
                sure.clear(u, v);
            }
        }
    }
}

/// Writes labels cell by cell.
struct Painter<'a> {
    image: &'a InverseImage,
    grid: &'a Grid,
    /// Coefficients of each region's plane.
    planes: Vec<[f32; 3]>,
    /// Square of the distance within which each cell's pixels belong to a plane, 1/m².
    limits: Vec<f32>,
    pixels: Vec<u16>,
}

impl<'a> Painter<'a> {
    fn new(image: &'a InverseImage, grid: &'a Grid, planes: Vec<[f32; 3]>, noise: &Noise) -> Self {
        let limit = |m: &Moments| {
            let noise = CellNoise::at(noise, m.mean());
            // Without a pixel there is no noise either, and nothing is nearer than that.
            noise.square(SIGMAS, SYSTEMATICS) as f32
        };
        Self {
            image,
            grid,
            planes,
            limits: grid.cells.iter().map(limit).collect(),
            pixels: vec![NONE; image.w.len()],
        }
    }

    /// First pixel of a cell.
    fn corner(&self, cell: usize) -> (usize, usize) {
        let (x, y) = (cell % self.grid.cols, cell / self.grid.cols);
        (x * CELL_PX, y * CELL_PX)
    }

    /// One plane to the pixels of `count` cells of a row that lie on it.
    fn run(&mut self, cell: usize, count: usize, label: u16) {
        let (u0, v0) = self.corner(cell);
        let [a, b, c] = self.planes[usize::from(label)].map(f64::from);
        let limits = &self.limits[cell..cell + count];
        for v in v0..v0 + CELL_PX {
            let start = v * self.image.width + u0;
            let range = start..start + count * CELL_PX;
            let (w, _) = self.image.w[range.clone()].as_chunks::<CELL_PX>();
            let (out, _) = self.pixels[range].as_chunks_mut::<CELL_PX>();
            let (x, y) = (
                u0 as f64 - self.image.centre.0,
                v as f64 - self.image.centre.1,
            );
            let first = (a * x + b * y + c) as f32;
            let (a, step) = (a as f32, CELL_PX as f32);
            for (i, ((w, out), &limit)) in w.iter().zip(out).zip(limits).enumerate() {
                let left = first + a * (i as f32 * step);
                for j in 0..CELL_PX {
                    let e = left + a * j as f32 - w[j];
                    let on = (e * e < limit) & (w[j] > 0.0);
                    out[j] = if on { label } else { NONE };
                }
            }
        }
    }

    /// The nearest of several planes to each pixel of a cell.
    fn cell(&mut self, cell: usize, candidates: &[u16]) {
        let (u0, v0) = self.corner(cell);
        let limit = self.limits[cell];
        let (x0, y0) = (
            u0 as f64 - self.image.centre.0,
            v0 as f64 - self.image.centre.1,
        );
        let (x0, y0) = (x0 as f32, y0 as f32);
        for row in 0..CELL_PX {
            let start = (v0 + row) * self.image.width + u0;
            let mut w = [0.0_f32; CELL_PX];
            w.copy_from_slice(&self.image.w[start..start + CELL_PX]);
            // Square of the distance to the nearest plane, and which it is; four pixels at once.
            let mut best = w.map(|w| if w > 0.0 { limit } else { 0.0 });
            let mut won = [u32::from(NONE); CELL_PX];
            for &candidate in candidates {
                let [a, b, c] = self.planes[usize::from(candidate)];
                let first = a * x0 + (b * (y0 + row as f32) + c);
                for j in 0..CELL_PX {
                    let e = a * j as f32 + first - w[j];
                    let square = e * e;
                    let better = square < best[j];
                    best[j] = if better { square } else { best[j] };
                    won[j] = if better { candidate.into() } else { won[j] };
                }
            }
            let labels = won.map(|label| label as u16);
            self.pixels[start..start + CELL_PX].copy_from_slice(&labels);
        }
    }

    /// The label that half of a cell's pixels have at least, or [`NONE`].
    fn most(&self, cell: usize, candidates: &[u16]) -> u16 {
        let (u0, v0) = self.corner(cell);
        let rows = (v0..v0 + CELL_PX).map(|v| v * self.image.width + u0);
        let pixels = || {
            rows.clone()
                .flat_map(|start| &self.pixels[start..start + CELL_PX])
        };
        let half = |label: &&u16| 2 * pixels().filter(|l| l == label).count() >= CELL_PX * CELL_PX;
        candidates.iter().find(half).copied().unwrap_or(NONE)
    }
}
