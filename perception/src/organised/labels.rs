//! Every pixel to the nearest of the planes around it.

use super::growth::{CellNoise, Region};
use super::image::{CELL_PX, Grid, InverseImage};
use crate::sensor::Noise;

/// The label of a pixel that belongs to no plane.
pub(super) const NONE: u16 = u16::MAX;

/// How far from the cells that were grown a plane may claim pixels, in cells.
const RINGS: usize = 3;
/// A pixel belongs to a plane within √((3σ)² + (2κw)²) of it.
const SIGMAS: f64 = 3.0;
const SYSTEMATICS: f64 = 2.0;

/// Labels of the pixels: the index of a region, or [`NONE`].
///
/// The pixels of a cell may go to the planes of the cell and of the eight cells around it, to the
/// nearest one; cells that went to no plane so far are reached ring by ring.
pub(super) fn label(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    noise: &Noise,
) -> Vec<u16> {
    let mut owner = vec![NONE; grid.cells.len()];
    for (r, region) in regions.iter().enumerate() {
        for &cell in &region.cells {
            owner[cell] = r as u16;
        }
    }
    let mut labels = vec![NONE; image.w.len()];
    let mut done = vec![false; owner.len()];
    for ring in 0..=RINGS {
        let mut next = owner.clone();
        for cell in 0..owner.len() {
            // The grown cells first, then ring by ring what touches them.
            if done[cell] || (ring == 0 && owner[cell] == NONE) {
                continue;
            }
            let mut candidates: [u16; 9] = [NONE; 9];
            let mut count = 0;
            for k in std::iter::once(cell).chain(grid.neighbours(cell, true)) {
                let o = owner[k];
                if o != NONE && !candidates[..count].contains(&o) {
                    candidates[count] = o;
                    count += 1;
                }
            }
            if count == 0 {
                continue;
            }
            done[cell] = true;
            let won = label_cell(
                image,
                grid,
                regions,
                noise,
                cell,
                &candidates[..count],
                &mut labels,
            );
            if owner[cell] == NONE {
                next[cell] = won;
            }
        }
        owner = next;
    }
    labels
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
