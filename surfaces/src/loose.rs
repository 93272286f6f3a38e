//! What was seen and lies on no face, gathered into convex bodies to keep away from.
//!
//! A point is of a face where it is as near to its plane as the point is known, over the face or little beside it.
//! Points of no face are counted in cells, each point as the part of a full cell that it is at its distance, so that
//! single points between a thing and what is behind it are none. Cells that touch are one thing, and a thing is cut
//! until each part about fills a box. Each part is the hull of its points and of a little behind them.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Point3, Vector3};

use crate::conservative_bodies::behind_W;
use crate::free_space::{FreeSpace, RayEnd, SIGMAS};
use crate::outline::Outline;
use crate::{Face, Obstacle};

/// Side of the cells in which points are counted, m.
const CELL_M: f64 = 0.05;
/// The part of a cell's full number of points from which on something is there.
const FILLED: f64 = 0.25;
/// Full cells that the smallest thing has points for.
const FULL_CELLS_MIN: f64 = 1.0;
/// And points of it.
const POINTS_MIN: usize = 6;
/// Half the width of a point: a body has some in all directions, m.
const POINT_M: f64 = 0.005;
/// Nearer to a plane points are of its face, m.
const NEAR_MIN_M: f64 = 0.02;
/// Side of the cells in which it is known where a face is, m.
const FACE_CELL_M: f64 = 0.05;
/// So many of them beside its outline a face may go on.
const BESIDE: usize = 2;
/// Most cells of a face: faces of a kilometre are no faces.
const CELLS_MAX: usize = 4_000_000;
/// A part that fills less of its box is cut where it is longer than a few cells.
const BOX_FILLED: f64 = 0.3;
/// Depth of a body behind what was seen of it, m.
const DEPTH_M: f64 = 0.03;
/// Width of the bins of direction in which points are counted, as a ratio of the distance.
const BIN: f64 = 0.02;
/// Of so many points one is counted there.
const BIN_STEP: usize = 5;

type Cell = [i64; 3];

/// Bodies of what the views show beside the faces, by their first cells.
pub fn loose(faces: &[Face], views: &[&FreeSpace]) -> Vec<Obstacle> {
    let plates: Vec<Plate> = faces.iter().filter_map(Plate::of).collect();
    // 1. Points of no face in their cells, each with its share of a full cell.
    let mut cells: BTreeMap<Cell, Vec<Loose>> = BTreeMap::new();
    for view in views {
        let bin = full_bin(view);
        let mut last: Option<&Plate> = None;
        for seen in &view.points {
            let way_W = seen.p_W - view.eye_W;
            // Mostly the face of the point before.
            let mut likely = last.into_iter().chain(&plates);
            last = likely.find(|plate| plate.explains(seen, &way_W));
            if last.is_some() {
                continue;
            }
            let full = bin * (CELL_M / (BIN * way_W.norm())).powi(2);
            let point = Loose {
                p_W: seen.p_W,
                behind_W: behind_W(&seen.p_W, &view.eye_W, DEPTH_M),
                share: 1.0 / full.max(1.0),
            };
            let at = seen.p_W.coords.map(|x| (x / CELL_M).floor() as i64);
            cells.entry(at.into()).or_default().push(point);
        }
    }
    let share = |points: &[Loose]| points.iter().map(|point| point.share).sum::<f64>();
    cells.retain(|_, points| share(points) >= FILLED);
    // 2. Cells that touch, cut into parts.
    let mut parts = Vec::new();
    let mut left: BTreeSet<Cell> = cells.keys().copied().collect();
    while let Some(first) = left.pop_first() {
        let thing = connected(first, &mut left);
        let full: f64 = thing.iter().map(|cell| share(&cells[cell])).sum();
        let points: usize = thing.iter().map(|cell| cells[cell].len()).sum();
        if full >= FULL_CELLS_MIN && points >= POINTS_MIN {
            cut(thing, &mut parts);
        }
    }
    // 3. Their bodies.
    let bodies = parts.iter().enumerate().map(|(number, part)| {
        let points = part.iter().flat_map(|cell| &cells[cell]);
        let points = points.flat_map(|p| [p.p_W, p.behind_W]);
        let points: Vec<Point3<f64>> = points.flat_map(around).collect();
        Obstacle {
            id: format!("{NAME}{number}"),
            points_W: outermost(&points),
            surface: None,
            assumed: false,
        }
    });
    bodies.collect()
}

