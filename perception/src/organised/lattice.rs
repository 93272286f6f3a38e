//! The cells of an image as a lattice to segment.

use std::cmp::Ordering;

use super::bits::{Bits, on_left};
use super::borders::{Sums, borders};
use super::cell::{Cell, CellNoise, test, unevenness};
use super::image::{Grid, Lens};
use super::moments::{InversePlane, Moments};
use super::seed::{self, BLOCK, STRIPS, places, rows_of};
use super::words::pack;
use crate::segmentation::{self, Border, Lattice, ON_PLANE, Partition, Seed, Shape, View};
use crate::segmentation::{MISFIT, NONE};
use crate::sensor::Noise;

/// Least part of the pixels that a cell has as a rule in one that takes part: of fewer some are lost at an edge.
const MEASURED_MIN: f64 = 0.6;
/// Smallest region, px, and smallest that is grown from a strip: short strips lie on any edge.
const PIXELS_MIN: f64 = 160.0;
const STRIP_PIXELS_MIN: f64 = 400.0;
/// Regions of fewer pixels must stand out from the planes beside them.
const SLIVER_PIXELS_MAX: f64 = 1000.0;
/// Regions of fewer pixels tell too little of their plane to be found again behind what hides it.
const HIDDEN_PIXELS_MIN: f64 = 250.0;

impl segmentation::Moments for Moments {
    type Plane = InversePlane;

    #[inline]
    fn add(&mut self, other: &Self, weight: f64) {
        Moments::add(self, other, weight);
    }

    fn count(&self) -> f64 {
        self.n
    }

    fn plane(&self) -> Option<InversePlane> {
        Moments::plane(self)
    }

    #[inline]
    fn mean_square(&self, plane: &InversePlane) -> f64 {
        Moments::mean_square(self, plane)
    }
}

/// The cells of one size, with the sensor's noise. Residuals are of inverse depth, 1/m.
pub(super) struct ImageLattice<'a> {
    pub grid: &'a Grid,
    pub lens: &'a Lens,
    pub noise: &'a Noise,
}

impl ImageLattice<'_> {
    /// The noise at an inverse depth on a plane.
    fn noise_at(&self, w: f64, plane: &InversePlane) -> CellNoise {
        CellNoise::at(self.noise, w, unevenness(self.lens, plane, self.noise))
    }

    /// Fewest pixels of a cell that takes part.
    fn pixels_min(&self) -> f64 {
        MEASURED_MIN * self.grid.usual
    }

    /// Pixels over which an error of a correlation length repeats itself: 4π s².
    fn wave(scale_px: f64) -> f64 {
        4.0 * std::f64::consts::PI * scale_px.powi(2)
    }
}

