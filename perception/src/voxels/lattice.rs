//! The voxels of one size as a lattice to segment.

use std::cmp::Ordering;

use nalgebra::Vector3;

use super::grid::Level;
use super::moments::{Fit, Moments, Plane};
use super::tolerance::Tolerance;
use crate::segmentation::{
    self, Border, Lattice, MISFIT, NONE, ON_PLANE, Partition, Seed, Shape, View, seed_of,
};
use crate::spherical_range_image::{angles_of, axis};

/// Fewest points of a voxel with a plane of its own.
const CELL_POINTS_MIN: f64 = 6.0;
/// A voxel is planar while the root mean square about its own plane is below this many σ.
const PLANAR_SIGMAS: f64 = 1.5;
/// Points span a voxel's plane where they spread this far across, in sides of the voxel.
const SPREAD_MIN: f64 = 0.08;
/// Cosine of the angle to which two voxels look the same way, 30°.
const ALIKE: f64 = 0.866;
/// Planar voxels in the 3 × 3 × 3 around a seed, itself included: those of a face of 0.1 m.
const BLOCK_MIN: usize = 4;
/// Planar voxels in a row that a thin face is grown from.
const STRIP_CELLS: usize = 5;
/// Fewest points of a region, and the smallest: so much area do the sides of its voxels make, m².
pub(super) const POINTS_MIN: usize = 60;
const AREA_MIN_M2: f64 = 0.012;
/// Angle over which the slowly varying error keeps its sign: 40 px of a lens of 525 px.
pub(super) const WAVE_RAD: f64 = 0.076;
/// Regions seen under a smaller solid angle must stand out from those around them, sr: as many pixels of
/// such a lens as in images.
const SLIVER_SR: f64 = 0.0036;
/// Smallest region, as the solid angle under which it is seen, sr: what is smaller tells too little of its plane,
/// in images as here.
const REGION_SR: f64 = 0.0009;
/// Points whose errors go together: one in this many counts.
pub(super) const POINTS_ALIKE: f64 = 30.0;
/// Side of the view's places, rad.
const VIEW_RAD: f64 = 0.02;

impl segmentation::Moments for Moments {
    type Plane = Plane;

    fn add(&mut self, other: &Self, weight: f64) {
        Moments::add(self, other, weight);
    }

    fn count(&self) -> f64 {
        self.n
    }

    fn plane(&self) -> Option<Plane> {
        self.fit().map(|fit| fit.plane)
    }

    fn mean_square(&self, plane: &Plane) -> f64 {
        Moments::mean_square(self, plane)
    }
}

/// The voxels of one size, with what their distances from a plane may be. Residuals are distances, m.
pub(super) struct VoxelLattice<'a> {
    pub level: &'a Level,
    pub tolerance: &'a Tolerance<'a>,
}

/// The plane of a voxel, where its points are enough, span it and lie on it.
pub(super) struct Cell(Option<Fit>);

impl Cell {
    fn is_alike(&self, normal: &Vector3<f64>) -> bool {
        let fit = self.0.as_ref();
        fit.is_some_and(|fit| fit.plane.normal.dot(normal).abs() > ALIKE)
    }
}

impl VoxelLattice<'_> {
    /// The voxels around one, and the places at which they are.
    fn around(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> {
        let around = self.level.around[cell].iter().enumerate();
        around
            .filter(|(_, k)| **k != super::grid::NONE)
            .map(|(place, k)| (place, *k as usize))
    }

    /// A voxel and those around it that are open, planar and look the same way.
    fn block<'a>(
        &self,
        of: &impl Fn(usize) -> &'a Cell,
        first: usize,
        shut: &[bool],
        cells: &mut Vec<usize>,
    ) {
        cells.clear();
        if shut[first] {
            return;
        }
        let Some(own) = &of(first).0 else { return };
        cells.push(first);
        let around = self.around(first).map(|(_, k)| k);
        cells.extend(around.filter(|&k| !shut[k] && of(k).is_alike(&own.plane.normal)));
    }

    /// The same of voxels in a row, from a first one on in one direction; none of fewer than a strip has.
    fn strip<'a>(
        &self,
        of: &impl Fn(usize) -> &'a Cell,
        first: usize,
        direction: usize,
        shut: &[bool],
        cells: &mut Vec<usize>,
    ) {
        cells.clear();
        let Some(own) = Some(first)
            .filter(|i| !shut[*i])
            .and_then(|i| of(i).0.as_ref())
        else {
            return;
        };
        let mut at = first;
        loop {
            cells.push(at);
            if cells.len() == STRIP_CELLS {
                return;
            }
            let next = self.level.around[at][direction];
            at = next as usize;
            if next == super::grid::NONE || shut[at] || !of(at).is_alike(&own.plane.normal) {
                cells.clear();
                return;
            }
        }
    }

    /// Solid angle under which a region is seen, sr: that of a rectangle with its variances.
    fn solid_angle(region: &Moments) -> f64 {
        let mean = region.mean();
        let (r, area) = (mean.norm().max(1e-6), region.area());
        let slant = region
            .fit()
            .map_or(1.0, |fit| fit.plane.normal.dot(&mean).abs() / r);
        area * slant / (r * r)
    }

    /// Directions of a row of voxels: one of every two that are opposite.
    const DIRECTIONS: usize = 13;
}

