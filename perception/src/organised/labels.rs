//! Every pixel to the nearest of the planes around it.

use std::ops::Range;

use super::bits::Bits;
use super::cell::{CellNoise, coefficients};
use super::growth::Region;
use super::image::{CELL_PX, Grid, InverseImage};
use super::moments::Moments;
use super::near::Near;
use super::words::{places, runs};
use crate::extraction::Segmentation;
use crate::sensor::Noise;

/// The label of a pixel that belongs to no plane.
pub(super) const NONE: u16 = Segmentation::NONE;

/// How far from the cells that were grown a plane may claim pixels, in cells.
const RINGS: usize = 3;
/// A pixel belongs to a plane within √((3σ)² + (2κw)²) of it.
const SIGMAS: f64 = 3.0;
const SYSTEMATICS: f64 = 2.0;

/// The square of that distance for the pixels of a cell, 1/m²; nothing is nearer than that of one
/// without a pixel.
pub(super) fn limit(cell: &Moments, noise: &Noise) -> f64 {
    CellNoise::at(noise, cell.mean()).square(SIGMAS, SYSTEMATICS)
}

/// Index of the region that has most of each small cell, or [`NONE`].
pub(super) struct CellLabels(pub Vec<u16>);

/// The index of the region, or [`NONE`], for every pixel and for every small cell.
///
/// `cells` has the region of each small cell. The pixels of a cell may go to the planes of the cell and of the eight cells around it, to the
/// nearest one; cells that went to no plane so far are reached ring by ring.
pub(super) fn label(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    mut cells: Vec<u16>,
    noise: &Noise,
) -> (Vec<u16>, CellLabels) {
    let (cols, rows) = (grid.cols, grid.rows);
    let mut painter = Painter::new(image, grid, regions, noise);
    // The cells that had a region, those that no plane was tried in, and those that have a region
    // since the last ring.
    let labelled = Bits::of(&cells, cols, |label| label != NONE);
    let mut untried = Bits::empty(cols, rows).not();
    let mut fresh = cells.clone();
    let (mut single, mut candidates) = (Vec::new(), Vec::new());
    for _ in 0..RINGS {
        let near = Near::all(&fresh, cols, regions.len(), 1);
        // Those near one of them, and near several.
        let (one, several) = counted(&near, cols, rows);
        let (one, several) = (one.and(&untried), several.and(&untried));
        untried = untried.without(&one);
        // Cells that had none have what most of their pixels have.
        fresh.fill(NONE);
        let mut settle = |painter: &Painter, x: usize, y: usize, candidates: &[u16]| {
            let cell = y * cols + x;
            cells[cell] = painter.most(x, y, candidates);
            fresh[cell] = cells[cell];
        };
        let mut here = Vec::new();
        for y in 0..rows {
            painter.begin(y);
            here.clear();
            for (label, near) in (0..).zip(&near) {
                here.extend(near.row(y).map(|row| (label, row)));
            }
            for &(label, near) in &here {
                let alone = one.row(y).iter().zip(several.row(y));
                let words = near.iter().zip(alone);
                single.clear();
                single.extend(words.map(|(near, (one, several))| near & one & !several));
                runs(&single, None, |a, b| painter.run(label, y, a..b));
                let had = single.iter_mut().zip(labelled.row(y));
                had.for_each(|(single, had)| *single &= !had);
                places(&single).for_each(|x| settle(&painter, x, y, &[label]));
            }
            places(several.row(y)).for_each(|x| {
                let is_near = |(_, near): &&(u16, &[u64])| near[x / 64] >> (x % 64) & 1 == 1;
                candidates.clear();
                candidates.extend(here.iter().filter(is_near).map(|(label, _)| *label));
                painter.cell(x, y, &candidates);
                if !labelled.has(x, y) {
                    settle(&painter, x, y, &candidates);
                }
            });
        }
    }
    (painter.pixels(), CellLabels(cells))
}

/// The cells near one region or more, and those near two or more.
fn counted(near: &[Near], cols: usize, rows: usize) -> (Bits, Bits) {
    let (mut one, mut several) = (Bits::empty(cols, rows), Bits::empty(cols, rows));
    for (y, near) in near.iter().flat_map(|near| near.rows()) {
        let counts = one.row_mut(y).iter_mut().zip(several.row_mut(y));
        for ((one, several), near) in counts.zip(near) {
            *several |= *one & near;
            *one |= near;
        }
    }
    (one, several)
}

