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
#[derive(Clone)]
struct Mask {
    inside: Vec<bool>,
    cols: usize,
    rows: usize,
}

/// Gaps of so many cells are closed.
const GAP: usize = 2;
/// Holes of fewer cells are where points happen to be missing: one that is, is nine.
const HOLE_MAX: f64 = 16.0;

/// Most cells of a mask; larger faces take larger cells.
const CELLS_MAX: f64 = 4e6;

impl Mask {
    /// Cells of half as many columns and rows: those of which one of four is inside.
    fn coarser(&self) -> Self {
        let (cols, rows) = (self.cols.div_ceil(2), self.rows.div_ceil(2));
        let mut inside = vec![false; cols * rows];
        for (y, line) in self.inside.chunks_exact(self.cols).enumerate() {
            let to = &mut inside[(y / 2) * cols..(y / 2 + 1) * cols];
            for (x, _) in line.iter().enumerate().filter(|(_, inside)| **inside) {
                to[x / 2] = true;
            }
        }
        Self { inside, cols, rows }
    }

    /// With gaps of up to `most` cells between two of a row, then of a column, closed: how points
    /// fall into cells leaves some of them empty.
    fn closed(mut self, most: usize) -> Self {
        let (cols, rows) = (self.cols, self.rows);
        let mut close = |start: usize, step: usize, count: usize| {
            let mut last = None;
            for k in 0..count {
                if !self.inside[start + k * step] {
                    continue;
                }
                if let Some(from) = last.filter(|from| (2..=most + 1).contains(&(k - from))) {
                    (from + 1..k).for_each(|j| self.inside[start + j * step] = true);
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
        let mut inside = vec![false; self.inside.len()];
        for y in 1..self.rows.saturating_sub(1) {
            let rows = [y - 1, y, y + 1].map(|y| &self.inside[y * self.cols..(y + 1) * self.cols]);
            let line = &mut inside[y * self.cols..(y + 1) * self.cols];
            for x in 1..self.cols.saturating_sub(1) {
                line[x] = rows.iter().all(|row| row[x - 1] && row[x] && row[x + 1]);
            }
        }
        Self {
            inside,
            cols: self.cols,
            rows: self.rows,
        }
    }

    /// The cells with all eight around them on which nothing stands: those with no fewer points on the plane than over
    /// it.
    fn bare(
        &self,
        points: &[Point2<f64>],
        standing: &[Point2<f64>],
        low: Point2<f64>,
        side_m: f64,
    ) -> Self {
        let mut excess = vec![0_i32; self.inside.len()];
        for (points, each) in [(points, 1), (standing, -1)] {
            for p in points {
                let (x, y) = ((p.x - low.x) / side_m, (p.y - low.y) / side_m);
                let within =
                    (0.0..self.cols as f64).contains(&x) && (0.0..self.rows as f64).contains(&y);
                if within {
                    excess[y as usize * self.cols + x as usize] += each;
                }
            }
        }
        Self {
            inside: excess.iter().map(|excess| *excess >= 0).collect(),
            ..*self
        }
        .interior()
    }

    /// Adds the cells of a mask that is coarser by two.
    fn add_coarser(&mut self, coarse: &Self) {
        for (y, line) in self.inside.chunks_exact_mut(self.cols).enumerate() {
            let from = &coarse.inside[(y / 2) * coarse.cols..];
            for (x, inside) in line.iter_mut().enumerate() {
                *inside |= from[x / 2];
            }
        }
    }

    /// The cells as an outline, the first corner at `low`.
    fn outline(&self, low: Point2<f64>, side_m: f64) -> Outline {
        let mut rectangles = Vec::new();
        for (y, line) in self.inside.chunks_exact(self.cols).enumerate() {
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
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        points.iter().map(|p| p[axis]).fold(from, pick)
    };
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let high = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
    let (width, height) = (high[0] - low[0], high[1] - low[1]);
    if !(width > 0.0 && height > 0.0 && width.is_finite() && height.is_finite()) {
        return Vec::new();
    }
    let mut side_m = CELL_M;
    while (width / side_m) * (height / side_m) > CELLS_MAX {
        side_m *= 2.0;
    }
    let low = Point2::new(low[0] - side_m, low[1] - side_m);
    let cells = |length: f64| (length / side_m).ceil() as usize + 3;
    let (cols, rows) = (cells(width), cells(height));
    let mut mask = Mask {
        inside: vec![false; cols * rows],
        cols,
        rows,
    };
    for p in points {
        let (x, y) = ((p.x - low.x) / side_m, (p.y - low.y) / side_m);
        mask.inside[y as usize * cols + x as usize] = true;
    }
    while !is_dense(&mask.inside, mask.cols, |inside| *inside) && 2.0 * side_m <= CELL_MAX_M {
        mask = mask.coarser();
        side_m *= 2.0;
    }
    let bare = mask.bare(points, standing, low, side_m);
    let mask = mask.closed(GAP);
    let mut sure = mask.interior();
    sure.add_coarser(&mask.coarser().interior());
    sure.inside
        .iter_mut()
        .zip(&bare.inside)
        .for_each(|(sure, bare)| *sure &= bare);
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
