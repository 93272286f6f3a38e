//! Regions that one plane carries on behind what hides it.
//!
//! A floor goes on behind a ramp that stands on it, a wall behind a table. Regions apart are one
//! plane where one explains both and what is seen between them is in front of it.

use super::growth::{CellNoise, Region};
use super::image::Grid;
use super::merge::MergeConfig;
use super::moments::InversePlane;
use crate::sensor::Noise;

/// Cells that are nearer than the plane by √((3σ)² + (2κw)²) hide it.
const SIGMAS: f64 = 3.0;
const SYSTEMATICS: f64 = 2.0;
/// A gap is hidden where at least this ratio of its cells is.
const HIDDEN_RATIO: f64 = 0.7;
/// Regions smaller than this tell too little of their plane, px.
const PIXELS_MIN: f64 = 250.0;

/// Merges regions (cells on the grid) that do not touch, the best pair first, where both keep a
/// misfit below that of `config` for hidden gaps and most rows and columns that hold both have the
/// plane hidden between them.
pub(super) fn merge(
    grid: &Grid,
    mut regions: Vec<Region>,
    noise: &Noise,
    config: &MergeConfig,
) -> Vec<Region> {
    // Which pairs were refused for what lies between them; merging does not change that.
    let mut refused: Vec<(usize, usize)> = Vec::new();
    loop {
        let mut best: Option<(f64, InversePlane, (usize, usize))> = None;
        for (j, b) in regions
            .iter()
            .enumerate()
            .filter(|(_, r)| r.moments.n >= PIXELS_MIN)
        {
            for (i, a) in regions[..j].iter().enumerate() {
                if a.moments.n < PIXELS_MIN || refused.contains(&(i, j)) {
                    continue;
                }
                let least = best.as_ref().map_or(1.0, |(score, ..)| *score);
                if let Some((score, plane)) = misfit(a, b, noise, config).filter(|m| m.0 < least) {
                    best = Some((score, plane, (i, j)));
                }
            }
        }
        let Some((_, plane, (i, j))) = best else {
            break;
        };
        if !is_hidden(grid, &regions[i], &regions[j], &plane, noise) {
            refused.push((i, j));
            continue;
        }
        let gone = regions.remove(j);
        let kept = &mut regions[i];
        kept.moments.add(&gone.moments, 1.0);
        kept.cells.extend(gone.cells);
        kept.plane = plane;
        // Indices above j have moved, and region i is another one now.
        refused.retain(|&(a, b)| [a, b].iter().all(|&k| k != i && k != j));
        for pair in &mut refused {
            pair.0 -= usize::from(pair.0 > j);
            pair.1 -= usize::from(pair.1 > j);
        }
    }
    regions
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

/// Whether most of the rows and columns of cells that hold both regions have the plane hidden
/// between them.
fn is_hidden(grid: &Grid, a: &Region, b: &Region, plane: &InversePlane, noise: &Noise) -> bool {
    let hides = |i: usize| {
        let m = &grid.cells[i];
        if m.n < 1.0 {
            return None;
        }
        let w = plane.at(m.u / m.n, m.v / m.n);
        let nearer = m.mean() - w;
        let limit = CellNoise::at(noise, w).square(SIGMAS, SYSTEMATICS);
        Some(nearer > 0.0 && nearer * nearer > limit)
    };
    let (mut hidden, mut open) = (0, 0);
    for (lines, count, step) in [(grid.rows, grid.cols, 1), (grid.cols, grid.rows, grid.cols)] {
        // First and last place of either region along every line.
        let place = |cell: usize| match step {
            1 => (cell / grid.cols, cell % grid.cols),
            _ => (cell % grid.cols, cell / grid.cols),
        };
        let ends = |region: &Region| {
            let mut ends = vec![(count, 0); lines];
            for &cell in &region.cells {
                let (line, k) = place(cell);
                let (first, last) = &mut ends[line];
                (*first, *last) = ((*first).min(k), (*last).max(k));
            }
            ends
        };
        for (line, (a, b)) in ends(a).into_iter().zip(ends(b)).enumerate() {
            let (from, to) = if a.1 < b.0 { (a.1, b.0) } else { (b.1, a.0) };
            if a.0 > a.1 || b.0 > b.1 || from + 1 >= to {
                continue;
            }
            let start = if step == 1 { line * grid.cols } else { line };
            let seen = (from + 1..to).filter_map(|k| hides(start + k * step));
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
