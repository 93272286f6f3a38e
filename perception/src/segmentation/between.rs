//! What the sensor saw between two sets of cells, line by line of the view.

use std::cmp::Ordering;

use super::lattice::{Lattice, PlaneOf, View};
use super::partition::NONE;

/// A gap is hidden where at least this ratio of its cells is.
const HIDDEN_RATIO: f64 = 0.7;
/// So many cells of a gap that show what is beyond a plane show that it is not there; one may be an outlier.
const BEYOND_CELLS: usize = 2;

/// First and last place of a set of cells along every row of the view, then along every column; none where
/// the first is after the last.
#[derive(Default)]
pub(super) struct Ends([Vec<(u32, u32)>; 2]);

impl Ends {
    /// Those of both sets.
    pub fn add(&mut self, other: &Self) {
        let own = self.0.iter_mut().flatten();
        for (a, b) in own.zip(other.0.iter().flatten()) {
            *a = (a.0.min(b.0), a.1.max(b.1));
        }
    }
}

/// Those of `count` sets, given which one each cell is in.
pub(super) fn ends(view: &View, set: &[u16], count: usize) -> Vec<Ends> {
    let none = (u32::MAX, 0);
    let new = |_| Ends([vec![none; view.rows], vec![none; view.cols]]);
    let mut all: Vec<Ends> = (0..count).map(new).collect();
    for y in 0..view.rows {
        for x in 0..view.cols {
            let shown = view.at(y * view.cols + x);
            let Some(set) = shown.map(|cell| set[cell]).filter(|set| *set != NONE) else {
                continue;
            };
            let [rows, cols] = &mut all[usize::from(set)].0;
            let (row, col) = (&mut rows[y], &mut cols[x]);
            // Places come in order.
            *row = (row.0.min(x as u32), x as u32);
            *col = (col.0.min(y as u32), y as u32);
        }
    }
    all
}

/// How many rows and columns of the view that hold two sets apart show what between them.
#[derive(Default)]
pub(super) struct Lines {
    /// What is nearer than the plane, and nothing beyond it.
    pub hidden: usize,
    /// What is beyond the plane: there is a gap in the world.
    pub through: usize,
    /// Neither.
    pub other: usize,
}

impl Lines {
    pub fn new<L: Lattice>(
        lattice: &L,
        view: &View,
        [a, b]: [&Ends; 2],
        plane: &PlaneOf<L>,
    ) -> Self {
        let mut lines = Self::default();
        // From line to line, and along one.
        let steps = [(view.cols, 1), (1, view.cols)];
        for ((a, b), (line, step)) in a.0.iter().zip(&b.0).zip(steps) {
            for ((a, b), start) in a.iter().zip(b).zip((0..).map(|k| k * line)) {
                let (from, to) = if a.1 < b.0 { (a.1, b.0) } else { (b.1, a.0) };
                if a.0 > a.1 || b.0 > b.1 || from + 1 >= to {
                    continue;
                }
                let shown = (from + 1..to).filter_map(|k| view.at(start + k as usize * step));
                let (mut cells, mut nearer, mut beyond) = (0, 0, 0);
                for side in shown.filter_map(|cell| lattice.side(cell, plane)) {
                    cells += 1;
                    nearer += usize::from(side == Ordering::Less);
                    beyond += usize::from(side == Ordering::Greater);
                    if beyond >= BEYOND_CELLS {
                        break;
                    }
                }
                let is_hidden = cells > 0 && nearer as f64 >= HIDDEN_RATIO * f64::from(cells);
                *match (beyond >= BEYOND_CELLS, is_hidden) {
                    (true, _) => &mut lines.through,
                    (_, true) => &mut lines.hidden,
                    _ => &mut lines.other,
                } += 1;
            }
        }
        lines
    }
}
