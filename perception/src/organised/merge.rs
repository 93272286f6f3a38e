//! Merging of neighbouring regions that one plane explains.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::cell::CellNoise;
use super::growth::{FREE, Region, owners};
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
    /// The same m for regions smaller than the error's waves: all of one may lie on a crest.
    pub misfit_systematics_small: f64,
    /// The same m for regions apart, where what is between them hides the plane.
    pub misfit_systematics_hidden: f64,
    /// The mean step across the common border stays below this many κ w (and 2 σ of the mean):
    /// the slowly varying error bends a plane but does not break it.
    pub step_systematics: f64,
}

impl Default for MergeConfig {
    fn default() -> Self {
        Self {
            misfit_sigmas: 0.5,
            misfit_systematics: 2.5,
            misfit_systematics_small: 4.0,
            misfit_systematics_hidden: 2.0,
            step_systematics: 1.8,
        }
    }
}

impl MergeConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let range = "must be in [0, 100]";
        for (key, value) in [
            ("misfit_sigmas", self.misfit_sigmas),
            ("misfit_systematics", self.misfit_systematics),
            ("misfit_systematics_small", self.misfit_systematics_small),
            ("misfit_systematics_hidden", self.misfit_systematics_hidden),
            ("step_systematics", self.step_systematics),
        ] {
            within(key, value, 0.0, 100.0, range)?;
        }
        Ok(())
    }
}

/// The common borders of regions (smaller index first).
type Borders = BTreeMap<(usize, usize), Border>;

/// Sums over the pairs of neighbouring cells of two regions, one of each: all that the step of a
/// plane's residuals across their border needs.
#[derive(Debug, Clone, Copy, Default)]
struct Border {
    pairs: f64,
    /// Differences of the cells' mean u, v and w, first region less second.
    u: f64,
    v: f64,
    w: f64,
    /// Mean w of both.
    level: f64,
}

impl Border {
    fn push(&mut self, a: &Moments, b: &Moments) {
        self.pairs += 1.0;
        let (of_a, of_b) = (1.0 / a.n, 1.0 / b.n);
        self.u += a.u * of_a - b.u * of_b;
        self.v += a.v * of_a - b.v * of_b;
        let (of_a, of_b) = (a.w * of_a, b.w * of_b);
        self.w += of_a - of_b;
        self.level += 0.5 * (of_a + of_b);
    }

