//! Growth of planar regions over voxels, from the largest to the smallest.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::grid::{Grid, Level, NONE};
use super::moments::{Fit, Moments, Plane};
use super::tolerance::Tolerance;
use crate::Error;
use crate::error::within;

/// Which voxels belong to one plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VoxelGrowthConfig {
    /// Fewest points of a voxel with a plane of its own.
    pub cell_points_min: usize,
    /// A voxel is planar while the root mean square about its own plane is below this many σ.
    pub planar_sigmas: f64,
    /// A voxel joins while its misfit to the region's plane, beyond its own noise, is below
    /// √((k σ)² + (m κ r)²): this is k.
    pub misfit_sigmas: f64,
    /// The m of [`Self::misfit_sigmas`], in units of the sensor's systematic error κ.
    pub misfit_systematics: f64,
    /// The distance limit: none of these is ever larger, m.
    pub distance_max_m: f64,
    /// Fewest points of a region.
    pub points_min: usize,
    /// Smallest region: so much area do the sides of its voxels make, m².
    pub area_min_m2: f64,
}

impl Default for VoxelGrowthConfig {
    fn default() -> Self {
        Self {
            cell_points_min: 6,
            planar_sigmas: 1.5,
            misfit_sigmas: 1.2,
            misfit_systematics: 1.5,
            distance_max_m: 0.06,
            points_min: 60,
            area_min_m2: 0.012,
        }
    }
}

impl VoxelGrowthConfig {
    pub(super) fn check(&self) -> Result<(), Error> {
        let positive = "must be positive and below 100";
        within("planar_sigmas", self.planar_sigmas, 1e-3, 100.0, positive)?;
        within("misfit_sigmas", self.misfit_sigmas, 1e-3, 100.0, positive)?;
        within(
            "misfit_systematics",
            self.misfit_systematics,
            0.0,
            100.0,
            positive,
        )?;
        for (key, value) in [
            ("distance_max_m", self.distance_max_m),
            ("area_min_m2", self.area_min_m2),
        ] {
            within(key, value, 1e-6, 1e3, "must be positive")?;
        }
        within(
            "cell_points_min",
            self.cell_points_min as f64,
            3.0,
            1e6,
            "must be at least 3",
        )
    }
}

/// Voxels that share a plane.
#[derive(Debug, Clone)]
pub(super) struct Region {
    pub moments: Moments,
    pub plane: Plane,
}

/// Owners of the voxels of each level, and the regions.
pub(super) struct Grown {
    /// Region of every smallest voxel, or [`NONE`].
    pub owner: Vec<u32>,
    pub regions: Vec<Region>,
}

/// Grows regions over the voxels of every size, from the largest down: what a level leaves is
/// first offered to the regions beside it, then seeds new ones.
pub(super) fn grow(grid: &Grid, tolerance: &Tolerance, config: &VoxelGrowthConfig) -> Grown {
    let mut regions: Vec<Region> = Vec::new();
    let mut above: Vec<u32> = Vec::new();
    for (number, level) in grid.levels.iter().enumerate().rev() {
        let mut owner: Vec<u32> = match above.is_empty() {
            true => vec![NONE; level.cells.len()],
            false => level.parents.iter().map(|&p| above[p as usize]).collect(),
        };
        let mut cells = Cells::new(level, tolerance, config);
        cells.extend(&mut owner, &mut regions);
        cells.seed(&mut owner, &mut regions, number == 0);
        above = owner;
    }
    Grown {
        owner: above,
        regions,
    }
}

/// The voxels of one level with their own planes.
struct Cells<'a> {
    level: &'a Level,
    tolerance: &'a Tolerance<'a>,
    config: &'a VoxelGrowthConfig,
    /// The plane of each, where its points are enough, span it and lie on it.
    own: Vec<Option<Fit>>,
}

impl<'a> Cells<'a> {
    fn new(level: &'a Level, tolerance: &'a Tolerance, config: &'a VoxelGrowthConfig) -> Self {
        let spread = (SPREAD_MIN * level.side_m).powi(2);
        let own = level
            .cells
            .iter()
            .map(|cell| {
                if cell.n < config.cell_points_min as f64 {
                    return None;
                }
                let fit = cell.fit()?;
                let limit = tolerance.at(&cell.mean(), &fit.plane, config.planar_sigmas, 0.5);
                (fit.middle >= spread.max(4.0 * fit.least) && fit.least <= limit * limit)
                    .then_some(fit)
            })
            .collect();
        Self {
            level,
            tolerance,
            config,
            own,
        }
    }

    /// Misfit of a voxel to a plane in units of its limit; at most 1 where it belongs.
    fn misfit(&self, i: usize, plane: &Plane) -> f64 {
        let cell = &self.level.cells[i];
        let config = self.config;
        let limit = self.tolerance.at(
            &cell.mean(),
            plane,
            config.misfit_sigmas,
            config.misfit_systematics,
        );
        let own = match &self.own[i] {
            Some(fit) => {
                // The same way to half a right angle: a corner's voxels are near both planes.
                if fit.plane.normal.dot(&plane.normal).abs() < ALIKE && fit.least < 0.1 * fit.middle
                {
                    return f64::INFINITY;
                }
                fit.least
            }
            // Too few points for a plane of their own: each of them must be near.
            None => 0.0,
        };
        ((cell.mean_square(plane) - own).max(0.0)).sqrt() / limit
    }

