//! A region sampled on a square lattice, and what of it is in no piece yet.

use std::ops::Range;

use nalgebra::Point2;

use super::grow::Edge;
use super::ring::Ring;

/// Samples of a hull, about this many.
const SAMPLES: f64 = 900.0;

/// Samples at the centres of square cells; those inside the region and in no piece are open.
pub(super) struct Lattice {
    low: Point2<f64>,
    pitch_m: f64,
    /// Samples a metre.
    density: f64,
    cols: usize,
    rows: usize,
    /// Number of open samples of a row before each column, `cols + 1` a row.
    before: Vec<u32>,
    /// Distance of every open sample from the nearest one outside of the region, about, m; 0 of
    /// all others.
    depths: Vec<f64>,
}

impl Lattice {
    /// The samples of the region between the edges, over its hull.
    pub fn new(hull: &Ring, edges: &[Edge]) -> Self {
        let pitch_m = (hull.area() / SAMPLES).sqrt();
        let ends = |axis: usize| {
            let along = || hull.0.iter().map(move |v| v[axis]);
            let low = along().fold(f64::INFINITY, f64::min);
            (low, along().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((x0, x1), (y0, y1)) = (ends(0), ends(1));
        // A hull is at most as long as its area over its width: a needle gets fewer samples.
        let count = |length: f64| (length / pitch_m).ceil().clamp(1.0, 4.0 * SAMPLES) as usize;
        let mut lattice = Self {
            low: Point2::new(x0, y0),
            pitch_m,
            density: 1.0 / pitch_m,
            cols: count(x1 - x0),
            rows: count(y1 - y0),
            before: Vec::new(),
            depths: Vec::new(),
        };
        // Crossings of the rows with the edges, left to right: odd intervals are inside.
        let mut crossings = Vec::new();
        for (a, b) in edges {
            let (rows, at) = lattice.crossings(a, b);
            crossings.extend(rows.map(|row| (row, at(row))));
        }
        crossings.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)));
        let (cols, rows) = (lattice.cols, lattice.rows);
        let mut open = vec![false; cols * rows];
        for pair in crossings.chunks_exact(2) {
            let (first, end) = lattice.columns(pair[0].1, pair[1].1);
            let start = pair[0].0 * cols;
            open[start + first..start + end].fill(true);
        }
        lattice.depths = depths(&open, cols, pitch_m);
        lattice.before = vec![0; (cols + 1) * rows];
        let lines = lattice.before.chunks_exact_mut(cols + 1);
        for (before, open) in lines.zip(open.chunks_exact(cols)) {
            let mut count = 0;
            for (before, &open) in before[1..].iter_mut().zip(open) {
                count += u32::from(open);
                *before = count;
            }
        }
        lattice
    }

    /// Area of the open samples, m².
    pub fn area(&self) -> f64 {
        let open = self
            .before
            .chunks_exact(self.cols + 1)
            .map(|b| b[self.cols]);
        f64::from(open.sum::<u32>()) * self.pitch_m * self.pitch_m
    }

    /// Area of the open samples in a piece, m².
    pub fn gain(&self, piece: &Ring) -> f64 {
        let mut count = 0;
        self.spans(piece, |row, first, end| {
            let before = &self.before[row * (self.cols + 1)..];
            count += before[end] - before[first];
        });
        f64::from(count) * self.pitch_m * self.pitch_m
    }

    /// Closes the samples in a piece.
    pub fn close(&mut self, piece: &Ring) {
        let mut spans = Vec::new();
        self.spans(piece, |row, first, end| spans.push((row, first, end)));
        for (row, first, end) in spans {
            let start = row * (self.cols + 1);
            let before = &mut self.before[start..start + self.cols + 1];
            let (left, gone) = (before[first], before[end] - before[first]);
            self.depths[row * self.cols..][first..end].fill(0.0);
            before[first..=end].fill(left);
            before[end + 1..].iter_mut().for_each(|n| *n -= gone);
        }
    }

    /// The open samples farthest from the region's border, each out of the free circles of those
    /// before it; at most `count`.
    pub fn seeds(&self, count: usize) -> Vec<Point2<f64>> {
        let mut seeds: Vec<(Point2<f64>, f64)> = Vec::new();
        let at = |i: usize, low: f64| low + (i as f64 + 0.5) * self.pitch_m;
        // What no sample of a row exceeds need not be looked for there.
        let deeper = |most: f64, depth: f64| if depth > most { depth } else { most };
        let deepest = |row: &[f64]| row.iter().copied().fold(0.0, deeper);
        let deepest: Vec<f64> = self.depths.chunks_exact(self.cols).map(deepest).collect();
        while seeds.len() < count {
            let mut most = (0.0, Point2::origin());
            let rows = self.depths.chunks_exact(self.cols).zip(&deepest);
            for (row, (depths, &deepest)) in rows.enumerate() {
                if deepest <= most.0 {
                    continue;
                }
                for (col, &depth) in depths.iter().enumerate() {
                    if depth > most.0 {
                        let p = Point2::new(at(col, self.low.x), at(row, self.low.y));
                        if seeds.iter().all(|(q, r)| (p - q).norm() > 2.0 * r) {
                            most = (depth, p);
                        }
                    }
                }
            }
            if most.0 <= 0.0 {
                break;
            }
            seeds.push((most.1, most.0));
        }
        seeds.into_iter().map(|(p, _)| p).collect()
    }

    /// Calls `with` for the row and the columns (from, to before) of a convex piece.
    fn spans(&self, piece: &Ring, mut with: impl FnMut(usize, usize, usize)) {
        // The left side of the piece goes down, the right side up.
        let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.rows];
        let (mut first, mut last) = (self.rows, 0);
        for (a, b) in piece.edges() {
            let side = usize::from(a.y <= b.y);
            let (rows, at) = self.crossings(a, b);
            (first, last) = (first.min(rows.start), last.max(rows.end));
            for (ends, row) in ends[rows.clone()].iter_mut().zip(rows) {
                ends[side] = at(row);
            }
        }
        for (row, &[low, high]) in ends.iter().enumerate().take(last).skip(first) {
            if low < high {
                let (first, end) = self.columns(low, high);
                with(row, first, end);
            }
        }
    }

    /// The rows that an edge crosses, and where it does.
    fn crossings(&self, a: &Point2<f64>, b: &Point2<f64>) -> (Range<usize>, impl Fn(usize) -> f64) {
        let (a, b) = if a.y <= b.y { (*a, b) } else { (*b, a) };
        // Rows with a.y ≤ y < b.y.
        let row = |y: f64| index((y - self.low.y) * self.density - 0.5).min(self.rows);
        let slope = (b.x - a.x) / (b.y - a.y);
        let (low, pitch_m) = (self.low.y, self.pitch_m);
        let at = move |row: usize| {
            let y = low + (row as f64 + 0.5) * pitch_m;
            a.x + (y - a.y) * slope
        };
        (row(a.y)..row(b.y), at)
    }

    /// The columns from x = `low` to x = `high`: the first, and one past the last.
    fn columns(&self, low: f64, high: f64) -> (usize, usize) {
        let column = |x: f64| index((x - self.low.x) * self.density - 0.5);
        let first = column(low).min(self.cols);
        (first, column(high).clamp(first, self.cols))
    }
}

