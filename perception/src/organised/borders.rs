//! Where two regions are beside each other, or nearly so.

use super::bits::Bits;
use super::image::Grid;
use super::label_boundaries;
use super::words::{Ones, pack};
use crate::segmentation::Border;
use crate::segmentation::NONE;

/// Sums over the pairs of a border: all that the step of a plane's residuals across it needs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub pairs: f64,
    /// Differences of the cells' mean u, v and w, first region less second.
    pub u: f64,
    pub v: f64,
    pub w: f64,
    /// Mean w of both.
    pub level: f64,
}

impl Sums {
    /// `None` where no pair has pixels.
    pub fn new(grid: &Grid, border: &Border) -> Option<Self> {
        let mut sums = Self::default();
        for pair in border {
            let [a, b] = pair.map(|cell| &grid.cells[cell as usize]);
            if a.n > 0.0 && b.n > 0.0 {
                let (of_a, of_b) = (1.0 / a.n, 1.0 / b.n);
                sums.pairs += 1.0;
                sums.u += a.u * of_a - b.u * of_b;
                sums.v += a.v * of_a - b.v * of_b;
                sums.w += a.w * of_a - b.w * of_b;
                sums.level += 0.5 * (a.w * of_a + b.w * of_b);
            }
        }
        (sums.pairs > 0.0).then_some(sums)
    }
}

/// The common borders of all regions, by both (smaller index first): pairs of their cells that are at
/// most three apart with no cell of another region between.
pub(super) fn borders(grid: &Grid, owner: &[u16], regions: usize) -> Vec<((u16, u16), Border)> {
    let (cols, rows) = (grid.cols, grid.rows);
    // Of each region, those with the regions after it.
    let mut found: Vec<Vec<(u16, Border)>> = vec![Vec::new(); regions];
    let edges = Edges::new(owner, cols, rows);
    for (y, i) in (0..rows).flat_map(|y| (0..edges.none.len()).map(move |i| (y, i))) {
        let start = y * cols + 64 * i;
        for (way, step) in edges
            .ahead(i, y)
            .into_iter()
            .zip([1, cols, cols + 1, cols - 1])
        {
            for cell in Ones(way).map(|bit| start + bit) {
                // The first cell of any region; there is one.
                let next = |at: usize| if owner[at] == NONE { at + step } else { at };
                let other = next(next(cell + step));
                let (a, b) = (owner[cell], owner[other]);
                if a == b {
                    continue;
                }
                let pair = [cell as u32, other as u32];
                let pair = if a < b { pair } else { [pair[1], pair[0]] };
                let (of_low, high) = (&mut found[usize::from(a.min(b))], a.max(b));
                // As a rule the next pair is of the same regions: these come first.
                if of_low.first().is_none_or(|(other, _)| *other != high) {
                    match of_low.iter().position(|(other, _)| *other == high) {
                        Some(k) => of_low.swap(0, k),
                        None => of_low.insert(0, (high, Vec::with_capacity(64))),
                    }
                }
                of_low[0].1.push(pair);
            }
        }
    }
    let pairs = (0..).zip(found).flat_map(|(low, others)| {
        let pair = move |(high, border)| ((low, high), border);
        others.into_iter().map(pair)
    });
    pairs.collect()
}

/// The cells of regions, and where cells differ from those beside them.
struct Edges {
    labelled: Bits,
    right: Bits,
    below: Bits,
    below_right: Bits,
    /// A bit for the cell on the left of that which differs from the one below on its left.
    below_left: Bits,
    /// A row without any.
    none: Vec<u64>,
}

impl Edges {
    fn new(owner: &[u16], cols: usize, rows: usize) -> Self {
        // The row and the one below, less so many of the first cells.
        let differs = |here: usize, below: usize| {
            Bits::new(cols, rows, |y, words| {
                if y + 1 < rows {
                    let (row, next) = owner[y * cols..][..2 * cols].split_at(cols);
                    pack(&row[here..], &next[below..], words, |a, b| a != b);
                }
            })
        };
        let one = 1.min(cols);
        Self {
            labelled: Bits::of(owner, cols, |o| o != NONE),
            right: label_boundaries::along(owner, cols, rows),
            below: differs(0, 0),
            below_right: differs(0, one),
            below_left: differs(one, 0),
            none: vec![0; cols.div_ceil(64)],
        }
    }

