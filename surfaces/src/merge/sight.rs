//! What a view looked through: where a ray went on, nothing stands.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Point2, Point3};
use serde::{Deserialize, Serialize};

use super::Config;
use crate::outline::Outline;

/// What a view must see to refute a face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SightConfig {
    /// Side of the cells in which rays are counted, m.
    pub cell_m: f64,
    /// Rays must end at least this far behind a face, m, beside `sigmas`.
    pub behind_min_m: f64,
    /// Rays must end this many standard deviations of ray and plane behind a face.
    pub sigmas: f64,
    /// Rays that go through a cell, at least.
    pub rays_min: usize,
    /// Rays that go through a cell for every one that ends on the face there, at least.
    pub rays_ratio: f64,
    /// Cells that are free are taken off a face from this area on, m².
    pub area_min_m2: f64,
    /// A connected part of a face is gone as a whole where rays went through this part of it, and
    /// hardly any ended on the rest.
    pub gone_ratio: f64,
}

impl Default for SightConfig {
    fn default() -> Self {
        Self {
            cell_m: 0.02,
            behind_min_m: 0.02,
            sigmas: 3.0,
            rays_min: 2,
            rays_ratio: 4.0,
            area_min_m2: 0.005,
            gone_ratio: 0.5,
        }
    }
}

/// A point that was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The point in W, m.
    pub p_W: Point3<f64>,
    /// Standard deviation along the ray, m.
    pub sigma_m: f64,
}

/// From where a view looked, and what it saw: nothing is between.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Where the sensor was, in W, m.
    pub eye_W: Point3<f64>,
    /// The points; a sample of them will do.
    pub points: Vec<Seen>,
}

impl Default for Sight {
    fn default() -> Self {
        Self {
            eye_W: Point3::origin(),
            points: Vec::new(),
        }
    }
}

impl Sight {
    /// The part of a plane face that rays went through, and where rays ended on it, in its frame P.
    ///
    /// A ray counts for the cell in which it meets the plane: as going through where it ends surely
    /// on the other side, as ending where its point is on the plane. `sigma_at` is the plane's own
    /// standard deviation at a point of P.
    pub fn through(
        &self,
        X_WP: &Isometry3<f64>,
        outline: &Outline,
        sigma_at: &dyn Fn(&Point2<f64>) -> f64,
        config: &Config,
    ) -> Looked {
        let config = &config.sight;
        let Some((low, high)) = outline.bounds().filter(|_| !self.points.is_empty()) else {
            return Looked::default();
        };
        let cell = config.cell_m;
        let count = |axis: usize| ((high[axis] - low[axis]) / cell).ceil().max(1.0) as usize;
        let (cols, rows) = (count(0), count(1));
        // Faces of a kilometre are no faces.
        if cols.saturating_mul(rows) > CELLS_MAX {
            return Looked::default();
        }
        let mut through = vec![0_usize; cols * rows];
        let mut ended = vec![(0_usize, Point3::origin()); cols * rows];
        let X_PW = X_WP.inverse();
        let eye = X_PW * self.eye_W;
        for seen in &self.points {
            let p = X_PW * seen.p_W;
            let way = p - eye;
            // Level with the plane: the ray says nothing of it.
            if way.z.abs() <= GRAZING * way.norm() {
                continue;
            }
            let at = eye + way * (-eye.z / way.z);
            let (x, y) = ((at.x - low.x) / cell, (at.y - low.y) / cell);
            if !(0.0..cols as f64).contains(&x) || !(0.0..rows as f64).contains(&y) {
                continue;
            }
            let across = seen.sigma_m * way.z.abs() / way.norm();
            let sigma = across.hypot(sigma_at(&at.xy()));
            let margin = config.behind_min_m + config.sigmas * sigma;
            let index = y as usize * cols + x as usize;
            if p.z.abs() <= 0.5 * margin {
                ended[index] = (ended[index].0 + 1, seen.p_W);
            } else if p.z.abs() > margin && (p.z > 0.0) != (eye.z > 0.0) {
                through[index] += 1;
            }
        }
        let centre = |i: usize| {
            let (x, y) = ((i % cols) as f64 + 0.5, (i / cols) as f64 + 0.5);
            Point2::new(low.x + x * cell, low.y + y * cell)
        };
        let free: Vec<bool> = (0..cols * rows)
            .map(|i| {
                through[i] >= config.rays_min.max(1)
                    && through[i] as f64 >= config.rays_ratio * ended[i].0 as f64
                    && outline.contains(&centre(i))
            })
            .collect();
        let free = blocks(&free, cols);
        // Runs of free cells, each half a cell wider: its edge may be anywhere in the next one.
        let mut rectangles = Vec::new();
        for (row, line) in free.chunks_exact(cols).enumerate() {
            let mut x = 0;
            while x < cols {
                let start = x;
                while x < cols && line[x] {
                    x += 1;
                }
                if x > start {
                    let corner = |x: usize, y: usize, out: f64| {
                        [
                            low.x + (x as f64 + out) * cell,
                            low.y + (y as f64 + out) * cell,
                        ]
                    };
                    rectangles.push((corner(start, row, -0.5), corner(x, row + 1, 0.5)));
                }
                x += 1;
            }
        }
        let on = (0..cols * rows).filter(|&i| ended[i].0 >= config.rays_min.max(1));
        Looked {
            through: Outline::from_rectangles(&rectangles)
                .without_specks(config.area_min_m2)
                .simplified(0.5 * cell),
            on: on.map(|i| (centre(i), ended[i].1)).collect(),
        }
    }
}

/// What a view makes of a face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looked {
    /// Where rays went through.
    pub through: Outline,
    /// Cells in which rays ended on it: their middles in P, and one such end in W.
    pub on: Vec<(Point2<f64>, Point3<f64>)>,
}

/// Most cells that are counted in.
const CELLS_MAX: usize = 4_000_000;
/// Rays flatter than this to a plane do not tell where they meet it (sine of the angle).
const GRAZING: f64 = 0.05;

/// Keeps the cells that are a part of a free block of 2 × 2: narrower strips are edges that are a
/// little off.
fn blocks(free: &[bool], cols: usize) -> Vec<bool> {
    let mut kept = vec![false; free.len()];
    let rows = free.len() / cols.max(1);
    for y in 0..rows.saturating_sub(1) {
        for x in 0..cols.saturating_sub(1) {
            let block = [0, 1, cols, cols + 1].map(|step| y * cols + x + step);
            if block.iter().all(|&i| free[i]) {
                block.iter().for_each(|&i| kept[i] = true);
            }
        }
    }
    kept
}
