//! The sure pixels of each label as few sets of which the moments are known.

use super::bits::Bits;
use super::image::{CELL_PX, Grid, InverseImage};
use super::label_boundaries::LabelBoundaries;
use super::moments::Moments;
use super::pixels::holed;
use super::words::{Ones, packed_16};
use crate::segmentation::NONE;

/// Calls `with` for the moments of disjoint sets of sure pixels of one label, which are all of them;
/// each set is of a window of 64 columns and as many rows as a large cell has.
///
/// Large cells that are whole are added up, the small ones of the others, and what is left in small
/// cells.
pub(super) fn for_parts(
    image: &InverseImage,
    (small, large): (&Grid, &Grid),
    labels: &[u16],
    sure: &Bits,
    cuts: &LabelBoundaries,
    mut with: impl FnMut(u16, &Moments),
) {
    const LARGE_PX: usize = 2 * CELL_PX;
    let label = |u: usize, v: usize| labels[v * image.width + u];
    let words = image.width.div_ceil(64);
    for (y, i) in (0..small.rows.div_ceil(2)).flat_map(|y| (0..words).map(move |i| (y, i))) {
        let columns = |word: u64| Ones(word).map(move |bit| 64 * i + bit);
        // As a rule a window has one label, or one after the other.
        let (mut last, mut sum) = (NONE, Moments::default());
        let mut add = |label: u16, part: &Moments| {
            if label != last {
                with(last, &sum);
                (last, sum) = (label, Moments::default());
            }
            sum.add(part, 1.0);
        };
        let mut large_first = 0;
        if y < large.rows {
            large_first = cuts.blocks::<LARGE_PX>(sure, i, y * LARGE_PX);
            for u in columns(large_first) {
                let cell = y * large.cols + u / LARGE_PX;
                add(label(u, y * LARGE_PX), &large.cells[cell]);
            }
        }
        let taken = large_first | large_first << CELL_PX;
        for y in (2 * y..2 * y + 2).filter(|y| *y < small.rows) {
            let v = y * CELL_PX;
            let whole = cuts.blocks::<CELL_PX>(sure, i, v);
            for u in columns(whole & !taken) {
                add(label(u, v), &small.cells[y * small.cols + u / CELL_PX]);
            }
            for u in columns(sure.some::<CELL_PX>(i, v) & !whole) {
                of_cell(image, labels, sure, (u, v), &mut add);
            }
        }
        with(last, &sum);
    }
}

/// The same for the pixels of one small cell, the first at (u, v).
fn of_cell(
    image: &InverseImage,
    labels: &[u16],
    sure: &Bits,
    (u, v): (usize, usize),
    with: &mut impl FnMut(u16, &Moments),
) {
    let (mut its, mut w) = ([NONE; CELL_PX * CELL_PX], [[0.0; CELL_PX]; CELL_PX]);
    let mut left = 0;
    for k in 0..CELL_PX {
        let start = (v + k) * image.width + u;
        its[k * CELL_PX..][..CELL_PX].copy_from_slice(&labels[start..][..CELL_PX]);
        w[k].copy_from_slice(&image.w[start..][..CELL_PX]);
        left |= (sure.row(v + k)[u / 64] >> (u % 64) & 0xf) << (k * CELL_PX);
    }
    let (x0, y0) = (u as f64 - image.centre.0, v as f64 - image.centre.1);
    while let Some(first) = Ones(left).next() {
        let label = its[first];
        let own = left & packed_16(&its, &its, |other, _| other == label);
        left &= !own;
        let mut part = w;
        for (k, line) in part.iter_mut().enumerate() {
            let lanes = &LANES[(own >> (k * CELL_PX) & 0xf) as usize];
            line.iter_mut().zip(lanes).for_each(|(w, lane)| *w *= lane);
        }
        with(label, &holed(part, x0, y0));
    }
}

/// One where a number of four bits has one, from the lowest on.
const LANES: [[f32; CELL_PX]; 16] = {
    let mut lanes = [[0.0; CELL_PX]; 16];
    let mut i = 0;
    while i < 64 {
        lanes[i / 4][i % 4] = ((i / 4) >> (i % 4) & 1) as f32;
        i += 1;
    }
    lanes
};
