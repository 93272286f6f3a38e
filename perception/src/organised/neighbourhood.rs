//! Which cells of the grid are near which region.

use std::ops::Range;

use super::bits::Bits;
use super::label_boundaries;
use crate::segmentation::NONE;

/// The cells near one region: bits of those rows of the grid that it reaches.
pub(super) struct Near {
    first: usize,
    bits: Bits,
}

impl Near {
    /// For each of `count` labels the cells within `r` (in the maximum norm) of one that has it.
    pub fn all(cells: &[u16], cols: usize, count: usize, r: usize) -> Vec<Self> {
        let rows = cells.len() / cols.max(1);
        let labelled = Bits::of(cells, cols, |label| label != NONE);
        let cuts = label_boundaries::along(cells, cols, rows);
        let mut runs = Vec::new();
        let mut reach = vec![rows..0; count];
        labelled.for_runs(&cuts, |y, a, b| {
            let label = usize::from(cells[y * cols + a]);
            let reach = &mut reach[label];
            *reach = reach.start.min(y.saturating_sub(r))..(y + r + 1).min(rows);
            runs.push((label, y, a, b));
        });
        let empty = |reach: &Range<usize>| Self {
            first: reach.start,
            bits: Bits::empty(cols, reach.len()),
        };
        let mut near: Vec<Self> = reach.iter().map(empty).collect();
        for (label, y, a, b) in runs {
            let near = &mut near[label];
            near.bits.fill(y - near.first, a, b);
        }
        let dilated = |near: Self| Self {
            bits: near.bits.dilated(r),
            ..near
        };
        near.into_iter().map(dilated).collect()
    }

    /// The rows of the grid that it reaches, and their cells, 64 a word.
    pub fn rows(&self) -> impl Iterator<Item = (usize, &[u64])> {
        (0..self.bits.height).map(|row| (self.first + row, self.bits.row(row)))
    }

    /// What it shares with the cells near another region: row, number of the word, and its cells.
    pub fn shared(&self, other: &Self) -> impl Iterator<Item = (usize, usize, u64)> {
        let first = self.first.max(other.first);
        let from = |near: &Self| (first - near.first).min(near.bits.height);
        let common = self.bits.common(from(self), &other.bits, from(other));
        common.map(move |(down, k, cells)| (first + down, k, cells))
    }

    /// The cells of a row, 64 a word, if it reaches that.
    pub fn row(&self, y: usize) -> Option<&[u64]> {
        let row = y.checked_sub(self.first)?;
        (row < self.bits.height).then(|| self.bits.row(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_near_the_labels_that_they_can_reach() {
        let (cols, rows, r) = (70, 9, 2);
        let cell = |x: usize, y: usize| match (x, y) {
            (0..3, 0) | (66, 7) => 0,
            (20..64, 3..5) => 1,
            (64, 4) | (69, 8) => 3,
            _ => NONE,
        };
        let cells: Vec<u16> = (0..cols * rows).map(|i| cell(i % cols, i / cols)).collect();
        let near = Near::all(&cells, cols, 4, r);
        assert!(near[2].rows().next().is_none());
        for (label, near) in (0..).zip(&near) {
            let got = |x: usize, y: usize| {
                near.row(y)
                    .is_some_and(|row| row[x / 64] >> (x % 64) & 1 == 1)
            };
            for (y, x) in (0..rows).flat_map(|y| (0..cols).map(move |x| (y, x))) {
                let mut around = (y.saturating_sub(r)..=y + r)
                    .flat_map(|y| (x.saturating_sub(r)..=x + r).map(move |x| (x, y)));
                let expected = around.any(|(x, y)| x < cols && y < rows && cell(x, y) == label);
                assert_eq!(got(x, y), expected, "({x}, {y}), {label}");
            }
        }
    }
}