    /// A row of one of its bitmaps; below the last one there are none.
    fn row<'a>(&'a self, of: &'a Bits, y: usize) -> &'a [u64] {
        if y < of.height { of.row(y) } else { &self.none }
    }

    /// Of 64 columns of row `y`, the `i`th such word, the cells of regions from which there are others
    /// within three cells, and the next one is not of the same region: on the right, below, below on
    /// the right, and below on the left.
    fn ahead(&self, i: usize, y: usize) -> [u64; 4] {
        let [here, a, b, c] = [0, 1, 2, 3].map(|k| self.row(&self.labelled, y + k));
        let ways = [
            self.right.row(y)[i] & (right(here, i, 1) | right(here, i, 2) | right(here, i, 3)),
            self.below.row(y)[i] & (a[i] | b[i] | c[i]),
            self.below_right.row(y)[i] & (right(a, i, 1) | right(b, i, 2) | right(c, i, 3)),
            left(self.below_left.row(y), i, 1) & (left(a, i, 1) | left(b, i, 2) | left(c, i, 3)),
        ];
        ways.map(|way| way & here[i])
    }
}

/// What is `k` columns to the right of each of 64.
fn right(row: &[u64], i: usize, k: u32) -> u64 {
    row[i] >> k | row.get(i + 1).map_or(0, |next| next << (64 - k))
}

/// The same to the left.
fn left(row: &[u64], i: usize, k: u32) -> u64 {
    let last = i.checked_sub(1).map_or(0, |i| row[i]);
    row[i] << k | last >> (64 - k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::organised::image::CELL_PX;
    use crate::organised::moments::Moments;

    #[test]
    fn borders_are_the_pairs_within_three_cells() {
        let (cols, rows) = (70, 14);
        // Three regions with gaps of several widths, across the end of a word.
        let region = |x: usize, y: usize| match (x, y) {
            (_, 0..4) => 2,
            (_, 4..6) | (30..33, _) => NONE,
            (60.., 9..) if x + y > 71 => 1,
            (60.., _) => NONE,
            _ => 2 * u16::from(x > 40 && !(x + y).is_multiple_of(3)),
        };
        let grid = Grid {
            cols,
            rows,
            size: CELL_PX,
            usual: 0.0,
            cells: vec![Moments::default(); cols * rows],
        };
        let at = |i: usize| (i % cols, i / cols);
        let owner: Vec<u16> = (0..cols * rows).map(|i| region(at(i).0, at(i).1)).collect();
        let mut expected = std::collections::BTreeMap::<_, Border>::new();
        for (i, &a) in owner.iter().enumerate().filter(|(_, a)| **a != NONE) {
            for (dx, dy) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
                let ahead = (1..4).filter_map(|k| {
                    let x = at(i).0.checked_add_signed(k * dx).filter(|x| *x < cols)?;
                    let y = at(i).1.checked_add_signed(k * dy).filter(|y| *y < rows)?;
                    (region(x, y) != NONE).then_some(y * cols + x)
                });
                if let Some(j) = ahead.into_iter().next().filter(|j| owner[*j] != a) {
                    let (i, j, b) = (i as u32, j as u32, owner[j]);
                    let pair = if a < b { [i, j] } else { [j, i] };
                    expected.entry((a.min(b), a.max(b))).or_default().push(pair);
                }
            }
        }
        let mut got = borders(&grid, &owner, 3);
        got.iter_mut()
            .for_each(|(_, border)| border.sort_unstable());
        got.sort_unstable();
        expected
            .values_mut()
            .for_each(|border| border.sort_unstable());
        assert_eq!(expected.len(), 3);
        assert_eq!(got, expected.into_iter().collect::<Vec<_>>());
    }
}
