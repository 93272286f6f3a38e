//! How far a place is from the space that a view looked through.
//!
//! A ray was looked through up to where it ends. Rays are kept by their directions from the eye, in cells; a place is
//! as far from what was seen as from the nearest of them. A direction in which nothing was measured tells nothing:
//! it is the border of the view, a hole in it, or something nearer than the sensor measures.

use nalgebra::{Point3, Vector2, Vector3};

/// Smallest side of a cell, rad; larger ones by twos, up to this many times, until rays lie densely.
const CELL_RAD: f64 = 0.01;
const DOUBLINGS_MAX: usize = 3;
/// Cells with rays have so many such neighbours (of four) on average where rays lie densely.
const NEIGHBOURS_MIN: f64 = 3.2;
/// Rays of a cell go through its middle to this part of its side.
const SPREAD: f64 = 0.75;
/// Where a ray ends is known to so much, m, and so much of its length.
const END_M: f64 = 0.03;
const END_RATIO: f64 = 0.01;
/// For a place that is hidden the rays of so many cells around are looked at.
const AROUND: usize = 6;

/// The space that one view looked through.
///
/// Units: m.  Frames: W.
#[derive(Clone, Debug, Default)]
pub struct LookedThrough {
    eye_W: Point3<f64>,
    /// Index of the axis about which azimuths are counted: that from which rays lie farthest off.
    axis: usize,
    /// Azimuth and elevation of the first cell's corner, and the cells' side, rad.
    low: Vector2<f64>,
    side: f64,
    /// Cosine and sine of the columns' azimuths and of the rows' elevations.
    columns: Vec<[f64; 2]>,
    rows: Vec<[f64; 2]>,
    /// Mean length of the rays of a cell, m; 0 where there are none.
    length_m: Vec<f32>,
    /// The nearest cell with rays, by cell.
    nearest: Vec<u32>,
}

impl LookedThrough {
    /// What was looked through from an eye whose rays ended at these points.
    ///
    /// Shapes: the points by x, y, z.  Units: m.  Frames: W.
    pub fn new(eye_W: Point3<f64>, ends_W: &[[f32; 3]]) -> Self {
        let ways = ends_W
            .iter()
            .map(|p| Vector3::from(p.map(f64::from)) - eye_W.coords);
        let ways: Vec<Vector3<f64>> = ways.filter(|way| way.norm() > 1e-6).collect();
        let sums = ways
            .iter()
            .fold(Vector3::zeros(), |sum, way| sum + way.abs() / way.norm());
        let axis = sums.imin();
        let rays: Vec<Vector2<f64>> = ways.iter().map(|way| angles(axis, way)).collect();
        let mut found = Self {
            eye_W,
            axis,
            ..Self::default()
        };
        let Some(first) = rays.first() else {
            return found;
        };
        let (low, high) = rays.iter().fold((*first, *first), |(low, high), ray| {
            (low.inf(ray), high.sup(ray))
        });
        found.low = low;
        for doubling in 0..=DOUBLINGS_MAX {
            found.side = CELL_RAD * f64::from(1 << doubling);
            let line = |k: usize| {
                let count = ((high[k] - low[k]) / found.side) as usize + 1;
                let middle = |i: usize| low[k] + (i as f64 + 0.5) * found.side;
                (0..count)
                    .map(|i| [middle(i).cos(), middle(i).sin()])
                    .collect()
            };
            (found.columns, found.rows) = (line(0), line(1));
            let mut sums = vec![(0_u32, 0.0_f32); found.columns.len() * found.rows.len()];
            for (ray, way) in rays.iter().zip(&ways) {
                let (count, sum) = &mut sums[found.cell(ray)];
                (*count, *sum) = (*count + 1, *sum + way.norm() as f32);
            }
            let mean = |(count, sum): (u32, f32)| sum / count.max(1) as f32;
            found.length_m = sums.into_iter().map(mean).collect();
            if found.is_dense() {
                break;
            }
        }
        found.nearest = found.nearest_cells();
        found
    }

    /// How far a place is from the rays, m; 0 where they went through or ended, infinite where there are none.
    pub fn unseen_m(&self, p_W: &Point3<f64>) -> f64 {
        if self.nearest.is_empty() {
            return f64::INFINITY;
        }
        let way = p_W - self.eye_W;
        let nearest = self.nearest[self.cell(&angles(self.axis, &way))] as usize;
        let off_m = self.off_m(nearest, &way);
        if off_m <= 0.0 || f64::from(self.length_m[nearest]) >= way.norm() {
            return off_m.max(0.0);
        }
        // Hidden: beside what hides it others may have gone on.
        let cols = self.columns.len();
        let around =
            |at: usize, count: usize| at.saturating_sub(AROUND)..count.min(at + AROUND + 1);
        let cells = around(nearest / cols, self.rows.len())
            .flat_map(|y| around(nearest % cols, cols).map(move |x| y * cols + x))
            .filter(|&cell| self.length_m[cell] > 0.0);
        cells
            .fold(off_m, |least, cell| least.min(self.off_m(cell, &way)))
            .max(0.0)
    }

