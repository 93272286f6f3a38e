//! Breadth-first growth of planar regions over cells.

use serde::{Deserialize, Serialize};

use super::cell::{Cell, CellNoise, coefficients};
use super::image::Grid;
use super::moments::{InversePlane, Moments};
use super::seed::{Shape, seeds};
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
    /// Regions of fewer pixels must stand out from the planes beside them.
    pub claimed_pixels_max: usize,
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
            claimed_pixels_max: 1000,
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

    /// Largest mean square of a seed about its plane, 1/m².
    pub(super) fn seed(&self, noise: &CellNoise) -> f64 {
        noise.square(self.planar_sigmas, 0.5 * self.misfit_systematics)
    }

    /// Largest mean square of a cell about its region's plane beyond that about its own, 1/m².
    pub(super) fn misfit(&self, noise: &CellNoise) -> f64 {
        noise.square(self.misfit_sigmas, self.misfit_systematics)
    }
}

/// One of so many of the seeds that are left is put in order at a time,
const PARTS: usize = 8;
/// and as many as this at least.
const SORTED_MIN: usize = 8;

/// What is known of cells that share a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    pub moments: Moments,
    pub plane: InversePlane,
}

/// A region, and the indices of its cells in the grid that it was grown over.
pub(super) struct Grown {
    pub region: Region,
    pub cells: Vec<usize>,
}

/// Growth over the cells of a grid.
pub(super) struct Growth<'a> {
    pub grid: &'a Grid,
    pub config: &'a GrowthConfig,
    /// Those of the grid's cells that take part, and the index of each among them.
    cells: Vec<Cell>,
    index: Vec<u32>,
    /// Which take no part, or belong to a region by now.
    shut: Vec<bool>,
    /// Cells of the region that grows, and those to go on from.
    members: Vec<usize>,
    queue: Vec<usize>,
    refusing: Vec<usize>,
}

impl<'a> Growth<'a> {
    /// Over those cells for which `free` holds.
    pub fn new(
        grid: &'a Grid,
        free: impl Fn(usize) -> bool,
        noise: &Noise,
        config: &'a GrowthConfig,
    ) -> Self {
        let pixels = (grid.size * grid.size) as f64;
        let least = (1.0 - config.missing_ratio_max) * pixels;
        let mut cells = Vec::with_capacity(grid.cells.len());
        let mut index = vec![0; grid.cells.len()];
        let mut shut = vec![true; grid.cells.len()];
        for (i, m) in grid.cells.iter().enumerate() {
            let takes_part = free(i) && m.n >= least;
            if let Some(cell) = takes_part.then(|| Cell::new(m, noise, config)).flatten() {
                (index[i], shut[i]) = (cells.len() as u32, false);
                cells.push(cell);
            }
        }
        Self {
            grid,
            config,
            cells,
            index,
            shut,
            members: Vec::new(),
            queue: Vec::new(),
            refusing: Vec::new(),
        }
    }

    /// The regions that grow from seeds of these shapes.
    ///
    /// Seeds are planar cells, the flattest first; each grows breadth-first over its side neighbours
    /// with accumulated moments, its plane refitted as it doubles, and is kept if it comes to
    /// `pixels_min`. Every cell belongs to one region at most, in an order that depends on the image
    /// only; those of earlier calls keep theirs.
    pub fn regions(&mut self, shapes: &[Shape], pixels_min: usize) -> Vec<Grown> {
        let limit = |i: usize| self.cells[self.index[i] as usize].seed_max;
        let mut left = seeds(self.grid, limit, &self.shut, shapes);
        let mut regions = Vec::new();
        while !left.is_empty() {
            // The flattest in order. What they grow to has most of the others, which need none then: a
            // cell that a region has stays with it.
            let count = (left.len() / PARTS).max(SORTED_MIN).min(left.len());
            left.select_nth_unstable(count - 1);
            let rest = left.split_off(count);
            left.sort_unstable();
            for seed in left {
                let block = seed.cells(shapes, self.grid);
                if self.is_open(block.clone()) {
                    self.members.clear();
                    self.members.extend(block);
                    regions.extend(self.one(pixels_min));
                }
            }
            left = rest;
            left.retain(|seed| self.is_open(seed.cells(shapes, self.grid)));
        }
        regions
    }

    /// Whether all of some cells take part and belong to no region.
    fn is_open(&self, mut cells: impl Iterator<Item = usize>) -> bool {
        !cells.any(|i| self.shut[i])
    }

    /// One region from the members that it begins with; gives its cells back if it stays too small.
    fn one(&mut self, pixels_min: usize) -> Option<Grown> {
        let (grid, shut, members) = (self.grid, &mut self.shut, &mut self.members);
        let (queue, refusing) = (&mut self.queue, &mut self.refusing);
        let fits = |i: usize, plane: &[f32; 3]| self.cells[self.index[i] as usize].fits(plane);
        let refit = |moments: &Moments, plane| moments.plane().map_or(plane, |p| coefficients(&p));
        let mut moments = Moments::default();
        for &i in &*members {
            moments.add(&grid.cells[i], 1.0);
            shut[i] = true;
        }
        let mut plane = refit(&moments, [0.0; 3]);
        let mut refit_at = 2 * members.len();
        queue.clone_from(members);
        // Twice: what the early planes refused, the final one may accept.
        for _ in 0..2 {
            refusing.clear();
            let mut next = 0;
            while let Some(&i) = queue.get(next) {
                next += 1;
                for &k in &grid.beside(i) {
                    if shut[k] {
                        continue;
                    }
                    if !fits(k, &plane) {
                        if refusing.last() != Some(&i) {
                            refusing.push(i);
                        }
                        continue;
                    }
                    shut[k] = true;
                    moments.add(&grid.cells[k], 1.0);
                    members.push(k);
                    queue.push(k);
                    if members.len() >= refit_at {
                        plane = refit(&moments, plane);
                        refit_at = members.len() * 3 / 2;
                    }
                }
            }
            plane = refit(&moments, plane);
            std::mem::swap(queue, refusing);
        }
        // Cells that the final plane no longer fits go back.
        members.retain(|&i| {
            let stays = fits(i, &plane);
            if !stays {
                moments.add(&grid.cells[i], -1.0);
            }
            shut[i] = stays;
            stays
        });
        let plane = moments.plane();
        match plane {
            Some(plane) if moments.n >= pixels_min as f64 => Some(Grown {
                region: Region { moments, plane },
                cells: members.clone(),
            }),
            _ => {
                members.iter().for_each(|&i| shut[i] = false);
                None
            }
        }
    }
}
