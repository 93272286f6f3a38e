//! The planes of faces and where on them the faces are, for many points.

use nalgebra::{Isometry3, Point3, Vector3};

use super::NEAR_MIN_M;
use crate::free_space::{RayEnd, SIGMAS};
use crate::outline::Outline;
use crate::{Face, FaceId};

/// Side of the cells in which it is known where a face is, m.
const FACE_CELL_M: f64 = 0.02;
/// So many of them around a face its plane goes on.
const AROUND: isize = 15;
/// Most cells of a face: faces of a kilometre are no faces.
const CELLS_MAX: usize = 4_000_000;
/// Planes side by side, of which the heights of a point are found at once.
const LANES: usize = 8;

/// The planes of faces.
pub(super) struct Plates<'a> {
    pub all: Vec<Plate<'a>>,
    /// Of each plane n·p = b the coordinates of n, and b; those of the middle of its face, and the square of how far
    /// from that on the plane a point may be of it.
    lanes: Vec<[[f64; LANES]; 8]>,
}

impl<'a> Plates<'a> {
    pub fn new(faces: &'a [Face]) -> Self {
        let all: Vec<Plate> = faces.iter().filter_map(Plate::of).collect();
        let lanes = all.chunks(LANES).map(|plates| {
            // Nothing is near a plane that is none.
            let mut lanes = [[0.0; LANES]; 8];
            lanes[3] = [f64::INFINITY; LANES];
            for (k, plate) in plates.iter().enumerate() {
                let (n, (middle, reach_m)) = (plate.n_W, plate.reach());
                let of = [n.x, n.y, n.z, plate.b_m, middle.x, middle.y, middle.z];
                let of = of.into_iter().chain([reach_m * reach_m]);
                lanes.iter_mut().zip(of).for_each(|(lane, x)| lane[k] = x);
            }
            lanes
        });
        let lanes = lanes.collect();
        Self { all, lanes }
    }

    /// The planes that a point is of, each after how far off it as a part of what it may be; whether it is in none of
    /// the faces.
    pub fn beside(
        &self,
        seen: &RayEnd,
        way_W: &Vector3<f64>,
        found: &mut Vec<(f64, usize)>,
    ) -> bool {
        found.clear();
        let p = &seen.p_W;
        // As near as it is known along the ray, and so across a plane.
        let most_m = NEAR_MIN_M.max(SIGMAS * seen.sigma_m);
        for (first, [x, y, z, b, u, v, w, reach]) in (0..).step_by(LANES).zip(&self.lanes) {
            let mut off_m = [0.0; LANES];
            for k in 0..LANES {
                off_m[k] = (x[k] * p.x + y[k] * p.y + z[k] * p.z - b[k]).abs();
                let way = [p.x - u[k], p.y - v[k], p.z - w[k]];
                let away = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
                let beyond = away - off_m[k] * off_m[k] > reach[k];
                off_m[k] = if beyond { f64::INFINITY } else { off_m[k] };
            }
            let is_near = |near, off_m: &f64| near | i64::from(*off_m <= most_m);
            if off_m.iter().fold(0, is_near) == 0 {
                continue;
            }
            for (k, off_m) in (first..).zip(off_m).filter(|(_, off_m)| *off_m <= most_m) {
                match self.all[k].off(off_m, seen, way_W) {
                    Some(off) if off < 0.0 => return false,
                    off => found.extend(off.map(|off| (off, k))),
                }
            }
        }
        true
    }
}

/// Where a face is, in cells of its plane, for many questions.
pub(super) struct Plate<'a> {
    pub id: &'a FaceId,
    pub X_FW: Isometry3<f64>,
    /// The plane n·p = b in W, and its tangents.
    pub n_W: Vector3<f64>,
    b_m: f64,
    pub tangents_W: [Vector3<f64>; 2],
    low: [f64; 2],
    cols: usize,
    /// Row by row, whether the face is there.
    on: Vec<bool>,
}