    /// How far a place, from the eye, is from the rays of a cell beyond what these may be off, m.
    fn off_m(&self, cell: usize, way: &Vector3<f64>) -> f64 {
        let (x, y) = (cell % self.columns.len(), cell / self.columns.len());
        let ([cos, sin], [level, up]) = (self.columns[x], self.rows[y]);
        let mut ray = Vector3::zeros();
        ray[(self.axis + 1) % 3] = cos * level;
        ray[(self.axis + 2) % 3] = sin * level;
        ray[self.axis] = up;
        let length = f64::from(self.length_m[cell]);
        let along = way.dot(&ray);
        let end_m = if along > length {
            END_M + END_RATIO * length
        } else {
            0.0
        };
        let along = along.clamp(0.0, length);
        (way - ray * along).norm() - SPREAD * self.side * along - end_m
    }

    /// The cell of a direction, the nearest one of the picture where it is outside.
    fn cell(&self, angles: &Vector2<f64>) -> usize {
        let at = (angles - self.low) / self.side;
        let within = |x: f64, count: usize| (x.max(0.0) as usize).min(count - 1);
        within(at.y, self.rows.len()) * self.columns.len() + within(at.x, self.columns.len())
    }

    fn is_dense(&self) -> bool {
        let (cols, rows) = (self.columns.len(), self.rows.len());
        let has = |x, y| x < cols && y < rows && self.length_m[y * cols + x] > 0.0;
        let (mut count, mut pairs) = (0_usize, 0_usize);
        for (x, y) in (0..rows).flat_map(|y| (0..cols).map(move |x| (x, y))) {
            if has(x, y) {
                count += 1;
                pairs += usize::from(has(x + 1, y)) + usize::from(has(x, y + 1));
            }
        }
        2.0 * pairs as f64 / count.max(1) as f64 >= NEIGHBOURS_MIN
    }

    /// The nearest cells with rays: two sweeps hand them on from neighbour to neighbour.
    fn nearest_cells(&self) -> Vec<u32> {
        let (cols, rows) = (self.columns.len() as i64, self.rows.len() as i64);
        let of = |(i, length): (usize, &f32)| if *length > 0.0 { i as u32 } else { u32::MAX };
        let mut nearest: Vec<u32> = self.length_m.iter().enumerate().map(of).collect();
        let apart = |from: i64, to: u32| {
            let to = i64::from(to);
            let (dx, dy) = (from % cols - to % cols, from / cols - to / cols);
            dx * dx + dy * dy
        };
        let mut take = |i: i64, before: i64| {
            for (dx, dy) in [(-1, 0), (-1, -1), (0, -1), (1, -1)] {
                let (x, y) = (i % cols + before * dx, i / cols + before * dy);
                if (0..cols).contains(&x) && (0..rows).contains(&y) {
                    let (other, own) = (nearest[(y * cols + x) as usize], nearest[i as usize]);
                    if other != u32::MAX && (own == u32::MAX || apart(i, other) < apart(i, own)) {
                        nearest[i as usize] = other;
                    }
                }
            }
        };
        (0..cols * rows).for_each(|i| take(i, 1));
        (0..cols * rows).rev().for_each(|i| take(i, -1));
        nearest
    }
}

/// Azimuth and elevation about an axis, rad.
fn angles(axis: usize, p: &Vector3<f64>) -> Vector2<f64> {
    let (a, b, c) = (p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]);
    Vector2::new(b.atan2(a), c.atan2(a.hypot(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall at x = 2, seen from (0, 0, 1) within 0.5 to both sides and in height, before it a board at x = 1 over
    /// y < −0.1, and a hole of the picture around y = 0.6.
    fn view() -> LookedThrough {
        let places = (-100..=100).flat_map(|y| (-100..=100).map(move |z| (y, z)));
        let end = |(y, z): (i32, i32)| {
            let [y, z] = [y, z].map(|k| 0.005 * k as f32);
            let x = if y < -0.1 { 1.0 } else { 2.0 };
            let hole = (y - 0.3).hypot(z) < 0.1;
            (!hole).then_some([x, x * y, 1.0 + x * z])
        };
        let ends: Vec<[f32; 3]> = places.filter_map(end).collect();
        LookedThrough::new(Point3::new(0.0, 0.0, 1.0), &ends)
    }

    #[test]
    fn what_rays_went_through_is_seen_and_all_else_is_as_far_as_it_is() {
        let view = view();
        for ([x, y, z], far_m) in [
            ([1.5, 0.1, 1.0], 0.0),
            ([1.99, 0.1, 1.0], 0.0),
            ([2.3, 0.1, 1.0], 0.25),
            // Behind the board, far in (as far as from where it was hit) and at its edge.
            ([1.6, -0.5, 1.0], 0.56),
            ([1.6, -0.2, 1.0], 0.04),
            // Beside the border, below it, behind the eye.
            ([1.0, 0.8, 1.0], 0.27),
            ([1.0, 0.0, 0.2], 0.27),
            ([-1.0, 0.0, 1.0], 1.0),
            // In the middle of the hole.
            ([1.0, 0.3, 1.0], 0.09),
        ] {
            let unseen_m = view.unseen_m(&Point3::new(x, y, z));
            assert!(
                (unseen_m - far_m).abs() < 0.02,
                "({x}, {y}, {z}): {unseen_m}"
            );
        }
        let nothing = LookedThrough::new(Point3::origin(), &[]);
        assert_eq!(nothing.unseen_m(&Point3::origin()), f64::INFINITY);
    }
}
