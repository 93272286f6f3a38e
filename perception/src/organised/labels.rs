//! Every pixel to the nearest of the planes around it.

use super::growth::{CellNoise, Region};
use super::image::{CELL_PX, Grid, InverseImage};
use super::mask::{MIXED, OPEN, joined};
use crate::sensor::Noise;

/// The label of a pixel that belongs to no plane.
pub(super) const NONE: u16 = u16::MAX;

/// How far from the cells that were grown a plane may claim pixels, in cells.
const RINGS: usize = 3;
/// A pixel belongs to a plane within √((3σ)² + (2κw)²) of it.
const SIGMAS: f64 = 3.0;
const SYSTEMATICS: f64 = 2.0;

/// Which plane every pixel and every small cell belongs to.
pub(super) struct Labelling {
    /// Index of the pixel's region, or [`NONE`].
    pub pixels: Vec<u16>,
    /// Index of the region that has most of the cell, or [`NONE`].
    cells: Vec<u16>,
}

/// The index of a region for every pixel.
///
/// The pixels of a cell may go to the planes of the cell and of the eight cells around it, to the
/// nearest one; cells that went to no plane so far are reached ring by ring.
pub(super) fn label(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    noise: &Noise,
) -> Labelling {
    let mut cells = vec![NONE; grid.cells.len()];
    for (r, region) in regions.iter().enumerate() {
        for &cell in &region.cells {
            cells[cell] = r as u16;
        }
    }
    let mut pixels = vec![NONE; image.w.len()];
    let mut done = vec![false; cells.len()];
    for ring in 0..=RINGS {
        let around = around(grid, &cells, 1);
        let mut next = cells.clone();
        for cell in 0..cells.len() {
            // The grown cells first, then ring by ring what touches them.
            if done[cell] || (ring == 0 && cells[cell] == NONE) || around[cell] == OPEN {
                continue;
            }
            done[cell] = true;
            let mut several = Vec::new();
            let planes = if around[cell] == MIXED {
                several.push(cells[cell]);
                several.extend(grid.neighbours(cell, true).map(|k| cells[k]));
                several.retain(|&label| label != NONE);
                several.sort_unstable();
                several.dedup();
                &several[..]
            } else {
                &around[cell..=cell]
            };
            let won = label_cell(image, grid, regions, noise, cell, planes, &mut pixels);
            if cells[cell] == NONE {
                next[cell] = won;
            }
        }
        cells = next;
    }
    Labelling { pixels, cells }
}

/// What the labels of the cells within `r` of each cell have in common: [`OPEN`] where there is
/// none, the label where there is one, [`MIXED`] where there are more.
fn around(grid: &Grid, cells: &[u16], r: usize) -> Vec<u16> {
    let open = |&label: &u16| if label == NONE { OPEN } else { label };
    let labels: Vec<u16> = cells.iter().map(open).collect();
    joined(&labels, grid.cols, grid.rows, r)
}

/// Takes the label from the pixels where the plane of a neighbouring region is so close to theirs
/// that the slowly varying error may have drawn the border anywhere between: those within two
/// cells of that region where both planes agree to `doubt` κ w.
pub(super) fn drop_doubtful(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    labelling: &Labelling,
    labels: &mut [u16],
    doubt: f64,
    noise: &Noise,
) {
    let near = around(grid, &labelling.cells, 2);
    for cell in (0..near.len()).filter(|&cell| near[cell] == MIXED) {
        let (x, y) = (cell % grid.cols, cell / grid.cols);
        let mut planes: Vec<u16> = (y.saturating_sub(2)..(y + 3).min(grid.rows))
            .flat_map(|y| {
                let row = y * grid.cols;
                let columns = x.saturating_sub(2)..(x + 3).min(grid.cols);
                columns.map(move |x| labelling.cells[row + x])
            })
            .filter(|&label| label != NONE)
            .collect();
        planes.sort_unstable();
        planes.dedup();
        let (u0, v0) = ((cell % grid.cols) * CELL_PX, (cell / grid.cols) * CELL_PX);
        for (u, v) in (v0..v0 + CELL_PX).flat_map(|v| (u0..u0 + CELL_PX).map(move |u| (u, v))) {
            let label = &mut labels[v * image.width + u];
            let Some(region) = regions.get(usize::from(*label)) else {
                continue;
            };
            let (x, y) = (u as f64 - image.centre.0, v as f64 - image.centre.1);
            let w = region.plane.at(x, y);
            let limit = doubt * noise.systematic_ratio * w;
            let doubtful = planes
                .iter()
                .filter(|&&other| other != *label)
                .any(|&other| {
                    let other = &regions[usize::from(other)].plane;
                    (other.at(x, y) - w).abs() < limit
                });
            if doubtful {
                *label = NONE;
            }
        }
    }
}

/// Labels one cell's pixels; returns the label of most of them if it has half of the cell.
fn label_cell(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    noise: &Noise,
    cell: usize,
    candidates: &[u16],
    labels: &mut [u16],
) -> u16 {
    let (u0, v0) = ((cell % grid.cols) * CELL_PX, (cell / grid.cols) * CELL_PX);
    let m = &grid.cells[cell];
    if m.n < 1.0 {
        return NONE;
    }
    let limit = CellNoise::at(noise, m.mean()).square(SIGMAS, SYSTEMATICS);
    let mut counts = [0_usize; 9];
    for v in v0..v0 + CELL_PX {
        let row = v * image.width;
        for u in u0..u0 + CELL_PX {
            let w = f64::from(image.w[row + u]);
            if w <= 0.0 {
                continue;
            }
            let (x, y) = (u as f64 - image.centre.0, v as f64 - image.centre.1);
            let mut best = (limit, NONE, 0);
            for (k, &candidate) in candidates.iter().enumerate() {
                let e = regions[usize::from(candidate)].plane.at(x, y) - w;
                if e * e < best.0 {
                    best = (e * e, candidate, k);
                }
            }
            if best.1 != NONE {
                counts[best.2] += 1;
                labels[row + u] = best.1;
            }
        }
    }
    let (most, k) = counts
        .iter()
        .zip(0..)
        .map(|(&n, k)| (n, k))
        .fold((0, 0), |a, b| if b.0 > a.0 { b } else { a });
    if 2 * most >= CELL_PX * CELL_PX {
        candidates.get(k).copied().unwrap_or(NONE)
    } else {
        NONE
    }
}
