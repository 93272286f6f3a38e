//! The points of a plane → the outline of the face that they surely lie on.

use nalgebra::Point2;
use surfaces::outline::Outline;

use crate::density::is_dense;

/// Side of the smallest cells in which points are looked for, m.
const CELL_M: f64 = 0.01;
/// Largest cells, m: no gap in the points that is twice as wide is closed.
const CELL_MAX_M: f64 = 0.25;
/// How far a simplified outline may stay inside the cells, in cells.
const TOLERANCE: f64 = 0.75;
/// Outlines with more corners are simplified more coarsely, up to four times as much.
const CORNERS_MAX: usize = 40;
/// What the points do not tell of an edge, m.
pub(super) const INSET_M: f64 = 0.01;

/// Cells of a plane, row by row.
struct Raster<T> {
    cells: Vec<T>,
    cols: usize,
    rows: usize,
}

/// Those that are inside of something.
type Mask = Raster<bool>;

/// Gaps of so many cells are closed.
const GAP: usize = 2;
/// Holes of fewer cells are where points happen to be missing: one that is, is nine.
const HOLE_MAX: f64 = 16.0;

/// Most cells of a mask; larger faces take larger cells.
const CELLS_MAX: f64 = 4e6;

impl<T: Copy + Default> Raster<T> {
    /// Cells of half as many columns and rows: four together make one.
    fn coarser(&self, join: impl Fn(T, T) -> T) -> Self {
        let (cols, rows) = (self.cols.div_ceil(2), self.rows.div_ceil(2));
        let mut cells = vec![T::default(); cols * rows];
        for (y, line) in self.cells.chunks_exact(self.cols).enumerate() {
            let to = &mut cells[(y / 2) * cols..(y / 2 + 1) * cols];
            for (two, to) in line.chunks(2).zip(to) {
                *to = two.iter().fold(*to, |to, cell| join(to, *cell));
            }
        }
        Self { cells, cols, rows }
    }

    /// The cells of which something holds.
    fn mask(&self, is: impl Fn(T) -> bool) -> Mask {
        Mask {
            cells: self.cells.iter().map(|cell| is(*cell)).collect(),
            cols: self.cols,
            rows: self.rows,
        }
    }
}

impl Mask {
    /// With gaps of up to `most` cells between two of a row, then of a column, closed: how points
    /// fall into cells leaves some of them empty.
    fn closed(mut self, most: usize) -> Self {
        let (cols, rows) = (self.cols, self.rows);
        let mut close = |start: usize, step: usize, count: usize| {
            let mut last = None;
            for k in 0..count {
                if !self.cells[start + k * step] {
                    continue;
                }
                if let Some(from) = last.filter(|from| (2..=most + 1).contains(&(k - from))) {
                    (from + 1..k).for_each(|j| self.cells[start + j * step] = true);
                }
                last = Some(k);
            }
        };
        (0..rows).for_each(|y| close(y * cols, 1, cols));
        (0..cols).for_each(|x| close(x, cols, rows));
        self
    }

    /// The cells that are inside with all eight around them: the face's edge is not in them.
    fn interior(&self) -> Self {
        let mut inside = vec![false; self.cells.len()];
        let mut columns = vec![false; self.cols];
        for y in 1..self.rows.saturating_sub(1) {
            let [above, here, below] =
                [y - 1, y, y + 1].map(|y| &self.cells[y * self.cols..(y + 1) * self.cols]);
            for (((all, a), b), c) in columns.iter_mut().zip(above).zip(here).zip(below) {
                *all = a & b & c;
            }
            let line = &mut inside[y * self.cols..(y + 1) * self.cols];
            for (inside, three) in line[1.min(self.cols)..].iter_mut().zip(columns.windows(3)) {
                *inside = three[0] & three[1] & three[2];
            }
        }
        Self {
            cells: inside,
            cols: self.cols,
            rows: self.rows,
        }
    }

    /// Adds the cells of a mask that is coarser by two.
    fn add_coarser(&mut self, coarse: &Self) {
        for (y, line) in self.cells.chunks_exact_mut(self.cols).enumerate() {
            let from = &coarse.cells[(y / 2) * coarse.cols..];
            for (x, inside) in line.iter_mut().enumerate() {
                *inside |= from[x / 2];
            }
        }
    }

    /// The cells as an outline, the first corner at `low`.
    fn outline(&self, low: Point2<f64>, side_m: f64) -> Outline {
        let mut rectangles = Vec::new();
        for (y, line) in self.cells.chunks_exact(self.cols).enumerate() {
            let mut x = 0;
            while x < self.cols {
                let start = x;
                while x < self.cols && line[x] {
                    x += 1;
                }
                if x > start {
                    let at =
                        |x: usize, y: usize| [low.x + x as f64 * side_m, low.y + y as f64 * side_m];
                    rectangles.push((at(start, y), at(x, y + 1)));
                }
                x += 1;
            }
        }
        Outline::from_rectangles(&rectangles)
    }
}