/// Writes labels cell by cell.
struct Painter<'a> {
    image: &'a InverseImage,
    grid: &'a Grid,
    /// Coefficients of each region's plane.
    planes: Vec<[f32; 3]>,
    noise: &'a Noise,
    pixels: Vec<u16>,
    /// Of the run that is being painted, for each of its columns: how far the plane has risen since
    /// the first one, and the square of the distance within which pixels belong to it.
    rise: Vec<f32>,
    limit: Vec<f32>,
}

impl<'a> Painter<'a> {
    fn new(image: &'a InverseImage, grid: &'a Grid, regions: &[Region], noise: &'a Noise) -> Self {
        let plane = |region: &Region| coefficients(&region.plane);
        Self {
            image,
            grid,
            planes: regions.iter().map(plane).collect(),
            noise,
            pixels: Vec::with_capacity(image.w.len()),
            rise: Vec::new(),
            limit: Vec::new(),
        }
    }

    /// Before the first label is written in a row of cells.
    fn begin(&mut self, y: usize) {
        let end = (y + 1) * CELL_PX * self.image.width;
        self.pixels.resize(end.max(self.pixels.len()), NONE);
    }

    /// The label of every pixel.
    fn pixels(mut self) -> Vec<u16> {
        // A margin of the image narrower than a cell has none.
        self.pixels.resize(self.image.w.len(), NONE);
        self.pixels
    }

    /// A pixel's coordinates as planes have them.
    fn place(&self, u: usize, v: usize) -> (f32, f32) {
        let (u0, v0) = self.image.centre;
        ((u as f64 - u0) as f32, (v as f64 - v0) as f32)
    }

    /// One plane to the pixels of a row of cells that lie on it.
    fn run(&mut self, label: u16, y: usize, columns: Range<usize>) {
        let (u0, v0) = (columns.start * CELL_PX, y * CELL_PX);
        let count = columns.len() * CELL_PX;
        let [a, b, c] = self.planes[usize::from(label)];
        let (x0, y0) = self.place(u0, v0);
        let first = a * x0 + (b * y0 + c);
        self.rise.clear();
        self.rise.extend((0..count as i32).map(|i| a * i as f32));
        self.limit.clear();
        for cell in &self.grid.cells[y * self.grid.cols..][columns] {
            self.limit.extend([limit(cell, self.noise) as f32; CELL_PX]);
        }
        for k in 0..CELL_PX {
            let start = (v0 + k) * self.image.width + u0;
            let first = first + b * k as f32;
            let lines = (self.rise.iter().zip(&self.limit)).zip(&self.image.w[start..]);
            for (out, ((rise, limit), w)) in self.pixels[start..].iter_mut().zip(lines) {
                let e = first + rise - w;
                let on = (e * e < *limit) & (*w > 0.0);
                *out = if on { label } else { NONE };
            }
        }
    }

    /// The nearest of several planes to each pixel of a cell.
    fn cell(&mut self, x: usize, y: usize, candidates: &[u16]) {
        let (u0, v0) = (x * CELL_PX, y * CELL_PX);
        let (x0, y0) = self.place(u0, v0);
        let start = |k: usize| (v0 + k) * self.image.width + u0;
        // Square of the distance to the nearest plane, and which it is; four pixels at once.
        let cell = &self.grid.cells[y * self.grid.cols + x];
        let mut best = [[limit(cell, self.noise) as f32; CELL_PX]; CELL_PX];
        let mut won = [[u32::from(NONE); CELL_PX]; CELL_PX];
        let mut lines = [[0.0_f32; CELL_PX]; CELL_PX];
        for (k, line) in lines.iter_mut().enumerate() {
            line.copy_from_slice(&self.image.w[start(k)..][..CELL_PX]);
        }
        for &candidate in candidates {
            let [a, b, c] = self.planes[usize::from(candidate)];
            let first = a * x0 + (b * y0 + c);
            for k in 0..CELL_PX {
                let first = first + b * k as f32;
                for j in 0..CELL_PX {
                    let w = lines[k][j];
                    let e = a * j as f32 + first - w;
                    let square = e * e;
                    let better = (square < best[k][j]) & (w > 0.0);
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
    fn most(&self, x: usize, y: usize, candidates: &[u16]) -> u16 {
        let mut labels = [[NONE; CELL_PX]; CELL_PX];
        for (k, line) in labels.iter_mut().enumerate() {
            let start = (y * CELL_PX + k) * self.image.width + x * CELL_PX;
            line.copy_from_slice(&self.pixels[start..][..CELL_PX]);
        }
        let half = |label: &&u16| {
            let same = labels.as_flattened().iter().map(|l| u16::from(l == *label));
            2 * usize::from(same.sum::<u16>()) >= CELL_PX * CELL_PX
        };
        candidates.iter().find(half).copied().unwrap_or(NONE)
    }
}
