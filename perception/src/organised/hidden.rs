//! Regions that one plane carries on behind what hides it.
//!
//! A floor goes on behind a ramp that stands on it, a wall behind a table. Regions apart are one
//! plane where one explains both and what is seen between them is in front of it.

use super::bits::Bits;
use super::cell::CellNoise;
use super::growth::Region;
use super::image::Grid;
use super::merge::MergeConfig;
use super::moments::InversePlane;
use super::partition::Partition;
use super::words::Ones;
use crate::sensor::Noise;

/// Cells that are nearer than the plane by √((3σ)² + (2κw)²) hide it.
const SIGMAS: f64 = 3.0;
const SYSTEMATICS: f64 = 2.0;
/// A gap is hidden where at least this ratio of its cells is.
const HIDDEN_RATIO: f64 = 0.7;
/// Regions smaller than this tell too little of their plane, px.
const PIXELS_MIN: f64 = 250.0;

/// Merges regions (of cells of the grid) that do not touch, the best pair first, where both keep a
/// misfit below that of `config` for hidden gaps and most rows and columns that hold both have the
/// plane hidden between them.
pub(super) fn merge(grid: &Grid, partition: &mut Partition, noise: &Noise, config: &MergeConfig) {
    let mut regions: Vec<Option<Region>> = partition.regions.iter().copied().map(Some).collect();
    let mut into: Vec<u16> = (0..).take(regions.len()).collect();
    // Where those of them end that were asked for.
    let mut ends: Vec<Option<Ends>> = regions.iter().map(|_| None).collect();
    let of_pair = |regions: &[Option<Region>], (i, j): (usize, usize)| {
        let large = |k: usize| regions[k].as_ref().filter(|r| r.moments.n >= PIXELS_MIN);
        let (score, plane) = misfit(large(i)?, large(j)?, noise, config)?;
        (score < 1.0).then_some((score, plane, (i, j)))
    };
    let pairs = (0..regions.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    let mut pairs: Vec<_> = pairs.filter_map(|pair| of_pair(&regions, pair)).collect();
    while let Some(best) = (0..pairs.len()).min_by(|a, b| pairs[*a].0.total_cmp(&pairs[*b].0)) {
        let (_, plane, (i, j)) = pairs.remove(best);
        for k in [i, j] {
            ends[k].get_or_insert_with(|| Ends::new(grid, &partition.owner, k as u16));
        }
        let both = ends[i].as_ref().zip(ends[j].as_ref());
        if !both.is_some_and(|(a, b)| is_hidden(grid, [a, b], &plane, noise)) {
            // Not for what lies between them; merging others does not change that.
            continue;
        }
        into[j] = i as u16;
        if let (Some(gone), Some(kept)) = (ends[j].take(), ends[i].as_mut()) {
            kept.add(&gone);
        }
        if let (Some(gone), Some(kept)) = (regions[j].take(), regions[i].as_mut()) {
            kept.moments.add(&gone.moments, 1.0);
            kept.plane = plane;
        }
        // Region i is another one now.
        pairs.retain(|(_, _, pair)| ![pair.0, pair.1].iter().any(|k| [i, j].contains(k)));
        let others = (0..regions.len()).filter(|k| *k != i);
        pairs.extend(others.filter_map(|k| of_pair(&regions, (i.min(k), i.max(k)))));
    }
    partition.replace(regions, &into);
}

/// The larger misfit to the joint plane in units of its limit, and that plane.
fn misfit(
    a: &Region,
    b: &Region,
    noise: &Noise,
    config: &MergeConfig,
) -> Option<(f64, InversePlane)> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    let one = |region: &Region| {
        let m = &region.moments;
        let excess = m.mean_square(&plane) - m.mean_square(&region.plane);
        let noise = CellNoise::at(noise, m.mean());
        excess / noise.square(config.misfit_sigmas, config.misfit_systematics_hidden)
    };
    let worst = one(a).max(one(b));
    worst.is_finite().then_some((worst.max(0.0), plane))
}

/// First and last place of a region along every row of the grid, then along every column; none where
/// the first is after the last.
struct Ends([Vec<(u32, u32)>; 2]);

impl Ends {
    fn new(grid: &Grid, owner: &[u16], region: u16) -> Self {
        let none = (u32::MAX, 0);
        let mut rows = vec![none; grid.rows];
        let mut cols = vec![none; grid.cols];
        let cells = Bits::of(owner, grid.cols, |o| o == region);
        for (y, ends) in rows.iter_mut().enumerate() {
            let words = (0..).zip(cells.row(y)).filter(|(_, word)| **word != 0);
            for (i, word) in words {
                let (first, last) = (word.trailing_zeros(), 63 - word.leading_zeros());
                *ends = (ends.0.min(64 * i + first), 64 * i + last);
            }
        }
        first(&cells, 0..grid.rows, |x, y| cols[x].0 = y as u32);
        first(&cells, (0..grid.rows).rev(), |x, y| cols[x].1 = y as u32);
        Self([rows, cols])
    }

    /// Those of both regions.
    fn add(&mut self, other: &Self) {
        let own = self.0.iter_mut().flatten();
        for (a, b) in own.zip(other.0.iter().flatten()) {
            *a = (a.0.min(b.0), a.1.max(b.1));
        }
    }
}

/// Calls `with` for the first cell of each column, and its row, when the rows are taken in this order.
fn first(cells: &Bits, rows: impl Iterator<Item = usize>, mut with: impl FnMut(usize, usize)) {
    // Columns without one in the rows so far.
    let mut open = vec![!0; cells.width.div_ceil(64)];
    for y in rows {
        for (i, (open, word)) in open.iter_mut().zip(cells.row(y)).enumerate() {
            Ones(*open & word).for_each(|bit| with(64 * i + bit, y));
            *open &= !word;
        }
    }
}

/// Whether most of the rows and columns of cells that hold both regions have the plane hidden
/// between them.
fn is_hidden(grid: &Grid, [a, b]: [&Ends; 2], plane: &InversePlane, noise: &Noise) -> bool {
    let hides = |i: usize| {
        let m = &grid.cells[i];
        if m.n < 1.0 {
            return None;
        }
        let inverse = 1.0 / m.n;
        let w = plane.at(m.u * inverse, m.v * inverse);
        let nearer = m.w * inverse - w;
        let limit = CellNoise::at(noise, w).square(SIGMAS, SYSTEMATICS);
        Some(nearer > 0.0 && nearer * nearer > limit)
    };
    let (mut hidden, mut open) = (0, 0);
    // From line to line, and along one.
    let steps = [(grid.cols, 1), (1, grid.cols)];
    for ((a, b), (line, step)) in a.0.iter().zip(&b.0).zip(steps) {
        for ((a, b), start) in a.iter().zip(b).zip((0..).map(|k| k * line)) {
            let (from, to) = if a.1 < b.0 { (a.1, b.0) } else { (b.1, a.0) };
            if a.0 > a.1 || b.0 > b.1 || from + 1 >= to {
                continue;
            }
            let seen = (from + 1..to).filter_map(|k| hides(start + k as usize * step));
            let (mut cells, mut nearer) = (0, 0);
            for is in seen {
                cells += 1;
                nearer += usize::from(is);
            }
            if cells > 0 && nearer as f64 >= HIDDEN_RATIO * f64::from(cells) {
                hidden += 1;
            } else {
                open += 1;
            }
        }
    }
    hidden > open
}
