//! Surfaces that a sensor sees at a flat angle: few points on much of them, and no ray behind.
//!
//! What a cell holds of a surface that faces the sensor is what the sensor can see at most. Of a wall along which it looks
//! it sees the part `s` of that, the sine of the angle between ray and wall, and of that few pixels are measured. So few
//! points are also what noise leaves over a floor, or between an edge and what is behind it. Rays tell the
//! two apart: those that meet a surface end on it, and those that meet noise go on.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::{Cell, FILLED, Loose, NEAR_MIN_M, POINTS_MIN};
use crate::free_space::{FreeSpace, GRAZING, HELD, SIGMAS};

/// Cells along a side of the blocks in which points are summed up; a plane is that of the eight next to a cell.
const BLOCK: i64 = 4;
/// Points are on a plane to this, and wider than it along both of its directions, m (standard deviation).
const FLAT_M: f64 = 0.01;
/// The pixels that are measured between an edge and what is behind it are a band of at most four, one in two of which is
/// sampled: what is no wider as it is seen is no surface (standard deviation, in distances between rays).
const EDGE: f64 = 0.6;
/// Rays in a bin of direction.
const RAYS: f64 = 9.0;
/// Most bins along a side of the map of directions.
const BINS_MAX: f64 = 1024.0;

/// The plane n·p = b about a cell's points, and what the views' rays say of it.
struct Patch {
    cell: Cell,
    n_W: Vector3<f64>,
    b_m: f64,
    /// Points of no face on the plane.
    on: usize,
    /// Rays that went through it.
    through: usize,
}

/// Weighs the points of thinly filled cells as parts of what a full cell of their own plane would have, where as many
/// of their view's rays at least end on that plane as go through it.
pub(super) fn weigh(cells: &mut BTreeMap<Cell, Vec<Loose>>, views: &[&FreeSpace]) {
    let share = |points: &[Loose]| points.iter().map(Loose::share).sum::<f64>();
    let thin: Vec<Cell> = cells
        .iter()
        .filter(|(_, points)| share(points) < FILLED)
        .map(|(cell, _)| *cell)
        .collect();
    for (number, view) in views.iter().enumerate() {
        let mut patches = patches(cells, &thin, view, number);
        if patches.is_empty() {
            continue;
        }
        count(&mut patches, cells, view, number);
        for patch in patches {
            let points = cells
                .get_mut(&patch.cell)
                .filter(|_| patch.on >= patch.through.max(1));
            for point in points.into_iter().flatten().filter(|p| p.view == number) {
                point.full *= point.across(&patch.n_W);
            }
        }
    }
}

/// The planes of what a view shows of thinly filled cells, where it fills a part of the plane.
fn patches(
    cells: &BTreeMap<Cell, Vec<Loose>>,
    thin: &[Cell],
    view: &FreeSpace,
    number: usize,
) -> Vec<Patch> {
    let mut blocks: BTreeMap<Cell, Sums> = BTreeMap::new();
    for (cell, points) in cells {
        let mut points = points.iter().filter(|p| p.view == number).peekable();
        if points.peek().is_some() {
            let block = blocks.entry(cell.map(|c| c.div_euclid(BLOCK))).or_default();
            points.for_each(|p| block.add(&p.ends_W[0].coords));
        }
    }
    let patch = |cell: &Cell| {
        let mut sums = Sums::default();
        for k in 0..8 {
            // The block of the cell, and those on the sides to which it is in that.
            let beside = |axis: usize| {
                let side = (2 * cell[axis].rem_euclid(BLOCK) + 1 - BLOCK).signum();
                cell[axis].div_euclid(BLOCK) + side * (k >> axis & 1)
            };
            if let Some(block) = blocks.get(&[beside(0), beside(1), beside(2)]) {
                sums.merge(block);
            }
        }
        let (n_W, b_m) = sums.plane(view)?;
        let own = cells[cell].iter().filter(|point| point.view == number);
        let on = own.filter(|p| (n_W.dot(&p.ends_W[0].coords) - b_m).abs() <= NEAR_MIN_M);
        let share: f64 = on.map(|p| 1.0 / (p.full * p.across(&n_W)).max(1.0)).sum();
        (share >= FILLED).then_some(Patch {
            cell: *cell,
            n_W,
            b_m,
            on: 0,
            through: 0,
        })
    };
    thin.iter().filter_map(patch).collect()
}