impl Lattice for ImageLattice<'_> {
    type Moments = Moments;
    type Cell = Cell;
    type Test = ([f32; 3], f32);
    const RESUMES: bool = false;

    #[inline]
    fn cells(&self) -> &[Moments] {
        &self.grid.cells
    }

    #[inline]
    fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        self.grid.beside(cell).into_iter()
    }

    fn inherit_owners(&self, coarse: &Self, owner: &[u16]) -> Vec<u16> {
        let (cols, rows) = (coarse.grid.cols, coarse.grid.rows);
        let mut fine = vec![NONE; self.grid.cells.len()];
        for (y, row) in fine.chunks_exact_mut(self.grid.cols.max(1)).enumerate() {
            // A margin narrower than a large cell belongs to none.
            let above = if y / 2 < rows {
                &owner[y / 2 * cols..][..cols]
            } else {
                &[]
            };
            for (two, owner) in row.as_chunks_mut::<2>().0.iter_mut().zip(above) {
                *two = [*owner; 2];
            }
        }
        fine
    }

    fn variance(&self, at: &Moments, plane: &InversePlane, k: f64, m: f64) -> f64 {
        // What is built uneven is so within a cell as over a face: waves of the sensor's error are not.
        let (w, m_uneven) = (at.mean(), m.min(MISFIT.1));
        let uneven = unevenness(self.lens, plane, self.noise) * w * w;
        CellNoise::at(self.noise, w, 0.0).square(k, m) + m_uneven * m_uneven * uneven
    }

    fn planar(&self, at: &Moments, plane: &InversePlane) -> f64 {
        self.noise_at(at.mean(), plane).planar()
    }

    fn cell(&self, cell: usize) -> Option<Cell> {
        let moments = &self.grid.cells[cell];
        (!self.is_hole(cell))
            .then(|| Cell::new(moments, self.lens, self.noise))
            .flatten()
    }

    fn is_hole(&self, cell: usize) -> bool {
        self.grid.cells[cell].n < self.pixels_min()
    }

    fn test(&self, plane: &InversePlane) -> Self::Test {
        test(self.lens, plane, self.noise)
    }

    #[inline]
    fn fits(&self, _: usize, cell: &Cell, plane: &Self::Test) -> bool {
        cell.fits(plane)
    }

    fn seeds<'a>(&self, shape: Shape, of: impl Fn(usize) -> &'a Cell, shut: &[bool]) -> Vec<Seed> {
        let limit = |i: usize| of(i).seed_max;
        match shape {
            Shape::Block => places(&[BLOCK], self.grid, limit, shut),
            Shape::Strip => places(&STRIPS, self.grid, limit, shut),
        }
    }

    fn open_cells<'a>(
        &self,
        shape: Shape,
        seed: Seed,
        _: impl Fn(usize) -> &'a Cell,
        shut: &[bool],
        cells: &mut Vec<usize>,
    ) -> bool {
        cells.clear();
        let shapes: &[seed::Shape] = match shape {
            Shape::Block => &[BLOCK],
            Shape::Strip => &STRIPS,
        };
        for row in rows_of(seed, shapes, self.grid) {
            // Most seeds that are asked for lie in a region by then.
            if shut[row.clone()].contains(&true) {
                return false;
            }
            cells.extend(row);
        }
        true
    }

    fn is_region(&self, shape: Shape, moments: &Moments, _: usize) -> bool {
        let least = match shape {
            Shape::Block => PIXELS_MIN,
            Shape::Strip => STRIP_PIXELS_MIN,
        };
        moments.n >= least
    }

    fn borders(&self, partition: &Partition<Moments>) -> Vec<((u16, u16), Border)> {
        borders(self.grid, &partition.owner, partition.regions.len())
    }

    fn frontier(&self, owner: &[u16]) -> Vec<u32> {
        let (cols, rows) = (self.grid.cols, self.grid.rows);
        let differ = |a: u16, b: u16| (a != b) & (a != NONE) & (b != NONE);
        let line = |y: usize| &owner[y * cols..][..cols];
        let right = Bits::new(cols, rows, |y, words| {
            pack(line(y), &line(y)[1.min(cols)..], words, differ);
        });
        let below = Bits::new(cols, rows, |y, words| {
            if y + 1 < rows {
                pack(line(y), line(y + 1), words, differ);
            }
        });
        let beside = Bits::around([&right, &below], |[right, below]| {
            right[1][1] | on_left(right[1]) | below[0][1] | below[1][1]
        });
        let mut cells = Vec::new();
        beside.for_each(|x, y| cells.push((y * cols + x) as u32));
        cells
    }

    fn step(&self, border: &Border, plane: &InversePlane, m: f64) -> Option<(f64, f64)> {
        let border = Sums::new(self.grid, border)?;
        let count = border.pairs;
        let step = (border.w - plane.0.x * border.u - plane.0.y * border.v) / count;
        let alike = Self::wave(self.noise.correlation_px);
        let pixels = (self.grid.size * self.grid.size) as f64;
        let sigmas = 2.0 * (alike / (count * pixels)).min(1.0).sqrt();
        let noise = self.noise_at(border.level / count, plane);
        Some((step, noise.square(sigmas, m)))
    }

    fn within_a_wave(&self, region: &Moments) -> bool {
        region.n < Self::wave(self.noise.systematic_scale_px)
    }

    fn waves(&self, region: &Moments) -> f64 {
        let (u, v) = (region.u / region.n, region.v / region.n);
        let square = (region.uu + region.vv) / region.n - u * u - v * v;
        square / self.noise.systematic_scale_px.powi(2)
    }

    fn is_sliver(&self, region: &Moments) -> bool {
        region.n < SLIVER_PIXELS_MAX
    }

    fn tells_plane(&self, region: &Moments) -> bool {
        region.n >= HIDDEN_PIXELS_MIN
    }

    fn view(&self) -> View {
        View {
            cols: self.grid.cols,
            rows: self.grid.rows,
            cell: None,
        }
    }

    fn side(&self, cell: usize, plane: &InversePlane) -> Option<Ordering> {
        let m = &self.grid.cells[cell];
        if m.n < 1.0 {
            return None;
        }
        let inverse = 1.0 / m.n;
        let w = plane.at(m.u * inverse, m.v * inverse);
        let nearer = m.w * inverse - w;
        let limit = self.noise_at(w, plane).square(ON_PLANE.0, ON_PLANE.1);
        Some(match nearer * nearer > limit {
            true => 0.0_f64.total_cmp(&nearer),
            false => Ordering::Equal,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::organised::image::tests::grids_of;
    use crate::segmentation::{Region, drop_slivers, segment};
    use crate::sensor::Sensor;

    /// Regions of an image of 160 × 120 depths, m, and its small cells.
    fn regions(z: impl Fn(usize, usize) -> f64) -> (Partition<Moments>, Grid) {
        let noise = &Sensor::named("xtion").unwrap().noise;
        let (lens, small, large) = grids_of(z);
        let lens = &lens;
        let lattice = |grid| ImageLattice { grid, lens, noise };
        let found = segment(&[&lattice(&large), &lattice(&small)]);
        (found, small)
    }

    #[test]
    fn a_leg_before_a_wall_is_a_face_and_the_wall_goes_on_behind_it() {
        // 7 px wide, 0.5 m before the wall.
        let leg = |u: usize, _: usize| if (80..87).contains(&u) { 1.5 } else { 2.0 };
        let (found, grid) = regions(leg);
        assert_eq!(found.regions.len(), 2);
        let at = |x: usize| found.owner[15 * grid.cols + x];
        assert_eq!(at(5), at(35));
        assert_ne!(at(20), at(5));
    }

    #[test]
    fn the_front_of_a_board_is_a_part_of_its_edge() {
        // A board seen at 45°, its front 10 px (3 cm) high, and a wall behind.
        let depth = |v: usize| 882.0 / (v as f64 + 440.0);
        let front = |with_board: bool| {
            move |_: usize, v: usize| match v {
                40..80 if with_board => depth(v),
                80..90 => depth(79),
                _ => 3.0,
            }
        };
        // The board has not grown over it, and by itself it is a face.
        let (found, grid) = regions(front(true));
        assert_eq!(found.owner[21 * grid.cols + 20], NONE);
        let (found, grid) = regions(front(false));
        assert_ne!(found.owner[21 * grid.cols + 20], NONE);
    }

    #[test]
    fn regions_end_where_their_planes_meet() {
        // Inverse depth is level to the 88th column, and rises from there.
        let (found, grid) = regions(|u, _| 1.0 / (0.5 + 0.001 * (u as f64 - 88.0).max(0.0)));
        assert_eq!(found.regions.len(), 2);
        let row: Vec<u16> = found.owner[10 * grid.cols..][..grid.cols].to_vec();
        let border = row.iter().position(|owner| *owner != row[0]).unwrap();
        assert!(
            row[border..].iter().all(|owner| *owner == row[39]),
            "{row:?}"
        );
        assert!((21..=23).contains(&border), "{row:?}");
        let first = &found.regions[usize::from(row[0])];
        assert!(first.plane.0.x.abs() < 1e-5, "{first:?}");
    }

    #[test]
    fn the_sides_of_a_small_roof_are_two_regions() {
        // The wave of an error of 2 κ bends a wall; a roof that is much smaller than the wave it does not.
        let kappa = Sensor::named("xtion").unwrap().noise.systematic_ratio * 0.5;
        let (found, _) = regions(|u, _| {
            1.0 / (0.5 + 2.0 * kappa * (u as f64 * std::f64::consts::TAU / 160.0).sin())
        });
        assert_eq!(found.regions.len(), 1);
        let (found, _) = regions(|u, v| {
            let is_roof = (52..108).contains(&u) && (40..80).contains(&v);
            let ridge = 0.5 - 6e-4 * (u as f64 - 79.5).abs();
            1.0 / if is_roof { ridge } else { 0.3 }
        });
        assert_eq!(found.regions.len(), 3);
    }

    #[test]
    fn small_plates_apart_are_not_one_plane_though_one_explains_them() {
        // Two plates of one plane, and a bar before the wall between them.
        let plates = |half: usize| {
            move |u: usize, v: usize| match u {
                72..88 => 1.2,
                _ if u.abs_diff(80) < 8 + half && v.abs_diff(60) < half => 1.6,
                _ => 3.0,
            }
        };
        assert_eq!(regions(plates(20)).0.regions.len(), 4);
        // What is hidden of a larger one is told by what is seen of it.
        assert_eq!(regions(plates(60)).0.regions.len(), 3);
    }

    #[test]
    fn plates_of_one_plane_are_one_region_unless_what_is_beyond_is_seen_between_them() {
        // Between them some was not measured, and the rest is before them, on their plane or behind.
        let plates = |between: f64| {
            move |u: usize, v: usize| match (u, v) {
                (60..100, 50..70) => 0.0,
                (60..100, _) => between,
                _ => 1.6,
            }
        };
        let plate = |(x, y): (usize, usize), between: f64| {
            let (found, grid) = regions(plates(between));
            found.owner[y * grid.cols + x]
        };
        for (between, one) in [(1.2, true), (1.6, true), (3.0, false)] {
            let [left, right] = [3, 36].map(|x| plate((x, 15), between));
            assert_eq!(left == right, one, "{between}");
        }
    }

    #[test]
    fn two_pieces_of_a_small_face_do_not_drop_each_other() {
        let noise = &Sensor::named("xtion").unwrap().noise;
        let (lens, grid, _) = &grids_of(|_, _| 2.0);
        let mut partition = Partition {
            owner: vec![NONE; grid.cells.len()],
            ..Partition::default()
        };
        for (number, columns) in [(0, 10..18), (1, 18..25)] {
            let mut moments = Moments::default();
            for (y, x) in (10..16).flat_map(|y| columns.clone().map(move |x| (y, x))) {
                moments.add(&grid.cells[y * grid.cols + x], 1.0);
                partition.owner[y * grid.cols + x] = number;
            }
            let plane = moments.plane().unwrap();
            partition.regions.push(Region { moments, plane });
        }
        drop_slivers(&ImageLattice { grid, lens, noise }, &mut partition);
        let left: Vec<f64> = partition.regions.iter().map(|r| r.moments.n).collect();
        assert_eq!(left, [768.0]);
    }

    #[test]
    fn a_small_plate_stands_out_where_cells_do() {
        // A plate before a wall, nearer by so much of inverse depth.
        let plate = |by: f64| {
            move |u: usize, v: usize| {
                let is_plate = (60..88).contains(&u) && (40..68).contains(&v);
                1.0 / (0.5 + if is_plate { by } else { 0.0 })
            }
        };
        let noise = CellNoise::at(&Sensor::named("xtion").unwrap().noise, 0.5, 0.0);
        let refused = noise.misfit().sqrt();
        let stands_out = (noise.planar() + noise.misfit()).sqrt();
        for (by, count) in [
            (0.9 * refused, 1),
            (0.5 * (refused + stands_out), 1),
            (1.1 * stands_out, 2),
        ] {
            // Small cells alone: none is of both.
            let noise = &Sensor::named("xtion").unwrap().noise;
            let (lens, grid, _) = &grids_of(plate(by));
            let found = segment(&[&ImageLattice { grid, lens, noise }]);
            assert_eq!(found.regions.len(), count, "{by}");
        }
    }
}
