//! Where regions begin: blocks and strips of planar cells that fit one plane.

use super::bits::Bits;
use super::image::Grid;
use super::moments::squares;
use super::words::runs;

/// The cells that a region begins with: so many columns and rows of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub cols: usize,
    pub rows: usize,
}

impl Shape {
    /// In what every face but a narrow one holds.
    pub const BLOCK: Self = Self { cols: 3, rows: 3 };

    /// Its cells, row by row, from the first one on.
    pub fn cells(self, first: usize, grid: &Grid) -> impl Iterator<Item = usize> + Clone {
        let starts = (0..self.rows).map(move |k| first + k * grid.cols);
        starts.flat_map(move |start| start..start + self.cols)
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

/// Cells that a region may begin with; the flattest are the least.
///
/// In its upper half the score, of which the bits are in the order of the numbers, as it is not
/// negative; in the lower one the first cell times the number of shapes, plus which of them it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Seed(u64);

impl Seed {
    /// Its cells; the shapes must be those given to [`seeds`].
    pub fn cells(self, shapes: &[Shape], grid: &Grid) -> impl Iterator<Item = usize> + Clone {
        let (place, count) = (self.0 as u32, shapes.len() as u32);
        shapes[(place % count) as usize].cells((place / count) as usize, grid)
    }
}

/// The cells of these shapes that are not `shut` and fit one plane, in no order. `limit` is the
/// largest mean square of a seed about a cell, 1/m².
pub(super) fn seeds(
    grid: &Grid,
    limit: impl Fn(usize) -> f32,
    shut: &[bool],
    shapes: &[Shape],
) -> Vec<Seed> {
    let mut seeds = Vec::new();
    for (number, shape) in shapes.iter().enumerate() {
        shape.places(grid, &limit, shut, |score, first| {
            let place = first * shapes.len() + number;
            seeds.push(Seed(u64::from(score.to_bits()) << 32 | place as u64));
        });
    }
    seeds
}