impl<'a> Plate<'a> {
    fn of(face: &'a Face) -> Option<Self> {
        let (low, high) = Outline::from(&face.region).bounds()?;
        let count = |axis: usize| ((high[axis] - low[axis]) / FACE_CELL_M).ceil().max(1.0) as usize;
        let (cols, rows) = (count(0), count(1));
        let mut on = vec![false; cols.checked_mul(rows).filter(|n| *n <= CELLS_MAX)?];
        let middle = |axis: usize, k: usize| low[axis] + (k as f64 + 0.5) * FACE_CELL_M;
        // Where the rows' lines go in and out of the region: those of a segment are next to one another.
        let mut crossed: Vec<Vec<f64>> = vec![Vec::new(); rows];
        for (_, [a, b]) in face.region.segments() {
            let ends = [a.y.min(b.y), a.y.max(b.y)].map(|y| (y - low.y) / FACE_CELL_M - 0.5);
            let first = (ends[0].floor().max(0.0) as usize).min(rows);
            let end = ((ends[1].ceil() + 1.0).max(0.0) as usize).clamp(first, rows);
            for (y, crossed) in (first..).zip(&mut crossed[first..end]) {
                let at = middle(1, y);
                if (a.y > at) != (b.y > at) {
                    crossed.push(a.x + (at - a.y) / (b.y - a.y) * (b.x - a.x));
                }
            }
        }
        for (row, crossed) in on.chunks_exact_mut(cols).zip(&mut crossed) {
            crossed.sort_by(f64::total_cmp);
            for ends in crossed.chunks_exact(2) {
                let cell = |x: f64| ((x - low.x) / FACE_CELL_M).round().max(0.0) as usize;
                let [first, end] = [ends[0], ends[1]].map(|x| cell(x).min(cols));
                row[first..end].fill(true);
            }
        }
        let (n_W, turn) = (face.normal_W(), face.X_WF.rotation);
        Some(Self {
            id: &face.id,
            X_FW: face.X_WF.inverse(),
            n_W,
            b_m: n_W.dot(&face.X_WF.translation.vector),
            tangents_W: [turn * Vector3::x(), turn * Vector3::y()],
            low: [low.x, low.y],
            cols,
            on,
        })
    }

    /// The middle of the cells in W, and how far from that on the plane a point may be of it at most, m.
    fn reach(&self) -> (Point3<f64>, f64) {
        let rows = self.on.len() / self.cols;
        let half = |cells: usize| 0.5 * cells as f64 * FACE_CELL_M;
        let (x, y) = (half(self.cols), half(rows));
        let middle = Point3::new(self.low[0] + x, self.low[1] + y, 0.0);
        // One cell more than is asked for below, for rounding.
        let more = (AROUND + 1) as f64 * FACE_CELL_M;
        (self.X_FW.inverse() * middle, (x + more).hypot(y + more))
    }

    /// How far a point `off_m` from the plane is off it as a part of what it may be, where it is of it; less than 0 in
    /// the face: where one face ends and another one goes on it is in the other.
    pub(super) fn off(&self, off_m: f64, seen: &RayEnd, way_W: &Vector3<f64>) -> Option<f64> {
        let most_m = NEAR_MIN_M.max(SIGMAS * seen.sigma_m * self.across(way_W));
        if off_m > most_m {
            return None;
        }
        let p = self.X_FW * seen.p_W;
        let [x, y] = [0, 1].map(|axis| ((p[axis] - self.low[axis]) / FACE_CELL_M).floor() as isize);
        let (cols, rows) = (self.cols as isize, (self.on.len() / self.cols) as isize);
        let around = |x: isize, cells: isize| (-AROUND..cells + AROUND).contains(&x);
        if !around(x, cols) || !around(y, rows) {
            return None;
        }
        let within = (0..cols).contains(&x) && (0..rows).contains(&y);
        Some(match within && self.on[(y * cols + x) as usize] {
            true => -1.0,
            false => off_m / most_m,
        })
    }

    /// How far a point is over the plane, m.
    pub fn height_m(&self, p_W: &Point3<f64>) -> f64 {
        self.n_W.dot(&p_W.coords) - self.b_m
    }

    /// The sine of the angle between a ray and the plane.
    pub fn across(&self, way_W: &Vector3<f64>) -> f64 {
        self.n_W.dot(way_W).abs() / way_W.norm()
    }
}