/// The outline of a face by points on its plane.
///
/// A cell counts where it and all around it hold points, so that the face's edge is outside of it;
/// how large cells have to be for that depends on how dense the points are, and cells of twice that
/// size add where they are sparser. Over a cell with more points that are `standing` on the plane than lie on it
/// something stands: the face ends before it.
///
/// Returns the connected parts, the largest first.
pub(super) fn outlines(
    points: &[Point2<f64>],
    standing: &[Point2<f64>],
    area_min_m2: f64,
) -> Vec<Outline> {
    let none = [f64::INFINITY; 2].map(|most| (most, -most));
    let [(left, right), (below, above)] = points.iter().fold(none, |[x, y], p| {
        let with = |(low, high): (f64, f64), at: f64| (low.min(at), high.max(at));
        [with(x, p.x), with(y, p.y)]
    });
    let (width, height) = (right - left, above - below);
    if !(width > 0.0 && height > 0.0 && width.is_finite() && height.is_finite()) {
        return Vec::new();
    }
    let mut side_m = CELL_M;
    while (width / side_m) * (height / side_m) > CELLS_MAX {
        side_m *= 2.0;
    }
    let low = Point2::new(left - side_m, below - side_m);
    let cells = |length: f64| (length / side_m).ceil() as usize + 3;
    let (cols, rows) = (cells(width), cells(height));
    let place = |p: &Point2<f64>, side_m: f64| (p - low) / side_m;
    let mut count = Raster {
        cells: vec![0_i32; cols * rows],
        cols,
        rows,
    };
    for at in points.iter().map(|p| place(p, side_m)) {
        // 32 bits convert in half the time.
        count.cells[at.y as u32 as usize * cols + at.x as u32 as usize] += 1;
    }
    while !is_dense(&count.cells, count.cols, |n| *n > 0) && 2.0 * side_m <= CELL_MAX_M {
        count = count.coarser(|a, b| a + b);
        side_m *= 2.0;
    }
    let mask = count.mask(|n| n > 0).closed(GAP);
    // Something stands where fewer points are on the plane than over it.
    for at in standing.iter().map(|p| place(p, side_m)) {
        let (cols, rows) = (count.cols as f64, count.rows as f64);
        if (0.0..cols).contains(&at.x) && (0.0..rows).contains(&at.y) {
            count.cells[at.y as usize * count.cols + at.x as usize] -= 1;
        }
    }
    let bare = count.mask(|excess| excess >= 0).interior();
    let mut sure = mask.interior();
    sure.add_coarser(&mask.coarser(|a, b| a | b).interior());
    for (sure, bare) in sure.cells.iter_mut().zip(&bare.cells) {
        *sure &= bare;
    }
    let whole = sure.outline(low, side_m);
    let whole = whole.without_specks(area_min_m2.min(HOLE_MAX * side_m * side_m));
    let parts = whole.parts().into_iter();
    parts
        .filter(|part| part.area() >= area_min_m2)
        .map(|part| simplified(&part, TOLERANCE * side_m))
        .collect()
}

/// A part with no more corners than pay, its jags taken off more coarsely the more there are.
fn simplified(part: &Outline, tolerance_m: f64) -> Outline {
    let mut simple = part.simplified_inside(tolerance_m);
    for coarser in [1.5, 2.0, 3.0, 4.0] {
        if simple.corners() <= CORNERS_MAX {
            break;
        }
        simple = part.simplified_inside(coarser * tolerance_m);
    }
    simple
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a lattice of a pitch with every `gap`-th column left out, in a face.
    fn lattice(pitch: f64, holds: impl Fn(f64, f64) -> bool) -> Vec<Point2<f64>> {
        let steps = (1.0 / pitch) as i32;
        let all = (0..steps).flat_map(|i| (0..steps).map(move |j| (f64::from(i), f64::from(j))));
        all.map(|(x, y)| Point2::new(x * pitch, y * pitch))
            .filter(|p| holds(p.x, p.y))
            .collect()
    }

    #[test]
    fn dense_and_sparse_points_give_the_face_and_nothing_beside_it() {
        let u = |x: f64, y: f64| !((0.3..0.7).contains(&x) && y > 0.4);
        for pitch in [0.004, 0.016, 0.05] {
            let parts = outlines(&lattice(pitch, u), &[], 0.005);
            assert_eq!(parts.len(), 1, "{pitch}");
            let face = Outline::from_rings(&[vec![
                [0.0, 0.0],
                [1.0, 0.0],
                [1.0, 1.0],
                [0.7, 1.0],
                [0.7, 0.4],
                [0.3, 0.4],
                [0.3, 1.0],
                [0.0, 1.0],
            ]]);
            assert!(parts[0].minus(&face).area() < 1e-6, "{pitch}");
            // An edge is lost to a cell of 1.5 to 3 times the pitch.
            let least = face.area() - face.length() * (3.5 * pitch + 0.01);
            assert!(parts[0].area() > least, "{pitch}: {}", parts[0].area());
        }
    }

    #[test]
    fn a_gap_in_dense_points_stays_open() {
        let slit = |x: f64, _: f64| !(0.48..0.52).contains(&x);
        assert_eq!(outlines(&lattice(0.004, slit), &[], 0.005).len(), 2);
    }

    #[test]
    fn a_face_ends_where_something_stands_on_it() {
        let all = lattice(0.008, |_, _| true);
        // A post of 6 cm; as many of its lowest points count as the face's.
        let post = lattice(0.008, |x, y| {
            (x - 0.5).abs() < 0.03 && (y - 0.5).abs() < 0.03
        });
        let parts = outlines(&all, &[&post[..], &post].concat(), 0.005);
        let is_face = |x: f64, y: f64| parts[0].contains(&Point2::new(x, y));
        assert!(parts.len() == 1 && parts[0].rings().len() == 2);
        assert!(!is_face(0.5, 0.5) && !is_face(0.465, 0.5) && is_face(0.44, 0.5));
        // As many as the face has may be its outliers.
        assert_eq!(outlines(&all, &post, 0.005)[0].rings().len(), 1);
    }

    #[test]
    fn points_in_a_line_give_nothing() {
        let line: Vec<_> = (0..99)
            .map(|i| Point2::new(0.01 * f64::from(i), 0.0))
            .collect();
        assert!(outlines(&line, &[], 0.005).is_empty());
        assert!(outlines(&[], &[], 0.005).is_empty());
    }
}