impl Lattice for VoxelLattice<'_> {
    type Moments = Moments;
    type Cell = Cell;
    type Test = Plane;
    const RESUMES: bool = true;

    fn cells(&self) -> &[Moments] {
        &self.level.cells
    }

    fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        self.around(cell).map(|(_, k)| k)
    }

    fn inherit_owners(&self, _: &Self, owner: &[u16]) -> Vec<u16> {
        self.level
            .parents
            .iter()
            .map(|&parent| owner[parent as usize])
            .collect()
    }

    fn variance(&self, at: &Moments, plane: &Plane, k: f64, m: f64) -> f64 {
        self.tolerance.at(&at.mean(), plane, k, m).powi(2)
    }

    fn planar(&self, at: &Moments, plane: &Plane) -> f64 {
        self.variance(at, plane, PLANAR_SIGMAS, 0.5)
    }

    fn cell(&self, cell: usize) -> Option<Cell> {
        let moments = &self.level.cells[cell];
        let spread = (SPREAD_MIN * self.level.side_m).powi(2);
        let fit = (moments.n >= CELL_POINTS_MIN)
            .then(|| moments.fit())
            .flatten();
        // Voxels of too few points for a plane of their own take part: each of these must be near.
        Some(Cell(fit.filter(|fit| {
            fit.middle >= spread.max(4.0 * fit.least)
                && fit.least <= self.planar(moments, &fit.plane)
        })))
    }

    fn is_hole(&self, _: usize) -> bool {
        // There are no voxels without points, and none are known to be beside one.
        false
    }

    fn test(&self, plane: &Plane) -> Plane {
        *plane
    }

    fn fits(&self, number: usize, cell: &Cell, plane: &Plane) -> bool {
        let moments = &self.level.cells[number];
        let own = match &cell.0 {
            // The same way: a corner's voxels are near both planes.
            Some(fit) if !cell.is_alike(&plane.normal) && fit.least < 0.1 * fit.middle => {
                return false;
            }
            Some(fit) => fit.least,
            None => 0.0,
        };
        let misfit = moments.mean_square(plane) - own;
        misfit <= self.variance(moments, plane, MISFIT.0, MISFIT.1)
    }

    fn seeds<'a>(&self, shape: Shape, of: impl Fn(usize) -> &'a Cell, shut: &[bool]) -> Vec<Seed> {
        let mut seeds = Vec::new();
        let mut cells = Vec::new();
        let directions = if shape == Shape::Block {
            1
        } else {
            Self::DIRECTIONS
        };
        for first in (0..shut.len()).filter(|i| !shut[*i]) {
            for direction in 0..directions {
                let place = first * directions + direction;
                if !self.open_cells(shape, place as Seed, &of, shut, &mut cells) {
                    continue;
                }
                let mut moments = Moments::default();
                cells
                    .iter()
                    .for_each(|&k| moments.add(&self.level.cells[k], 1.0));
                let Some(fit) = moments.fit() else { continue };
                let limit = self.variance(&moments, &fit.plane, PLANAR_SIGMAS, 0.5 * MISFIT.1);
                let score = (fit.least / limit).sqrt();
                if score <= 1.0 && of(first).is_alike(&fit.plane.normal) {
                    seeds.push(seed_of(score as f32, place));
                }
            }
        }
        seeds
    }

    fn open_cells<'a>(
        &self,
        shape: Shape,
        seed: Seed,
        of: impl Fn(usize) -> &'a Cell,
        shut: &[bool],
        cells: &mut Vec<usize>,
    ) -> bool {
        let place = seed as u32 as usize;
        match shape {
            Shape::Block => {
                self.block(&of, place, shut, cells);
                cells.len() >= BLOCK_MIN
            }
            Shape::Strip => {
                let (first, direction) = (place / Self::DIRECTIONS, place % Self::DIRECTIONS);
                self.strip(&of, first, direction, shut, cells);
                !cells.is_empty()
            }
        }
    }

    fn is_region(&self, _: Shape, moments: &Moments, cells: usize) -> bool {
        let area_m2 = cells as f64 * self.level.side_m.powi(2);
        moments.n >= POINTS_MIN as f64
            && area_m2 >= AREA_MIN_M2
            && Self::solid_angle(moments) >= REGION_SR
    }

    fn borders(&self, partition: &Partition<Moments>) -> Vec<((u16, u16), Border)> {
        // By the first region: each has few neighbours.
        let mut borders: Vec<Vec<(u16, Border)>> = vec![Vec::new(); partition.regions.len()];
        let owner = &partition.owner;
        for (i, &a) in owner.iter().enumerate().filter(|(_, a)| **a != NONE) {
            for k in self.beside(i) {
                let b = owner[k];
                if b != NONE && a < b {
                    let pair = [i as u32, k as u32];
                    let own = &mut borders[usize::from(a)];
                    match own.iter_mut().find(|(other, _)| *other == b) {
                        Some((_, border)) => border.push(pair),
                        None => own.push((b, vec![pair])),
                    }
                }
            }
        }
        let sorted = borders.into_iter().zip(0_u16..).flat_map(|(mut own, a)| {
            own.sort_unstable_by_key(|(b, _)| *b);
            own.into_iter().map(move |(b, border)| ((a, b), border))
        });
        sorted.collect()
    }

    fn frontier(&self, owner: &[u16]) -> Vec<u32> {
        let differs = |i: usize, k: usize| owner[k] != NONE && owner[k] != owner[i];
        let cells = (0..owner.len()).filter(|&i| owner[i] != NONE);
        let beside = cells.filter(|&i| self.beside(i).any(|k| differs(i, k)));
        beside.map(|i| i as u32).collect()
    }

    fn step(&self, border: &Border, plane: &Plane, m: f64) -> Option<(f64, f64)> {
        let cells = &self.level.cells;
        let height = |i: u32| plane.height(&cells[i as usize].mean());
        let count = border.len() as f64;
        let step: f64 = border.iter().map(|&[i, k]| height(i) - height(k)).sum();
        let points: f64 = border.iter().map(|&[i, _]| cells[i as usize].n).sum();
        let at = &cells[border.first()?[0] as usize];
        let sigmas = 2.0 * (POINTS_ALIKE / points.max(1.0)).min(1.0).sqrt();
        Some((step / count, self.variance(at, plane, sigmas, m)))
    }

    fn within_a_wave(&self, region: &Moments) -> bool {
        Self::solid_angle(region) < 4.0 * std::f64::consts::PI * WAVE_RAD * WAVE_RAD
    }

    fn waves(&self, _: &Moments) -> f64 {
        // A cloud may be of any sensor.
        f64::INFINITY
    }

    fn is_sliver(&self, region: &Moments) -> bool {
        Self::solid_angle(region) < SLIVER_SR
    }

    fn tells_plane(&self, region: &Moments) -> bool {
        Self::solid_angle(region) >= REGION_SR
    }

    /// By azimuth and elevation about the eye; the nearest voxel counts.
    fn view(&self) -> View {
        let means: Vec<Vector3<f64>> = self.level.cells.iter().map(Moments::mean).collect();
        let axis = axis(means.iter());
        let seen: Vec<_> = means
            .iter()
            .map(|p| angles_of(axis, p) / VIEW_RAD)
            .collect();
        let Some(low) = seen.iter().copied().reduce(|a, b| a.inf(&b)) else {
            return View {
                cols: 0,
                rows: 0,
                cell: Some(Vec::new()),
            };
        };
        let place = |at: &nalgebra::Vector2<f64>| (at - low).map(|x| x as usize);
        let size = seen.iter().map(place).fold([1, 1], |size, at| {
            [size[0].max(at.x + 1), size[1].max(at.y + 1)]
        });
        let mut cell = vec![View::NOTHING; size[0] * size[1]];
        for (number, at) in (0_u32..).zip(seen.iter().map(place)) {
            let shown = &mut cell[at.y * size[0] + at.x];
            let nearer = |other: u32| {
                means[number as usize].norm_squared() < means[other as usize].norm_squared()
            };
            if *shown == View::NOTHING || nearer(*shown) {
                *shown = number;
            }
        }
        View {
            cols: size[0],
            rows: size[1],
            cell: Some(cell),
        }
    }

    fn side(&self, cell: usize, plane: &Plane) -> Option<Ordering> {
        let p = self.level.cells[cell].mean();
        // The part of the way to the plane along the ray at which the points are.
        let part = plane.normal.dot(&p) / plane.offset;
        let off = plane.height(&p).abs();
        let (k, m) = ON_PLANE;
        Some(match off > self.tolerance.at(&p, plane, k, m) {
            true if part > 0.0 && part < 1.0 => Ordering::Less,
            true if part > 1.0 => Ordering::Greater,
            _ => Ordering::Equal,
        })
    }
}
