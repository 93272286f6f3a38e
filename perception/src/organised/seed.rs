//! Where regions begin: blocks and strips of planar cells that fit one plane.

use super::image::Grid;
use super::moments::Moments;

/// The cells that a region begins with: so many columns and rows of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub cols: usize,
    pub rows: usize,
}

impl Seed {
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
        // How many cells of each column are open from the row of cells on upward, as many as the seed
        // has rows at most, and the sums of these.
        let mut heights = vec![0_u16; grid.cols];
        let tall = self.rows as u16;
        let mut columns = vec![Moments::default(); grid.cols];
        for (y, shut) in shut.chunks_exact(grid.cols.max(1)).enumerate() {
            for (height, shut) in heights.iter_mut().zip(shut) {
                let next = if *height < tall { *height + 1 } else { tall };
                *height = if *shut { 0 } else { next };
            }
            // Most rows have none where faces are known already.
            if !heights
                .iter()
                .fold(false, |any, height| any | (*height == tall))
            {
                continue;
            }
            let start = (y + 1 - self.rows) * grid.cols;
            let (mut open, mut summed) = (0, 0);
            for (x, &height) in heights.iter().enumerate() {
                // How many columns up to this one are open.
                open = if height < tall { 0 } else { open + 1 };
                if open < self.cols {
                    continue;
                }
                let first = x + 1 - self.cols;
                let from = summed.max(first);
                for (column, sum) in (from..).zip(&mut columns[from..=x]) {
                    *sum = Moments::default();
                    let cells = (0..self.rows).map(|k| start + k * grid.cols + column);
                    cells.for_each(|i| sum.add(&grid.cells[i], 1.0));
                }
                summed = x + 1;
                let mut block = columns[first];
                let rest = &columns[first + 1..=x];
                rest.iter().for_each(|column| block.add(column, 1.0));
                let Some(fit) = block.fit() else { continue };
                let middle = start + self.rows / 2 * grid.cols + first + self.cols / 2;
                let score = fit.square as f32 / limit(middle);
                if score <= 1.0 {
                    found(score, start + first);
                }
            }
        }
    }
}

/// Where cells that are not `shut` fit one plane, flattest first: the first cell, and which of the
/// shapes. `limit` is the largest mean square of a seed about a cell, 1/m².
pub(super) fn seeds(
    grid: &Grid,
    limit: impl Fn(usize) -> f32,
    shut: &[bool],
    shapes: &[Seed],
) -> Vec<(usize, usize)> {
    let mut seeds = Vec::new();
    for (number, shape) in shapes.iter().enumerate() {
        shape.places(grid, &limit, shut, |score, first| {
            // Bits of numbers that are not negative are in the order of the numbers.
            let place = first * shapes.len() + number;
            seeds.push(u64::from(score.to_bits()) << 32 | place as u64);
        });
    }
    seeds.sort_unstable();
    let places = seeds.into_iter().map(|seed| seed as u32 as usize);
    places
        .map(|place| (place / shapes.len(), place % shapes.len()))
        .collect()
}