/// Counts a view's rays that end on the patches, or go through them, in the directions of the patches' points.
fn count(
    patches: &mut [Patch],
    cells: &BTreeMap<Cell, Vec<Loose>>,
    view: &FreeSpace,
    number: usize,
) {
    let sphere = 4.0 * std::f64::consts::PI;
    let side = (sphere * view.density / RAYS)
        .sqrt()
        .clamp(1.0, BINS_MAX)
        .floor();
    let bin = |p_W: &Point3<f64>| bin(&(p_W - view.eye_W), side);
    let mut asked: Vec<(u32, u32)> = Vec::new();
    for (k, patch) in (0..).zip(patches.iter()) {
        let own = cells[&patch.cell].iter().filter(|p| p.view == number);
        asked.extend(own.map(|p| (bin(&p.ends_W[0]), k)));
    }
    asked.sort_unstable();
    asked.dedup();
    let mut is_asked = vec![false; (side * side) as usize];
    asked
        .iter()
        .for_each(|(bin, _)| is_asked[*bin as usize] = true);
    // Heights over the planes of the bin of a point, from the eye's side.
    let mut at = |p_W: &Point3<f64>, says: &dyn Fn(&mut Patch, f64)| {
        let bin = bin(p_W);
        if !is_asked[bin as usize] {
            return;
        }
        let first = asked.partition_point(|(other, _)| *other < bin);
        let of_bin = asked[first..].iter().take_while(|(other, _)| *other == bin);
        for (_, k) in of_bin {
            let patch = &mut patches[*k as usize];
            let [eye_m, m] = [&view.eye_W, p_W].map(|p| patch.n_W.dot(&p.coords) - patch.b_m);
            says(patch, m * eye_m.signum());
        }
    };
    let beside = view.beside.iter().map(|seen| (&seen.p_W, 1));
    for (p_W, rays) in beside.chain(view.held.iter().map(|p_W| (p_W, HELD))) {
        at(p_W, &|patch, height_m| {
            patch.through += rays * usize::from(height_m < 0.0);
        });
    }
    // Rays that end on the plane, but for noise, did not go through it.
    for point in cells.values().flatten().filter(|p| p.view == number) {
        at(&point.ends_W[0], &|patch, height_m| {
            let margin_m = NEAR_MIN_M.max(SIGMAS * point.sigma_m * point.across(&patch.n_W));
            if height_m.abs() <= margin_m {
                patch.on += 1;
                patch.through -= usize::from(height_m < 0.0).min(patch.through);
            }
        });
    }
}

/// The bin of a direction in the octahedral map of all, of so many bins along a side.
fn bin(way: &Vector3<f64>, side: f64) -> u32 {
    let d = way / way.lp_norm(1).max(f64::MIN_POSITIVE);
    let folded = |a: f64, b: f64| {
        if d.z < 0.0 {
            (1.0 - b.abs()).copysign(a)
        } else {
            a
        }
    };
    let at = |x: f64| (0.5 * (x + 1.0) * side).floor().clamp(0.0, side - 1.0);
    (at(folded(d.y, d.x)) * side + at(folded(d.x, d.y))) as u32
}

/// Sums over points, m and m².
#[derive(Clone, Default)]
struct Sums {
    count: f64,
    sum: Vector3<f64>,
    squares: Matrix3<f64>,
}

impl Sums {
    fn add(&mut self, p: &Vector3<f64>) {
        self.count += 1.0;
        self.sum += p;
        self.squares += p * p.transpose();
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.squares += other.squares;
    }

    /// The plane of the points, where they are flat and no line, and seen as wider than the pixels along an edge are.
    fn plane(&self, view: &FreeSpace) -> Option<(Vector3<f64>, f64)> {
        if self.count < POINTS_MIN as f64 {
            return None;
        }
        let mean = self.sum / self.count;
        let spread = self.squares / self.count - mean * mean.transpose();
        let SymmetricEigen {
            eigenvalues,
            eigenvectors,
        } = spread.symmetric_eigen();
        let flat = eigenvalues.imin();
        let most = FLAT_M * FLAT_M;
        let wide = (0..3).all(|k| k == flat || eigenvalues[k] > most);
        let n_W = eigenvectors.column(flat).into_owned();
        // Across the ray, and in the plane as it is seen.
        let way = mean - view.eye_W.coords;
        let side = n_W - way * (n_W.dot(&way) / way.norm_squared());
        let across = n_W.dot(&way).abs() / way.norm();
        let seen = side.dot(&(spread * side)) / side.norm_squared() / way.norm_squared();
        let is_seen = seen * view.density > EDGE * EDGE;
        // Of a rectangle with that spread.
        let others = (0..3).filter(|k| *k != flat).map(|k| eigenvalues[k]);
        let area_m2 = 12.0 * others.product::<f64>().sqrt();
        let full = view.density * area_m2 * across / way.norm_squared();
        let is_seen = is_seen && self.count >= FILLED * full;
        (wide && is_seen && across > GRAZING && eigenvalues[flat] <= most)
            .then(|| (n_W, n_W.dot(&mean)))
    }
}