    /// Offers the voxels without an owner to the regions beside them.
    fn extend(&mut self, owner: &mut [u32], regions: &mut [Region]) {
        let mut queue: VecDeque<usize> = (0..owner.len()).filter(|&i| owner[i] != NONE).collect();
        // Each gives to its neighbours; the nearest plane of all that touch a voxel takes it.
        while let Some(i) = queue.pop_front() {
            for &k in self.level.around[i].iter().filter(|k| **k != NONE) {
                let k = k as usize;
                let here = &regions[owner[i] as usize].plane;
                if owner[k] != NONE || self.misfit(k, here) > 1.0 {
                    continue;
                }
                let best = self.level.around[k]
                    .iter()
                    .filter(|j| **j != NONE && owner[**j as usize] != NONE)
                    .map(|&j| {
                        let r = owner[j as usize];
                        (self.misfit(k, &regions[r as usize].plane), r)
                    })
                    .reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a });
                if let Some((_, r)) = best {
                    owner[k] = r;
                    regions[r as usize].moments.add(&self.level.cells[k]);
                    queue.push_back(k);
                }
            }
        }
        for region in regions {
            if let Some(fit) = region.moments.fit() {
                region.plane = fit.plane;
            }
        }
    }

    /// Grows new regions from blocks of voxels that fit one plane, the flattest first.
    fn seed(&mut self, owner: &mut [u32], regions: &mut Vec<Region>, smallest: bool) {
        let least = if smallest { BLOCK_MIN } else { BLOCK_MIN_LARGE };
        let mut seeds: Vec<(f64, usize)> = Vec::new();
        for (i, own) in self.own.iter().enumerate() {
            let Some(own) = own.filter(|_| owner[i] == NONE) else {
                continue;
            };
            let block = self.block(i, owner);
            if block.len() < least {
                continue;
            }
            let mut moments = Moments::default();
            block
                .iter()
                .for_each(|&k| moments.add(&self.level.cells[k]));
            let Some(fit) = moments.fit() else { continue };
            let limit = self.tolerance.at(
                &moments.mean(),
                &fit.plane,
                self.config.planar_sigmas,
                0.5 * self.config.misfit_systematics,
            );
            let score = fit.least.sqrt() / limit;
            if score <= 1.0 && own.plane.normal.dot(&fit.plane.normal).abs() > ALIKE {
                seeds.push((score, i));
            }
        }
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, seed) in seeds {
            let block = self.block(seed, owner);
            if owner[seed] == NONE && block.len() >= least {
                let number = regions.len() as u32;
                if let Some(region) = self.grow_one(owner, block, number) {
                    regions.push(region);
                }
            }
        }
    }

    /// A voxel and its planar neighbours without an owner that look the same way.
    fn block(&self, i: usize, owner: &[u32]) -> Vec<usize> {
        let Some(own) = &self.own[i] else {
            return Vec::new();
        };
        let free = |k: &usize| {
            owner[*k] == NONE
                && self.own[*k]
                    .is_some_and(|fit| fit.plane.normal.dot(&own.plane.normal).abs() > ALIKE)
        };
        let around = self.level.around[i].iter().filter(|k| **k != NONE);
        std::iter::once(i)
            .chain(around.map(|&k| k as usize))
            .filter(free)
            .collect()
    }

    /// One region from its seed block; gives its voxels back if it stays too small.
    fn grow_one(&self, owner: &mut [u32], block: Vec<usize>, number: u32) -> Option<Region> {
        let mut moments = Moments::default();
        for &i in &block {
            moments.add(&self.level.cells[i]);
            owner[i] = number;
        }
        let give_back = |owner: &mut [u32], members: &[usize]| {
            members.iter().for_each(|&i| owner[i] = NONE);
        };
        let Some(mut plane) = moments.fit().map(|fit| fit.plane) else {
            give_back(owner, &block);
            return None;
        };
        let mut members = block.clone();
        let mut refit_at = 2 * block.len();
        let mut queue = VecDeque::from(block);
        // Twice: what the early planes refused, the final one may accept.
        for _ in 0..2 {
            while let Some(i) = queue.pop_front() {
                for &k in self.level.around[i].iter().filter(|k| **k != NONE) {
                    let k = k as usize;
                    if owner[k] != NONE || self.misfit(k, &plane) > 1.0 {
                        continue;
                    }
                    owner[k] = number;
                    moments.add(&self.level.cells[k]);
                    members.push(k);
                    queue.push_back(k);
                    if members.len() >= refit_at {
                        plane = moments.fit().map_or(plane, |fit| fit.plane);
                        refit_at = members.len() * 3 / 2;
                    }
                }
            }
            plane = moments.fit().map_or(plane, |fit| fit.plane);
            queue.extend(&members);
        }
        // Voxels that the final plane no longer fits go back.
        let mut moments = Moments::default();
        for &i in &members {
            if self.misfit(i, &plane) <= 1.0 {
                moments.add(&self.level.cells[i]);
            } else {
                owner[i] = NONE;
            }
        }
        members.retain(|&i| owner[i] == number);
        let area_m2 = members.len() as f64 * self.level.side_m.powi(2);
        let large =
            moments.n >= self.config.points_min as f64 && area_m2 >= self.config.area_min_m2;
        match moments.fit().filter(|_| large) {
            Some(fit) => Some(Region {
                moments,
                plane: fit.plane,
            }),
            None => {
                give_back(owner, &members);
                None
            }
        }
    }
}

/// Points span a voxel's plane where they spread this far across, in sides of the voxel.
const SPREAD_MIN: f64 = 0.08;
/// Cosine of the angle to which two voxels look the same way, 30°.
const ALIKE: f64 = 0.866;
/// Planar voxels in the 3 × 3 × 3 around a seed, itself included: the small ones of a face of
/// 0.1 m, and of large ones fewer that are surely no chance.
const BLOCK_MIN: usize = 4;
const BLOCK_MIN_LARGE: usize = 4;
