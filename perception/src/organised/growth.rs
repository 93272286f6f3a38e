//! Breadth-first growth of planar regions over cells.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::image::Grid;
use super::moments::{InversePlane, Moments};
use crate::Error;
use crate::error::within;
use crate::sensor::Noise;

/// Which cells belong to one plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GrowthConfig {
    /// Largest ratio of pixels without depth in a cell that takes part.
    pub missing_ratio_max: f64,
    /// A cell is planar while the root mean square about its own plane is below this many σ.
    pub planar_sigmas: f64,
    /// A cell joins while its misfit to the region's plane, beyond its own noise, is below
    /// √((k σ)² + (m κ w)²): this is k.
    pub misfit_sigmas: f64,
    /// The m of [`Self::misfit_sigmas`], in units of the sensor's systematic error κ.
    pub misfit_systematics: f64,
    /// Smallest region, px.
    pub pixels_min: usize,
}

impl Default for GrowthConfig {
    fn default() -> Self {
        Self {
            missing_ratio_max: 0.4,
            planar_sigmas: 1.8,
            misfit_sigmas: 1.2,
            misfit_systematics: 1.5,
            pixels_min: 160,
        }
    }
}

impl GrowthConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let positive = "must be positive and below 100";
        within(
            "missing_ratio_max",
            self.missing_ratio_max,
            0.0,
            0.9,
            "must be in [0, 0.9]",
        )?;
        within("planar_sigmas", self.planar_sigmas, 1e-3, 100.0, positive)?;
        within("misfit_sigmas", self.misfit_sigmas, 1e-3, 100.0, positive)?;
        within(
            "misfit_systematics",
            self.misfit_systematics,
            0.0,
            100.0,
            positive,
        )
    }
}

/// Cells of one grid that share a plane.
#[derive(Debug, Clone)]
pub(super) struct Region {
    pub moments: Moments,
    pub plane: InversePlane,
    /// Indices of the cells in the grid that was grown over.
    pub cells: Vec<usize>,
}

/// One cell's noise, for the tests of growth and merging.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellNoise {
    /// σ of one pixel's inverse depth, 1/m.
    pub sigma: f64,
    /// κ w: systematic error of inverse depth, 1/m.
    pub systematic: f64,
}

impl CellNoise {
    /// At inverse depth `w`, 1/m.
    pub fn at(noise: &Noise, w: f64) -> Self {
        Self {
            sigma: noise.sigma_inverse(1.0 / w),
            systematic: noise.systematic_ratio * w,
        }
    }

    /// (k σ)² + (m κ w)².
    pub fn square(&self, sigmas: f64, systematics: f64) -> f64 {
        (sigmas * self.sigma).powi(2) + (systematics * self.systematic).powi(2)
    }
}

/// A cell that takes part: its own fit and noise.
#[derive(Clone, Copy)]
struct Cell {
    own: f64,
    noise: CellNoise,
}