/// What bodies of no face are called.
const NAME: &str = "loose";

/// Whether a body is of points that lie on no face, by its name: `loose` and a number.
pub fn is_loose(body: &Obstacle) -> bool {
    let number = body.id.strip_prefix(NAME);
    let is_number = |n: &str| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
    body.surface.is_none() && number.is_some_and(is_number)
}

struct Loose {
    p_W: Point3<f64>,
    behind_W: Point3<f64>,
    /// The part of a full cell that the point is.
    share: f64,
}

/// Points in a bin of directions that is full: the median of the bins with any.
fn full_bin(view: &FreeSpace) -> f64 {
    let mut bins: BTreeMap<Cell, usize> = BTreeMap::new();
    for seen in view.points.iter().step_by(BIN_STEP) {
        let way = seen.p_W - view.eye_W;
        let axis = way.iamax();
        let scale = 1.0 / (BIN * way[axis].abs().max(f64::MIN_POSITIVE));
        let [u, v] = [1, 2].map(|k| (way[(axis + k) % 3] * scale).floor() as i64);
        let side = axis as i64 * 2 + i64::from(way[axis] > 0.0);
        *bins.entry([side, u, v]).or_default() += 1;
    }
    let mut counts: Vec<usize> = bins.into_values().collect();
    let middle = counts.len() / 2;
    match counts.is_empty() {
        true => 0.0,
        false => (BIN_STEP * *counts.select_nth_unstable(middle).1) as f64,
    }
}

/// Where a face is, in cells of its plane, for many questions.
struct Plate {
    X_FW: Isometry3<f64>,
    /// The plane n·p = b in W.
    n_W: Vector3<f64>,
    b_m: f64,
    low: [f64; 2],
    cols: usize,
    /// Row by row, whether the face is there or may go on.
    on: Vec<bool>,
}

impl Plate {
    fn of(face: &Face) -> Option<Self> {
        let (low, high) = Outline::from(&face.region).bounds()?;
        let beside_m = BESIDE as f64 * FACE_CELL_M;
        let low = [low.x - beside_m, low.y - beside_m];
        let count = |axis: usize| {
            let long_m = high[axis] + beside_m - low[axis];
            (long_m / FACE_CELL_M).ceil().max(1.0) as usize
        };
        let (cols, rows) = (count(0), count(1));
        let mut on = vec![false; cols.checked_mul(rows).filter(|n| *n <= CELLS_MAX)?];
        let middle = |axis: usize, k: usize| low[axis] + (k as f64 + 0.5) * FACE_CELL_M;
        for (y, row) in on.chunks_exact_mut(cols).enumerate() {
            // Where the row's line goes in and out of the region.
            let at = middle(1, y);
            let crossed = face.region.segments().filter_map(|(_, [a, b])| {
                let across = (a.y > at) != (b.y > at);
                across.then(|| a.x + (at - a.y) / (b.y - a.y) * (b.x - a.x))
            });
            let mut crossed: Vec<f64> = crossed.collect();
            crossed.sort_by(f64::total_cmp);
            for (x, cell) in row.iter_mut().enumerate() {
                *cell = crossed.partition_point(|c| *c < middle(0, x)) % 2 == 1;
            }
        }
        let n_W = face.normal_W();
        Some(Self {
            X_FW: face.X_WF.inverse(),
            n_W,
            b_m: n_W.dot(&face.X_WF.translation.vector),
            low,
            cols,
            on: wider(&wider(&on, cols, 1), cols, cols),
        })
    }

