//! What was seen and is in no face, gathered into convex bodies to keep away from.
//!
//! A face's region is what is surely the face's: a strip along its edges, narrow parts and those where something else
//! may begin are taken off. For collisions they count. A point that is as near to the plane of a face around as it is
//! known is of that plane: beside the region it is put onto the plane, and nothing of its body is before that. Points of
//! no plane are things. Both are counted in cells, each point as the part of a full cell that it is at its distance, so that
//! single points between a thing and what is behind it are none. Cells that touch are one thing, and a thing is cut
//! until each part about fills a box. Each part is the hull of its points and of a little behind them.

mod grazing;
mod plates;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};

use crate::conservative_bodies::behind_W;
use crate::free_space::FreeSpace;
use crate::{Face, Obstacle};
use plates::Plates;

/// Side of the cells in which points are counted, m.
const CELL_M: f64 = 0.05;
/// The part of a cell's full number of points from which on something is there.
const FILLED: f64 = 0.25;
/// Full cells that the smallest thing of no plane has points for.
const FULL_CELLS_MIN: f64 = 1.0;
/// And points of any thing.
const POINTS_MIN: usize = 6;
/// Half the width of a point: a body has some in all directions, m.
const POINT_M: f64 = 0.005;
/// Nearer to a plane points are of it, m.
const NEAR_MIN_M: f64 = 0.02;
/// Planes are across each other from this angle on (its sine, squared).
const ACROSS: f64 = 0.5;
/// A thing that fills less of its box is cut where it is longer than a few cells: one of no plane, and one beside a
/// face, of which a hull would fill inner corners.
const BOX_FILLED: [f64; 2] = [0.3, 0.6];
/// Depth of a body behind what was seen of it, m.
const DEPTH_M: f64 = 0.03;

type Cell = [i64; 3];

/// Bodies of what the views show beside the faces: those of the planes of faces in their order, then those of none.
pub fn loose(faces: &[Face], views: &[&FreeSpace]) -> Vec<Obstacle> {
    let around = Plates::new(faces);
    let plates = &around.all;
    // 1. Points in the cells of the plane that they are of, and of none, each with its share of a full cell.
    let mut cells: Vec<BTreeMap<Cell, Vec<Loose>>> = Vec::new();
    cells.resize_with(plates.len() + 1, BTreeMap::new);
    let mut near: Vec<(f64, usize)> = Vec::new();
    for (number, view) in views.iter().enumerate() {
        for seen in &view.beside {
            let way_W = seen.p_W - view.eye_W;
            if !around.beside(seen, &way_W, &mut near) {
                continue;
            }
            let facing = view.density * (CELL_M / way_W.norm()).powi(2);
            let (to, at, full, ends_W) = match near.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some(&(_, k)) => {
                    let plate = &plates[k];
                    let mut foot_W = seen.p_W - plate.n_W * plate.height_m(&seen.p_W);
                    // The end of a riser is not over the tread.
                    for across in near.iter().map(|(_, across)| &plates[*across]) {
                        let t_W = across.n_W - plate.n_W * plate.n_W.dot(&across.n_W);
                        let height_m = across.height_m(&foot_W);
                        if t_W.norm_squared() > ACROSS && height_m > 0.0 {
                            foot_W -= t_W * (height_m / t_W.norm_squared());
                        }
                    }
                    let at = (plate.X_FW * foot_W).xy().coords.push(0.0);
                    let ends_W = [foot_W, foot_W - plate.n_W * DEPTH_M];
                    (k, at, facing * plate.across(&way_W), ends_W)
                }
                None => {
                    let behind_W = behind_W(&seen.p_W, &view.eye_W, DEPTH_M);
                    (plates.len(), seen.p_W.coords, facing, [seen.p_W, behind_W])
                }
            };
            let at = at.map(|x| (x / CELL_M).floor() as i64);
            cells[to].entry(at.into()).or_default().push(Loose {
                ends_W,
                sigma_m: seen.sigma_m,
                full,
                view: number,
            });
        }
    }
    if let Some(cells) = cells.last_mut() {
        grazing::weigh(cells, views);
    }
    // 2. Cells that touch, cut into parts, and their bodies.
    let (mut bodies, mut points) = (Vec::new(), Vec::new());
    let space = [Vector3::x(), Vector3::y(), Vector3::z()];
    for (k, mut cells) in cells.into_iter().enumerate() {
        let plate = plates.get(k);
        let share = |points: &[Loose]| points.iter().map(Loose::share).sum::<f64>();
        cells.retain(|_, points| share(points) >= FILLED);
        let (full_min, box_filled) = match plate {
            None => (FULL_CELLS_MIN, BOX_FILLED[0]),
            Some(_) => (FILLED, BOX_FILLED[1]),
        };
        let mut parts = Vec::new();
        let mut left: BTreeSet<Cell> = cells.keys().copied().collect();
        while let Some(first) = left.pop_first() {
            let thing = connected(first, &mut left);
            let full: f64 = thing.iter().map(|cell| share(&cells[cell])).sum();
            let points: usize = thing.iter().map(|cell| cells[cell].len()).sum();
            if full >= full_min && points >= POINTS_MIN {
                cut(thing, box_filled, &mut parts);
            }
        }
        for (number, part) in parts.iter().enumerate() {
            points.clear();
            for seen in part.iter().flat_map(|cell| &cells[cell]) {
                points.extend_from_slice(&seen.ends_W);
            }
            let axes = plate.map_or(&space[..], |plate| &plate.tangents_W);
            bodies.push(Obstacle {
                id: match plate {
                    None => format!("{NAME}{number}"),
                    Some(plate) => format!("{}/rim{number}", plate.id),
                },
                points_W: outermost(&points, axes),
                surface: None,
                assumed: false,
            });
        }
    }
    bodies
}