/// Grows regions over the cells of `grid` for which `free` holds.
///
/// Seeds are blocks of 3 × 3 planar cells, the flattest first; each grows breadth-first over its
/// side neighbours with accumulated moments, its plane refitted as it doubles. Every cell belongs
/// to one region at most, in an order that depends on the image only.
pub(super) fn grow(
    grid: &Grid,
    free: &dyn Fn(usize) -> bool,
    noise: &Noise,
    config: &GrowthConfig,
) -> Vec<Region> {
    let pixels = (grid.size * grid.size) as f64;
    let cells: Vec<Option<Cell>> = grid
        .cells
        .iter()
        .enumerate()
        .map(|(i, m)| {
            if m.n < (1.0 - config.missing_ratio_max) * pixels || !free(i) {
                return None;
            }
            let own = m.mean_square(&m.plane()?);
            let noise = CellNoise::at(noise, m.mean());
            (own <= noise.square(config.planar_sigmas, 0.3)).then_some(Cell { own, noise })
        })
        .collect();

    // Seeds: 3 × 3 planar cells that fit one plane, flattest first.
    let mut seeds = Vec::new();
    let inner = |n: usize| 1..n.saturating_sub(1);
    for i in inner(grid.rows).flat_map(|y| inner(grid.cols).map(move |x| y * grid.cols + x)) {
        let Some(cell) = cells[i] else { continue };
        let rows = [i - grid.cols, i, i + grid.cols].map(|k| k - 1..k + 2);
        if rows
            .iter()
            .any(|row| cells[row.clone()].iter().any(Option::is_none))
        {
            continue;
        }
        let mut block = Moments::default();
        let around = rows.iter().flat_map(|row| &grid.cells[row.clone()]);
        around.for_each(|cell| block.add(cell, 1.0));
        let Some(plane) = block.plane() else { continue };
        let limit = cell
            .noise
            .square(config.planar_sigmas, 0.5 * config.misfit_systematics);
        let score = block.mean_square(&plane) / limit;
        if score <= 1.0 {
            // Bits of numbers that are not negative are in the order of the numbers.
            seeds.push((u64::from((score as f32).to_bits()) << 32) | i as u64);
        }
    }
    seeds.sort_unstable();

    let mut taken = vec![false; cells.len()];
    let mut regions = Vec::new();
    for key in seeds {
        let seed = (key & u64::from(u32::MAX)) as usize;
        let (above, below) = (seed - grid.cols, seed + grid.cols);
        let [a, b, c] = [above, seed, below].map(|i| [i - 1, i, i + 1]);
        // The seed, its sides, its corners.
        let block = [b[1], a[1], b[0], b[2], c[1], a[0], a[2], c[0], c[2]];
        if block.iter().any(|&i| taken[i]) {
            continue;
        }
        if let Some(region) = grow_one(grid, &cells, &mut taken, block.to_vec(), config) {
            regions.push(region);
        }
    }
    regions
}

/// One region from its seed block; gives its cells back if it stays too small.
fn grow_one(
    grid: &Grid,
    cells: &[Option<Cell>],
    taken: &mut [bool],
    block: Vec<usize>,
    config: &GrowthConfig,
) -> Option<Region> {
    let fits = |i: usize, plane: &InversePlane| {
        cells[i].is_some_and(|cell| {
            let misfit = grid.cells[i].mean_square(plane) - cell.own;
            misfit
                <= cell
                    .noise
                    .square(config.misfit_sigmas, config.misfit_systematics)
        })
    };
    let mut moments = Moments::default();
    for &i in &block {
        moments.add(&grid.cells[i], 1.0);
        taken[i] = true;
    }
    let mut plane = moments.plane()?;
    let mut refit_at = 2 * block.len();
    let mut members = block.clone();
    let mut queue = VecDeque::from(block);
    // Twice: what the early planes refused, the final one may accept.
    for _ in 0..2 {
        while let Some(i) = queue.pop_front() {
            for k in grid.beside(i) {
                if taken[k] || !fits(k, &plane) {
                    continue;
                }
                taken[k] = true;
                moments.add(&grid.cells[k], 1.0);
                members.push(k);
                queue.push_back(k);
                if members.len() >= refit_at {
                    plane = moments.plane()?;
                    refit_at = members.len() * 3 / 2;
                }
            }
        }
        plane = moments.plane()?;
        queue.extend(&members);
    }
    // Cells that the final plane no longer fits go back.
    members.retain(|&i| {
        let stays = fits(i, &plane);
        taken[i] = stays;
        stays
    });
    let mut moments = Moments::default();
    members
        .iter()
        .for_each(|&i| moments.add(&grid.cells[i], 1.0));
    let plane = moments.plane();
    match plane {
        Some(plane) if moments.n >= config.pixels_min as f64 => Some(Region {
            moments,
            plane,
            cells: members,
        }),
        _ => {
            members.iter().for_each(|&i| taken[i] = false);
            None
        }
    }
}
