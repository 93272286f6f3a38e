//! Where regions begin: blocks and strips of planar cells that fit one plane.

use std::ops::Range;

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

    /// The rows of its cells, from the first cell on.
    pub fn lines(self, first: usize, grid: &Grid) -> impl Iterator<Item = Range<usize>> {
        let starts = (0..self.rows).map(move |k| first + k * grid.cols);
        starts.map(move |start| start..start + self.cols)
    }

    /// Where its cells all are open and fit one plane: the first cell, after how well they fit,
    /// in bits that are in the order of the numbers.
    fn places(
        self,
        grid: &Grid,
        limit: impl Fn(usize) -> f32,
        shut: &[bool],
        places: &mut Vec<(u32, u32)>,
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
                let Some(plane) = block.plane() else { continue };
                let middle = start + self.rows / 2 * grid.cols + first + self.cols / 2;
                let score = block.mean_square(&plane) as f32 / limit(middle);
                if score <= 1.0 {
                    // Bits of numbers that are not negative are in the order of the numbers.
                    places.push((score.to_bits(), (start + first) as u32));
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
        let before = seeds.len();
        shape.places(grid, &limit, shut, &mut seeds);
        for (_, place) in &mut seeds[before..] {
            *place = *place * shapes.len() as u32 + number as u32;
        }
    }
    seeds.sort_unstable();
    let places = seeds.into_iter().map(|(_, place)| place as usize);
    places
        .map(|place| (place / shapes.len(), place % shapes.len()))
        .collect()
}