/// What bodies of no plane are called.
const NAME: &str = "loose";

/// Whether a body is of points of no plane, by its name: `loose` and a number.
pub fn is_loose(body: &Obstacle) -> bool {
    let number = body.id.strip_prefix(NAME);
    let is_number = |n: &str| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit());
    body.surface.is_none() && number.is_some_and(is_number)
}

struct Loose {
    /// The point, and what is behind it.
    ends_W: [Point3<f64>; 2],
    /// Standard deviation along the ray, m.
    sigma_m: f64,
    /// Points of a full cell.
    full: f64,
    /// The view that shows it.
    view: usize,
}

impl Loose {
    /// The part of a full cell that the point is.
    fn share(&self) -> f64 {
        1.0 / self.full.max(1.0)
    }

    /// The sine of the angle between the point's ray and a plane.
    fn across(&self, n_W: &Vector3<f64>) -> f64 {
        let [p_W, behind_W] = &self.ends_W;
        n_W.dot(&(behind_W - p_W)).abs() / (behind_W - p_W).norm()
    }
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
fn cut(part: Vec<Cell>, box_filled: f64, parts: &mut Vec<Vec<Cell>>) {
    let ends = |axis: usize| {
        let along = || part.iter().map(|cell| cell[axis]);
        (along().min().unwrap_or(0), along().max().unwrap_or(0))
    };
    let long = [0, 1, 2].map(|axis| ends(axis).1 - ends(axis).0 + 1);
    let axis = (0..3).max_by_key(|&axis| long[axis]).unwrap_or(0);
    let all: i64 = long.iter().product();
    if long[axis] <= 3 || part.len() as f64 >= box_filled * all as f64 {
        parts.push(part);
        return;
    }
    let middle = ends(axis).0 + long[axis] / 2;
    let (before, after) = part.into_iter().partition(|cell| cell[axis] < middle);
    [before, after]
        .into_iter()
        .for_each(|half| cut(half, box_filled, parts));
}

/// Directions in which a body's corners are found, and three that fill up what a processor takes at once.
const WAYS: usize = 16;

/// The corners of the hull that are farthest out in directions all around, of points that have a width along axes.
fn outermost(points: &[Point3<f64>], axes: &[Vector3<f64>]) -> Vec<Point3<f64>> {
    // Half of the directions to the corners, edges and sides of a cube, the other half is opposite: their components
    // along each axis.
    let along = |axis: u32| -> [f64; WAYS] {
        std::array::from_fn(|k| (k / 3_usize.pow(axis) % 3) as f64 - 1.0)
    };
    let [x, y, z] = [0, 1, 2].map(along);
    let (mut low, mut high) = ([f64::INFINITY; WAYS], [f64::NEG_INFINITY; WAYS]);
    let (mut low_at, mut high_at) = ([0_u64; WAYS], [0_u64; WAYS]);
    for (at, p) in (0..).zip(points) {
        for k in 0..WAYS {
            let along = p.x * x[k] + p.y * y[k] + p.z * z[k];
            let [is_low, is_high] = [along < low[k], along > high[k]];
            low[k] = if is_low { along } else { low[k] };
            low_at[k] = if is_low { at } else { low_at[k] };
            high[k] = if is_high { along } else { high[k] };
            high_at[k] = if is_high { at } else { high_at[k] };
        }
    }
    let mut corners: Vec<Point3<f64>> = Vec::new();
    let ways = (0..13).map(|k| Vector3::new(x[k], y[k], z[k]));
    for (d, at) in ways.zip(low_at.into_iter().zip(high_at)) {
        let point = |at: u64| points.get(at as usize).copied().unwrap_or_default();
        let (low, high) = (point(at.0), point(at.1));
        let most =
            |a: &&Vector3<f64>, b: &&Vector3<f64>| a.dot(&d).abs().total_cmp(&b.dot(&d).abs());
        let out = axes
            .iter()
            .max_by(most)
            .map_or(d, |axis| axis * axis.dot(&d).signum());
        for corner in [low - out * POINT_M, high + out * POINT_M] {
            if !corners.contains(&corner) {
                corners.push(corner);
            }
        }
    }
    corners
}

#[cfg(test)]
mod tests;
