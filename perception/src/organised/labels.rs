//! Every pixel to the nearest of the planes around it.

use super::bits::Bits;
use super::image::{Grid, InverseImage};
use super::labelling::Labelling;
use super::moments::Region;
use super::neighbourhood::Near;
use super::words::{Ones, places, runs};
use crate::segmentation::NONE;
use crate::sensor::Noise;

/// How far from the cells that were grown a plane may claim pixels, in cells.
const RINGS: usize = 3;

/// Index of the region that has most of each small cell, or [`NONE`].
pub(super) struct CellLabels(pub Vec<u16>);

/// The index of the region, or [`NONE`], for every pixel and for every small cell.
///
/// `cells` has the region of each small cell. The pixels of a cell may go to the planes of the cell and
/// of the eight cells around it, to the nearest one; cells that went to no plane so far are reached ring
/// by ring.
pub(super) fn label(
    image: &InverseImage,
    grid: &Grid,
    regions: &[Region],
    mut cells: Vec<u16>,
    noise: &Noise,
) -> (Vec<u16>, CellLabels) {
    let (cols, rows) = (grid.cols, grid.rows);
    // The cells that had a region, and those to paint: at first all near one, then those that still have none
    // near one that has one since the last ring.
    let labelled = Bits::of(&cells, cols, |label| label != NONE);
    let mut painter = Labelling::new(image, grid, regions, noise);
    let mut open = Bits::empty(cols, rows).not();
    let (mut alone, mut its, mut candidates) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..RINGS {
        let near = Near::all(&cells, cols, regions.len(), 1);
        // Those near one of them, and near several.
        let (one, several) = counted(&near, cols, rows);
        let (one, several) = (one.and(&open), several.and(&open));
        // Cells that had none have what most of their pixels have.
        let mut fresh = Bits::empty(cols, rows);
        let mut settle = |painter: &Labelling, x: usize, y: usize, candidates: &[u16]| {
            let cell = y * cols + x;
            cells[cell] = painter.most(x, y, candidates);
            if cells[cell] != NONE {
                fresh.fill(y, x, x + 1);
            }
        };
        let mut here = Vec::new();
        for y in 0..rows {
            here.clear();
            for (label, near) in (0..).zip(&near) {
                here.extend(near.row(y).map(|row| (label, row)));
            }
            // The cells near one region only.
            alone.clear();
            let both = one.row(y).iter().zip(several.row(y));
            alone.extend(both.map(|(one, several)| one & !several));
            for &(label, near) in &here {
                its.clear();
                its.extend(near.iter().zip(&alone).map(|(near, alone)| near & alone));
                runs(&its, None, |a, b| painter.take(label, y, a..b));
            }
            painter.paint(y);
            for &(label, near) in &here {
                for (i, word) in near.iter().enumerate() {
                    let new = Ones(word & alone[i] & !labelled.row(y)[i]);
                    new.for_each(|bit| settle(&painter, 64 * i + bit, y, &[label]));
                }
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
        let none = Bits::of(&cells, cols, |label| label == NONE);
        open = fresh.dilated(1).and(&none);
    }
    (painter.pixels, CellLabels(cells))
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
