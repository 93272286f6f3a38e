//! What a view looked through: where a ray went on, nothing stands.

use nalgebra::{Isometry3, Point2, Point3};

use crate::outline::Outline;

/// Side of the cells in which rays are counted, m.
pub(crate) const CELL_M: f64 = 0.02;
/// Rays end at least this far behind a face that they went through, m.
pub(crate) const BEHIND_MIN_M: f64 = 0.02;
/// And this many standard deviations of ray and plane farther.
pub(crate) const SIGMAS: f64 = 3.0;
/// Rays that go through a cell, at least.
const RAYS_MIN: usize = 2;
/// Rays that go through a cell for every one that ends on the face there, at least.
const RAYS_RATIO: f64 = 4.0;
/// Smallest area that was looked through, m².
const CARVED_MIN_M2: f64 = 0.005;
/// Most cells that are counted in: faces of a kilometre are no faces.
const CELLS_MAX: usize = 4_000_000;
/// Rays flatter than this to a plane do not tell where they meet it (sine of the angle).
pub(crate) const GRAZING: f64 = 0.05;

/// Of so many points that a face holds one tells of them.
pub const HELD: usize = 4;

/// A point that was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayEnd {
    /// The point in W, m.
    pub p_W: Point3<f64>,
    /// Standard deviation along the ray, m.
    pub sigma_m: f64,
}

/// From where a view looked, and what it saw: nothing is between.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FreeSpace {
    /// Where the sensor was, in W, m.
    pub eye_W: Point3<f64>,
    /// The points; a sample of them will do.
    pub points: Vec<RayEnd>,
    /// Those that no face is known to hold, as dense a sample as `density` says.
    pub beside: Vec<RayEnd>,
    /// Those that a face is known to hold, one of [`HELD`] of a sample as dense.
    pub held: Vec<Point3<f64>>,
    /// Of all points as many are in such a sample on a square that faces the sensor, of a side as long as it is far
    /// away, where it sees most.
    pub density: f64,
}

/// What a view makes of a face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carved {
    /// Where rays went through, in F.
    pub through: Outline,
    /// Cells in which rays ended on it: their middles in F, and one such end in W.
    pub on: Vec<(Point2<f64>, Point3<f64>)>,
}

/// Cells of [`CELL_M`] over an outline.
struct Grid {
    low: Point2<f64>,
    cols: usize,
    rows: usize,
}

impl FreeSpace {
    /// The part of a plane outline in F that rays went through, and where rays ended on it.
    ///
    /// A ray counts for the cell in which it meets the plane: as going through where it ends surely on
    /// the other side, as ending where its point is on the plane. `sigma_at` is the plane's own
    /// standard deviation at a point of F.
    pub fn carved(
        &self,
        X_WF: &Isometry3<f64>,
        outline: &Outline,
        sigma_at: &dyn Fn(&Point2<f64>) -> f64,
    ) -> Carved {
        let Some(grid) = Grid::over(outline).filter(|_| !self.points.is_empty()) else {
            return Carved::default();
        };
        let cells = grid.cols * grid.rows;
        let mut through = vec![0_usize; cells];
        let mut ended = vec![(0_usize, Point3::origin()); cells];
        let X_FW = X_WF.inverse();
        let eye = X_FW * self.eye_W;
        for seen in &self.points {
            let p = X_FW * seen.p_W;
            let way = p - eye;
            // Level with the plane: the ray says nothing of it.
            if way.z.abs() <= GRAZING * way.norm() {
                continue;
            }
            let at = (eye + way * (-eye.z / way.z)).xy();
            let Some(index) = grid.index(&at) else {
                continue;
            };
            let across = seen.sigma_m * way.z.abs() / way.norm();
            let margin = BEHIND_MIN_M + SIGMAS * across.hypot(sigma_at(&at));
            if p.z.abs() <= 0.5 * margin {
                ended[index] = (ended[index].0 + 1, seen.p_W);
            } else if p.z.abs() > margin && (p.z > 0.0) != (eye.z > 0.0) {
                through[index] += 1;
            }
        }
        let free = |i: usize| {
            through[i] >= RAYS_MIN
                && through[i] as f64 >= RAYS_RATIO * ended[i].0 as f64
                && outline.contains(&grid.centre(i))
        };
        let free = grid.blocks(&(0..cells).map(free).collect::<Vec<bool>>());
        let on = (0..cells).filter(|&i| ended[i].0 >= RAYS_MIN);
        Carved {
            through: Outline::from_rectangles(&grid.runs(&free))
                .without_specks(CARVED_MIN_M2)
                .simplified(0.5 * CELL_M),
            on: on.map(|i| (grid.centre(i), ended[i].1)).collect(),
        }
    }
}

impl Grid {
    fn over(outline: &Outline) -> Option<Self> {
        let (low, high) = outline.bounds()?;
        let count = |axis: usize| ((high[axis] - low[axis]) / CELL_M).ceil().max(1.0) as usize;
        let (cols, rows) = (count(0), count(1));
        (cols.saturating_mul(rows) <= CELLS_MAX).then_some(Self { low, cols, rows })
    }

    fn index(&self, p: &Point2<f64>) -> Option<usize> {
        let (x, y) = ((p.x - self.low.x) / CELL_M, (p.y - self.low.y) / CELL_M);
        let within = (0.0..self.cols as f64).contains(&x) && (0.0..self.rows as f64).contains(&y);
        within.then(|| y as usize * self.cols + x as usize)
    }

    fn centre(&self, index: usize) -> Point2<f64> {
        let [x, y] = [index % self.cols, index / self.cols].map(|i| (i as f64 + 0.5) * CELL_M);
        Point2::new(self.low.x + x, self.low.y + y)
    }

    /// Keeps the cells that are a part of a free block of 2 × 2: narrower strips are edges that are a
    /// little off.
    fn blocks(&self, free: &[bool]) -> Vec<bool> {
        let mut kept = vec![false; free.len()];
        for y in 0..self.rows.saturating_sub(1) {
            for x in 0..self.cols.saturating_sub(1) {
                let block = [0, 1, self.cols, self.cols + 1].map(|step| y * self.cols + x + step);
                if block.iter().all(|&i| free[i]) {
                    block.iter().for_each(|&i| kept[i] = true);
                }
            }
        }
        kept
    }

    /// Runs of free cells as rectangles (low and high corner), each half a cell wider: its edge may be
    /// anywhere in the next one.
    fn runs(&self, free: &[bool]) -> Vec<([f64; 2], [f64; 2])> {
        let corner = |x: usize, y: usize, out: f64| {
            let [x, y] = [x, y].map(|i| (i as f64 + out) * CELL_M);
            [self.low.x + x, self.low.y + y]
        };
        let mut rectangles = Vec::new();
        for (row, line) in free.chunks_exact(self.cols).enumerate() {
            let mut start = 0;
            for run in line.chunk_by(|a, b| a == b) {
                let end = start + run.len();
                if run[0] {
                    rectangles.push((corner(start, row, -0.5), corner(end, row + 1, 0.5)));
                }
                start = end;
            }
        }
        rectangles
    }
}