    /// Adds another, `sign` −1 when its regions are the other way around.
    fn add(&mut self, other: &Self, sign: f64) {
        self.pairs += other.pairs;
        self.u += sign * other.u;
        self.v += sign * other.v;
        self.w += sign * other.w;
        self.level += other.level;
    }
}

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
    let pixels = (grid.size * grid.size) as f64;
    let score = |regions: &[Option<Region>], (i, j): (usize, usize), border: &Border| {
        let (a, b) = (regions[i].as_ref()?, regions[j].as_ref()?);
        misfit(a, b, border, pixels, noise, config)
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
            let entry = borders.entry((i.min(other), i.max(other))).or_default();
            entry.add(&moved, if swap { -1.0 } else { 1.0 });
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
/// limit. `pixels` are those of a cell.
fn misfit(
    a: &Region,
    b: &Region,
    border: &Border,
    pixels: f64,
    noise: &Noise,
    config: &MergeConfig,
) -> Option<f64> {
    let mut joint = a.moments;
    joint.add(&b.moments, 1.0);
    let plane = joint.plane()?;
    // Misfits beyond the regions' own, 1/m, and in units of their limits.
    let small = 4.0 * std::f64::consts::PI * noise.systematic_scale_px.powi(2);
    let one = |region: &Region| {
        let m: &Moments = &region.moments;
        let excess = m.mean_square(&plane) - m.mean_square(&region.plane);
        let systematics = if m.n < small {
            config.misfit_systematics_small
        } else {
            config.misfit_systematics
        };
        let local = CellNoise::at(noise, m.mean());
        let excess = excess.max(0.0).sqrt();
        (
            excess,
            excess / local.square(config.misfit_sigmas, systematics).sqrt(),
        )
    };
    let (of_a, of_b) = (one(a), one(b));
    // Mean difference of the residuals of the cells on either side of the border. The joint plane
    // of two patches of a size lies a quarter of the step between them off each, in the mean: what
    // is far more is an error of the cells there, at the edge of what hides the rest.
    let count = border.pairs.max(1.0);
    let step = (border.w - plane.0.x * border.u - plane.0.y * border.v) / count;
    let step = step.abs().min(STEP_OF_MISFIT * of_a.0.max(of_b.0));
    let alike = 4.0 * std::f64::consts::PI * noise.correlation_px.powi(2);
    let sigmas = 2.0 * (alike / (count * pixels)).min(1.0).sqrt();
    let limit = CellNoise::at(noise, border.level / count).square(sigmas, config.step_systematics);
    Some(of_a.1.max(of_b.1).max(step / limit.sqrt()))
}

/// A step is at most this many times the larger misfit.
const STEP_OF_MISFIT: f64 = 5.0;

/// The common borders of all regions: pairs of their cells that are at most three apart with no
/// cell of another region between.
fn borders(grid: &Grid, regions: &[Region]) -> Borders {
    let owner = owners(grid, regions);
    // Of each region, those with the regions after it.
    let mut found: Vec<Vec<(u32, Border)>> = vec![Vec::new(); regions.len()];
    let (cols, rows) = (grid.cols, grid.rows);
    // Of a row, the cells with no other region on the right, below, and below on the right and left.
    let mut inside = vec![false; cols];
    for y in 0..rows {
        let (here, below) = owner[y * cols..].split_at(cols);
        inside_of(here, below.get(..cols).unwrap_or_default(), &mut inside);
        let outer = (0..cols).filter(|&x| here[x] != FREE && !inside[x]);
        for x in outer {
            let (a, i) = (here[x], y * cols + x);
            let (right, down) = (cols - 1 - x, rows - 1 - y);
            // To the right, down, and down to the right and left: how far the grid goes, and the step.
            let ways = [
                (right, 1),
                (down, cols),
                (right.min(down), cols + 1),
                (x.min(down), cols - 1),
            ];
            for &(most, step) in &ways {
                // The first cell of any region, if that is another one.
                let mut ahead = (1..most.min(3) + 1).map(|k| i + k * step);
                let Some(j) = ahead.find(|&j| owner[j] != FREE) else {
                    continue;
                };
                let b = owner[j];
                if b == a {
                    continue;
                }
                let (first, second) = if a < b { (i, j) } else { (j, i) };
                let (first, second) = (&grid.cells[first], &grid.cells[second]);
                if first.n > 0.0 && second.n > 0.0 {
                    let (low, high) = (a.min(b) as usize, a.max(b));
                    let known = found[low].iter().position(|(other, _)| *other == high);
                    let k = known.unwrap_or_else(|| {
                        found[low].push((high, Border::default()));
                        found[low].len() - 1
                    });
                    found[low][k].1.push(first, second);
                }
            }
        }
    }
    let pairs = found.into_iter().enumerate().flat_map(|(low, others)| {
        let pair = move |(high, border): (u32, Border)| ((low, high as usize), border);
        others.into_iter().map(pair)
    });
    pairs.collect()
}

/// Whether each cell is as those to the right, down, and down to the right and left.
fn inside_of(here: &[u32], below: &[u32], inside: &mut [bool]) {
    inside.fill(false);
    let Some(n) = here.len().checked_sub(2).filter(|_| !below.is_empty()) else {
        return;
    };
    let (left, down, other) = (&below[..n], &below[1..=n], &below[2..]);
    let (here, right, inside) = (&here[1..=n], &here[2..], &mut inside[1..=n]);
    for i in 0..n {
        let differs = (right[i] ^ here[i]) | (left[i] ^ here[i]);
        inside[i] = differs | (down[i] ^ here[i]) | (other[i] ^ here[i]) == 0;
    }
}
