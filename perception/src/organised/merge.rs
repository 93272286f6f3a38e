//! Merging of neighbouring regions that one plane explains.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::growth::{CellNoise, Region};
use super::image::Grid;
use super::moments::Moments;
use crate::Error;
use crate::error::within;
use crate::sensor::Noise;

/// When two regions are one plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MergeConfig {
    /// Both misfits to the joint plane stay below √((k σ)² + (m κ w)²): this is k.
    pub misfit_sigmas: f64,
    /// The m of [`Self::misfit_sigmas`], in units of the sensor's systematic error κ.
    pub misfit_systematics: f64,
    /// The mean step across the common border stays below this many κ w (and 2 σ of the mean):
    /// the slowly varying error bends a plane but does not break it.
    pub step_systematics: f64,
}

impl Default for MergeConfig {
    fn default() -> Self {
        Self {
            misfit_sigmas: 0.5,
            misfit_systematics: 2.5,
            step_systematics: 1.8,
        }
    }
}

impl MergeConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let range = "must be in [0, 100]";
        within("misfit_sigmas", self.misfit_sigmas, 0.0, 100.0, range)?;
        within(
            "misfit_systematics",
            self.misfit_systematics,
            0.0,
            100.0,
            range,
        )?;
        within("step_systematics", self.step_systematics, 0.0, 100.0, range)
    }
}

/// Pairs of neighbouring cells of two regions (smaller index first): their common border.
type Borders = BTreeMap<(usize, usize), Vec<(usize, usize)>>;

/// Merges regions (cells on the small grid) that lie within three cells of each other, the best
/// pair first, only where *both* keep a small misfit under the joint plane and the surface does
/// not step at their border.
pub(super) fn merge(
    grid: &Grid,
    regions: Vec<Region>,
    noise: &Noise,
    config: &MergeConfig,
) -> Vec<Region> {
    let mut borders = borders(grid, &regions);
    let mut regions: Vec<Option<Region>> = regions.into_iter().map(Some).collect();
    // Misfit of every pair in units of its limit; only pairs that a merge touches change.
    let score = |regions: &[Option<Region>], (i, j): (usize, usize), border: &[(usize, usize)]| {
        let (a, b) = (regions[i].as_ref()?, regions[j].as_ref()?);
        misfit(grid, a, b, border, noise, config)
    };
    let mut scores: BTreeMap<(usize, usize), f64> = borders
        .iter()
        .filter_map(|(&pair, border)| Some((pair, score(&regions, pair, border)?)))
        .collect();
    loop {
        let best = scores
            .iter()
            .min_by(|a, b| a.1.total_cmp(b.1))
            .filter(|(_, s)| **s <= 1.0);
        let Some((&(i, j), _)) = best else { break };
        let gone = regions[j].take();
        if let (Some(kept), Some(gone)) = (regions[i].as_mut(), gone) {
            kept.moments.add(&gone.moments, 1.0);
            kept.cells.extend(gone.cells);
            kept.plane = kept.moments.plane().unwrap_or(kept.plane);
        }
        // Borders of j become borders of i; the scores of i's are stale.
        borders.remove(&(i, j));
        let of_j: Vec<_> = borders
            .keys()
            .copied()
            .filter(|p| p.0 == j || p.1 == j)
            .collect();
        for pair in of_j {
            let other = if pair.0 == j { pair.1 } else { pair.0 };
            let swap = (pair.0 == j) != (i < other);
            let moved = borders.remove(&pair).unwrap_or_default();
            let turned = moved
                .into_iter()
                .map(|(a, b)| if swap { (b, a) } else { (a, b) });
            borders
                .entry((i.min(other), i.max(other)))
                .or_default()
                .extend(turned);
        }
        scores.retain(|p, _| p.0 != i && p.1 != i && p.0 != j && p.1 != j);
        for (&pair, border) in borders.iter().filter(|(p, _)| p.0 == i || p.1 == i) {
            if let Some(s) = score(&regions, pair, border) {
                scores.insert(pair, s);
            }
        }
    }
    regions.into_iter().flatten().collect()
}

/// Largest of both misfits to the joint plane and the step at the border, each in units of its
/// limit.
fn misfit(
    grid: &Grid,
    a: &Region,
    b: &Region,
    border: &[(usize, usize)],
    noise: &Noise,
    config: &MergeConfig,
) -> Option<f64> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    let one = |region: &Region| {
        let m: &Moments = &region.moments;
        let excess = m.mean_square(&plane) - m.mean_square(&region.plane);
        let local = CellNoise::at(noise, m.mean());
        (excess / local.square(config.misfit_sigmas, config.misfit_systematics))
            .max(0.0)
            .sqrt()
    };
    // Mean difference of the residuals of the cells on either side of the border.
    let residual = |i: usize| {
        let m = &grid.cells[i];
        m.mean() - plane.at(m.u / m.n, m.v / m.n)
    };
    let count = border.len().max(1) as f64;
    let sum: f64 = border.iter().map(|&(i, j)| residual(i) - residual(j)).sum();
    let w = border
        .iter()
        .map(|&(i, _)| grid.cells[i].mean())
        .sum::<f64>()
        / count;
    let pixels = count * (grid.size * grid.size) as f64;
    let alike = 4.0 * std::f64::consts::PI * noise.correlation_px.powi(2);
    let sigmas = 2.0 * (alike / pixels).min(1.0).sqrt();
    let limit = CellNoise::at(noise, w).square(sigmas, config.step_systematics);
    let step = (sum / count).abs() / limit.sqrt();
    Some(one(a).max(one(b)).max(step))
}

/// The common borders of all regions: pairs of their cells that are at most three apart with no
/// cell of another region between.
fn borders(grid: &Grid, regions: &[Region]) -> Borders {
    const FREE: usize = usize::MAX;
    let mut owner = vec![FREE; grid.cells.len()];
    for (r, region) in regions.iter().enumerate() {
        region.cells.iter().for_each(|&cell| owner[cell] = r);
    }
    let mut borders = Borders::new();
    let (cols, rows) = (grid.cols as i64, grid.rows as i64);
    for (i, &a) in owner.iter().enumerate().filter(|(_, a)| **a != FREE) {
        let (x, y) = (i as i64 % cols, i as i64 / cols);
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
            let ahead = (1..=3)
                .map(|k| (x + k * dx, y + k * dy))
                .take_while(|(x, y)| (0..cols).contains(x) && *y < rows)
                .map(|(x, y)| (y * cols + x) as usize)
                .find(|&j| owner[j] != FREE);
            let Some(j) = ahead else { continue };
            let b = owner[j];
            if a != b && grid.cells[i].n > 0.0 && grid.cells[j].n > 0.0 {
                let cells = if a < b { (i, j) } else { (j, i) };
                borders.entry((a.min(b), a.max(b))).or_default().push(cells);
            }
        }
    }
    borders
}