/// The first index that is not before `x`.
fn index(x: f64) -> usize {
    // The cast cuts off, and makes what is negative 0; a call of `ceil` would cost ten times more.
    let whole = x as usize;
    whole + usize::from(x > whole as f64)
}

/// Distance of every open sample from the nearest one that is not, by two sweeps over its
/// neighbours (a chamfer distance: at most 8 % too long).
fn depths(open: &[bool], cols: usize, pitch_m: f64) -> Vec<f64> {
    const DIAGONAL: f64 = std::f64::consts::SQRT_2;
    let least = |a: f64, b: f64| if b < a { b } else { a };
    // With a frame of samples outside.
    let stride = cols + 2;
    let rows = open.len() / cols.max(1);
    let mut depth = vec![0.0_f64; stride * (rows + 2)];
    // Of a sample, from the row that was swept before and the one before in its own row.
    let nearest = |near: &[f64], before: f64| {
        let [corner, side, other] = [near[0], near[1], near[2]];
        least(least(side, before) + 1.0, least(corner, other) + DIAGONAL)
    };
    for (row, line) in open.chunks_exact(cols.max(1)).enumerate() {
        let (swept, here) = depth.split_at_mut((row + 1) * stride);
        let near = swept[row * stride..].windows(3);
        let mut before = 0.0;
        for ((here, near), &open) in here[1..].iter_mut().zip(near).zip(line) {
            before = if open { nearest(near, before) } else { 0.0 };
            *here = before;
        }
    }
    let mut result = vec![0.0; open.len()];
    for (row, line) in result.chunks_exact_mut(cols.max(1)).enumerate().rev() {
        let (here, swept) = depth.split_at_mut((row + 2) * stride);
        let here = &mut here[(row + 1) * stride..];
        let near = swept[..stride].windows(3);
        let mut before = 0.0;
        for ((here, near), result) in here[1..=cols].iter_mut().zip(near).zip(line).rev() {
            before = least(*here, nearest(near, before));
            *here = before;
            *result = before * pitch_m;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x0: f64, y0: f64, side: f64) -> Ring {
        let corner = |x: f64, y: f64| Point2::new(x0 + x * side, y0 + y * side);
        Ring(vec![
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ])
    }

    fn edges(ring: &Ring) -> Vec<Edge> {
        ring.edges().map(|(a, b)| (*a, *b)).collect()
    }

    #[test]
    fn areas_are_those_of_the_region_without_its_hole_and_pieces() {
        let outer = square(0.0, 0.0, 3.0);
        let hole = square(1.0, 1.0, 1.0);
        let both = [edges(&outer), edges(&hole)].concat();
        let mut lattice = Lattice::new(&outer, &both);
        assert!((lattice.area() - 8.0).abs() < 1e-9);
        // A piece that lies half in the hole, then one over it.
        let piece = square(0.5, 1.0, 1.0);
        assert!((lattice.gain(&piece) - 0.5).abs() < 1e-9);
        lattice.close(&piece);
        assert!((lattice.area() - 7.5).abs() < 1e-9);
        assert_eq!(lattice.gain(&piece), 0.0);
        assert!((lattice.gain(&square(0.0, 0.0, 2.0)) - 2.5).abs() < 1e-9);
    }

    #[test]
    fn the_first_seed_is_where_most_is_free() {
        // A large square with a small one beside it.
        let (large, small) = (square(0.0, 0.0, 2.0), square(2.0, 0.0, 1.0));
        let hull = Ring(vec![
            large.0[0], small.0[1], small.0[2], large.0[2], large.0[3],
        ]);
        let seeds = Lattice::new(&hull, &[edges(&large), edges(&small)].concat()).seeds(2);
        assert!(
            (seeds[0] - Point2::new(1.0, 1.0)).norm() < 0.25,
            "{seeds:?}"
        );
        assert!(seeds[1].x > 2.0, "{seeds:?}");
    }
}
