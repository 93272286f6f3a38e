//! Where regions begin: blocks and strips of planar cells that fit one plane.

use std::ops::Range;

use super::bits::Bits;
use super::image::Grid;
use super::moments::squares;
use super::words::runs;
use crate::segmentation::{Seed, seed_of};

/// The cells that a region begins with: so many columns and rows of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub cols: usize,
    pub rows: usize,
}

/// In what every face but a thin one holds.
pub(super) const BLOCK: Shape = Shape { cols: 3, rows: 3 };
/// What thin faces are grown from: the fronts of boards, legs.
pub(super) const STRIPS: [Shape; 2] = [Shape { cols: 6, rows: 1 }, Shape { cols: 1, rows: 6 }];

impl Shape {
    /// Its rows of cells from the first cell on.
    fn rows(self, first: usize, grid: &Grid) -> impl Iterator<Item = Range<usize>> {
        let starts = (0..self.rows).map(move |k| first + k * grid.cols);
        starts.map(move |start| start..start + self.cols)
    }

    /// Calls `found` where its cells all are open and fit one plane: with the mean square about
    /// that in units of its limit, and the first cell.
    fn places(
        self,
        grid: &Grid,
        limit: impl Fn(usize) -> f32,
        shut: &[bool],
        mut found: impl FnMut(f32, usize),
    ) {
        let open = Bits::of(shut, grid.cols, |shut| !shut);
        let (mut all, mut columns, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..(open.height + 1).saturating_sub(self.rows) {
            // Where as many rows as the seed has are open, and runs of that.
            all.clear();
            all.extend_from_slice(open.row(y));
            for below in (y + 1..y + self.rows).map(|y| open.row(y)) {
                all.iter_mut()
                    .zip(below)
                    .for_each(|(all, open)| *all &= open);
            }
            runs(&all, None, |a, b| {
                if b - a < self.cols {
                    return;
                }
                let (from, to) = (y * grid.cols + a, y * grid.cols + b);
                columns.clear();
                columns.extend((from..to).map(|top| {
                    let mut sum = grid.cells[top];
                    let below = (1..self.rows).map(|k| top + k * grid.cols);
                    below.for_each(|i| sum.add(&grid.cells[i], 1.0));
                    sum
                }));
                blocks.clear();
                blocks.extend(columns.windows(self.cols).map(|columns| {
                    let mut sum = columns[0];
                    columns[1..].iter().for_each(|column| sum.add(column, 1.0));
                    sum
                }));
                let middle = self.rows / 2 * grid.cols + self.cols / 2;
                for (two, from) in blocks.chunks(2).zip((from..).step_by(2)) {
                    let squares = squares(&two[0], &two[two.len() - 1]);
                    for (square, from) in squares.into_iter().zip(from..).take(two.len()) {
                        let Some(square) = square else { continue };
                        let score = square as f32 / limit(from + middle);
                        if score <= 1.0 {
                            found(score, from);
                        }
                    }
                }
            });
        }
    }
}

/// The rows of cells of a seed that [`places`] found with the same shapes.
pub(super) fn rows_of(
    seed: Seed,
    shapes: &[Shape],
    grid: &Grid,
) -> impl Iterator<Item = Range<usize>> {
    // In its lower half is the first cell times the number of shapes, plus which of them it is.
    let (place, count) = (seed as u32, shapes.len() as u32);
    shapes[(place % count) as usize].rows((place / count) as usize, grid)
}

/// The cells of these shapes that are not `shut` and fit one plane, in no order. `limit` is the
/// largest mean square of a seed about a cell, 1/m².
pub(super) fn places(
    shapes: &[Shape],
    grid: &Grid,
    limit: impl Fn(usize) -> f32,
    shut: &[bool],
) -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (number, shape) in shapes.iter().enumerate() {
        shape.places(grid, &limit, shut, |score, first| {
            seeds.push(seed_of(score, first * shapes.len() + number));
        });
    }
    seeds
}