    /// Whether a point is of the face.
    fn explains(&self, seen: &RayEnd, way_W: &Vector3<f64>) -> bool {
        let off_m = (self.n_W.dot(&seen.p_W.coords) - self.b_m).abs();
        if off_m > NEAR_MIN_M.max(SIGMAS * seen.sigma_m) {
            return false;
        }
        // And as near as it is known across the plane.
        let across_m = seen.sigma_m * self.n_W.dot(way_W).abs() / way_W.norm();
        if off_m > NEAR_MIN_M.max(SIGMAS * across_m) {
            return false;
        }
        let p = self.X_FW * seen.p_W;
        let [x, y] = [0, 1].map(|axis| ((p[axis] - self.low[axis]) / FACE_CELL_M).floor());
        let within = x >= 0.0 && y >= 0.0 && x < self.cols as f64;
        within && self.on.get(y as usize * self.cols + x as usize) == Some(&true)
    }
}

/// Cells that are as far as [`BESIDE`] steps before or behind one that is on, in its row (steps of one) or its
/// column (steps of a row).
fn wider(on: &[bool], cols: usize, step: usize) -> Vec<bool> {
    let mut wide = on.to_vec();
    for (i, _) in on.iter().enumerate().filter(|(_, on)| **on) {
        for k in 1..=BESIDE {
            let in_line = |j: &usize| step != 1 || j / cols == i / cols;
            let (before, behind) = (i.checked_sub(k * step), Some(i + k * step));
            for j in [before, behind].into_iter().flatten().filter(in_line) {
                if let Some(cell) = wide.get_mut(j) {
                    *cell = true;
                }
            }
        }
    }
    wide
}

/// The cells that touch one another from the first on, taken out of those that are left.
fn connected(first: Cell, left: &mut BTreeSet<Cell>) -> Vec<Cell> {
    let mut thing = vec![first];
    let mut next = 0;
    while let Some(&[x, y, z]) = thing.get(next) {
        next += 1;
        for k in 0..27 {
            let beside = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
            if left.remove(&beside) {
                thing.push(beside);
            }
        }
    }
    thing.sort_unstable();
    thing
}

/// Cuts cells across their longest axis until each part about fills its box, or is small.
fn cut(part: Vec<Cell>, parts: &mut Vec<Vec<Cell>>) {
    let ends = |axis: usize| {
        let along = || part.iter().map(|cell| cell[axis]);
        (along().min().unwrap_or(0), along().max().unwrap_or(0))
    };
    let long = [0, 1, 2].map(|axis| ends(axis).1 - ends(axis).0 + 1);
    let axis = (0..3).max_by_key(|&axis| long[axis]).unwrap_or(0);
    let all: i64 = long.iter().product();
    if long[axis] <= 3 || part.len() as f64 >= BOX_FILLED * all as f64 {
        parts.push(part);
        return;
    }
    let middle = ends(axis).0 + long[axis] / 2;
    let (before, after) = part.into_iter().partition(|cell| cell[axis] < middle);
    [before, after]
        .into_iter()
        .for_each(|half| cut(half, parts));
}

/// The corners of a point that has a width.
fn around(p: Point3<f64>) -> impl Iterator<Item = Point3<f64>> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let ends = axes.into_iter().flat_map(|axis| [axis, -axis]);
    ends.map(move |end| p + POINT_M * end)
}

/// The points that are farthest out in directions all around.
fn outermost(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let all = (0..27).filter(|k| *k != 13);
    let directions = all.map(|k| {
        Vector3::new(
            f64::from(k % 3 - 1),
            f64::from(k / 3 % 3 - 1),
            f64::from(k / 9 - 1),
        )
    });
    let farthest = directions.filter_map(|d| {
        let along = |p: &usize| points[*p].coords.dot(&d);
        (0..points.len()).max_by(|a, b| along(a).total_cmp(&along(b)))
    });
    let farthest: BTreeSet<usize> = farthest.collect();
    farthest.into_iter().map(|i| points[i]).collect()
}

#[cfg(test)]
mod tests;
