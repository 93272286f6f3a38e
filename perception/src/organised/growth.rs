//! Breadth-first growth of planar regions over cells.

use std::ops::Range;

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
    /// Length of the strips, in cells, that narrow faces are grown from: the fronts of boards, legs.
    pub strip_cells: usize,
    /// Smallest region that is grown from a strip, px: short strips lie on any edge.
    pub strip_pixels_min: usize,
}

impl Default for GrowthConfig {
    fn default() -> Self {
        Self {
            missing_ratio_max: 0.4,
            planar_sigmas: 1.8,
            misfit_sigmas: 1.2,
            misfit_systematics: 1.5,
            pixels_min: 160,
            strip_cells: 6,
            strip_pixels_min: 400,
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
        )?;
        let cells = self.strip_cells as f64;
        within("strip_cells", cells, 2.0, 1000.0, "must be in [2, 1000]")
    }

    /// Largest mean square of a planar cell about its own plane, 1/m².
    pub(super) fn planar(&self, noise: &CellNoise) -> f64 {
        noise.square(self.planar_sigmas, 0.3)
    }

    /// Largest mean square of a cell about its region's plane beyond that about its own, 1/m².
    pub(super) fn misfit(&self, noise: &CellNoise) -> f64 {
        noise.square(self.misfit_sigmas, self.misfit_systematics)
    }
}

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
    fn lines(self, first: usize, grid: &Grid) -> impl Iterator<Item = Range<usize>> {
        let starts = (0..self.rows).map(move |k| first + k * grid.cols);
        starts.map(move |start| start..start + self.cols)
    }

    /// The first cell wherever all are `open`.
    fn places(self, grid: &Grid, open: &[bool]) -> Vec<usize> {
        let last = |count: usize, of: usize| (count + 1).saturating_sub(of);
        let cols = last(grid.cols, self.cols);
        let mut places = Vec::new();
        for y in 0..last(grid.rows, self.rows) {
            let row = y * grid.cols..y * grid.cols + cols;
            places.extend(row.filter(|&first| {
                open[first] && self.lines(first, grid).all(|l| open[l].iter().all(|o| *o))
            }));
        }
        places
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

/// No region's cell.
pub(super) const FREE: u32 = u32::MAX;

/// The index of the region that each cell of the grid belongs to, or [`FREE`].
pub(super) fn owners(grid: &Grid, regions: &[Region]) -> Vec<u32> {
    let mut owner = vec![FREE; grid.cells.len()];
    for (region, r) in regions.iter().zip(0..) {
        region.cells.iter().for_each(|&cell| owner[cell] = r);
    }
    owner
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
/// Seeds are planar cells of these shapes, the flattest first; each grows breadth-first over its
/// side neighbours with accumulated moments, its plane refitted as it doubles, and is kept if it
/// comes to `pixels_min`. Every cell belongs to one region at most, in an order that depends on the
/// image only.
pub(super) fn grow(
    grid: &Grid,
    free: &dyn Fn(usize) -> bool,
    seeds: &[Seed],
    pixels_min: usize,
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
            (own <= config.planar(&noise)).then_some(Cell { own, noise })
        })
        .collect();
    let mut taken = vec![false; cells.len()];
    let mut regions = Vec::new();
    for (first, number) in seeds_of(grid, &cells, seeds, config) {
        let block = || seeds[number].lines(first, grid);
        if !block().any(|line| taken[line].contains(&true)) {
            let block = block().flatten().collect();
            regions.extend(grow_one(
                grid, &cells, &mut taken, block, pixels_min, config,
            ));
        }
    }
    regions
}

/// Where planar cells fit one plane, flattest first: the first cell, and which of the shapes.
fn seeds_of(
    grid: &Grid,
    cells: &[Option<Cell>],
    shapes: &[Seed],
    config: &GrowthConfig,
) -> Vec<(usize, usize)> {
    let open: Vec<bool> = cells.iter().map(Option::is_some).collect();
    let mut seeds = Vec::new();
    for (number, shape) in shapes.iter().enumerate() {
        for first in shape.places(grid, &open) {
            let Some(cell) = cells[first + shape.rows / 2 * grid.cols + shape.cols / 2] else {
                continue;
            };
            let mut block = Moments::default();
            for line in shape.lines(first, grid) {
                grid.cells[line].iter().for_each(|m| block.add(m, 1.0));
            }
            let Some(plane) = block.plane() else { continue };
            let limit = cell
                .noise
                .square(config.planar_sigmas, 0.5 * config.misfit_systematics);
            let score = block.mean_square(&plane) / limit;
            if score <= 1.0 {
                // Bits of numbers that are not negative are in the order of the numbers.
                let place = first * shapes.len() + number;
                seeds.push((u64::from((score as f32).to_bits()) << 32) | place as u64);
            }
        }
    }
    seeds.sort_unstable();
    let place = |key: u64| (key & u64::from(u32::MAX)) as usize;
    let places = seeds.into_iter().map(place);
    places
        .map(|place| (place / shapes.len(), place % shapes.len()))
        .collect()
}

/// One region from its seed block; gives its cells back if it stays too small.
fn grow_one(
    grid: &Grid,
    cells: &[Option<Cell>],
    taken: &mut [bool],
    block: Vec<usize>,
    pixels_min: usize,
    config: &GrowthConfig,
) -> Option<Region> {
    let fits = |i: usize, plane: &InversePlane| {
        cells[i].is_some_and(|cell| {
            let misfit = grid.cells[i].mean_square(plane) - cell.own;
            misfit <= config.misfit(&cell.noise)
        })
    };
    let mut moments = Moments::default();
    for &i in &block {
        moments.add(&grid.cells[i], 1.0);
        taken[i] = true;
    }
    let mut plane = moments.plane()?;
    let mut refit_at = 2 * block.len();
    let mut members = block;
    // Twice: what the early planes refused, the final one may accept.
    for _ in 0..2 {
        let mut next = 0;
        while let Some(&i) = members.get(next) {
            next += 1;
            for k in grid.beside(i) {
                if taken[k] || !fits(k, &plane) {
                    continue;
                }
                taken[k] = true;
                moments.add(&grid.cells[k], 1.0);
                members.push(k);
                if members.len() >= refit_at {
                    plane = moments.plane()?;
                    refit_at = members.len() * 3 / 2;
                }
            }
        }
        plane = moments.plane()?;
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
        Some(plane) if moments.n >= pixels_min as f64 => Some(Region {
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
