//! A face's runs → the pixels along its boundary.

use std::ops::Range;

use nalgebra::Point2;

use super::face::Face;

/// The pixels along the outer boundary of a face and along its holes, the face on the right hand
/// (v down), but for those inside of a straight row: no chord has them farther off than both ends.
pub(super) fn traces(face: &Face) -> Vec<Vec<Point2<f64>>> {
    let ends = Ends::new(face);
    let mut seen = vec![false; face.runs.len()];
    let mut traces = Vec::new();
    for start in 0..face.runs.len() {
        // Every ring passes the left end of a run.
        if !seen[start] {
            traces.push(ends.trace(start, &mut seen));
        }
    }
    traces
}

/// An end of a run, by the index of the run: rings go up at left ends and down at right ones.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Left(usize),
    Right(usize),
}

/// The ends of a face's runs.
struct Ends<'a> {
    /// Row, first column, one past the last column.
    runs: &'a [(u32, u32, u32)],
    top: u32,
    /// The first run of every row from the top one on, and the number of runs.
    rows: Vec<usize>,
}

impl<'a> Ends<'a> {
    fn new(face: &'a Face) -> Self {
        let runs = &face.runs;
        let top = runs.first().map_or(0, |run| run.0);
        // A connected face has a run in each of its rows.
        let first = |&i: &usize| i == 0 || runs[i - 1].0 != runs[i].0;
        let count = runs.last().map_or(0, |run| run.0 + 1 - top) as usize;
        let mut rows = Vec::with_capacity(count + 1);
        rows.extend((0..runs.len()).filter(first));
        rows.push(runs.len());
        Self { runs, top, rows }
    }

    /// The runs of a row, which may be outside of the face.
    fn row(&self, v: u32) -> Range<usize> {
        let row = v.wrapping_sub(self.top) as usize;
        match self.rows.get(row..).and_then(|rows| rows.first_chunk()) {
            Some(&[first, end]) => first..end,
            None => 0..0,
        }
    }

    /// Follows the boundary from the left end of a run; marks the left ends passed in `seen`.
    fn trace(&self, start: usize, seen: &mut [bool]) -> Vec<Point2<f64>> {
        let mut path = Path::new(self.runs[start].1, self.runs[start].0, 2 * self.rows.len());
        let mut end = End::Left(start);
        loop {
            end = match end {
                End::Left(run) => {
                    seen[run] = true;
                    path.to(self.runs[run].1, self.runs[run].0);
                    self.above(run, &mut path)
                }
                End::Right(run) => {
                    path.to(self.runs[run].2 - 1, self.runs[run].0);
                    self.below(run, &mut path)
                }
            };
            if end == End::Left(start) {
                break;
            }
        }
        path.closed(self.runs[start].1, self.runs[start].0)
    }

    /// The end after the left end of a run.
    fn above(&self, run: usize, path: &mut Path) -> End {
        let (v, a, b) = self.runs[run];
        let row = self.row(v.wrapping_sub(1));
        let Some(next) = row.into_iter().find(|&k| self.runs[k].2 > a) else {
            return End::Right(run);
        };
        let first = self.runs[next].1;
        if first > a {
            // Along the run's upper side, up to what is above it.
            if first >= b {
                return End::Right(run);
            }
            path.to(first - 1, v);
        } else if first < a {
            // Back along the lower side of what is above, as far as nothing else is below it.
            path.to(a - 1, v - 1);
            if run > 0
                && let (row, _, end) = self.runs[run - 1]
                && row == v
                && end > first
            {
                path.to(end, v - 1);
                return End::Right(run - 1);
            }
        }
        End::Left(next)
    }

    /// The end after the right end of a run.
    fn below(&self, run: usize, path: &mut Path) -> End {
        let (v, a, b) = self.runs[run];
        let mut row = self.row(v + 1).rev();
        let Some(next) = row.find(|&k| self.runs[k].1 < b) else {
            return End::Left(run);
        };
        let end = self.runs[next].2;
        if end < b {
            if end <= a {
                return End::Left(run);
            }
            path.to(end, v);
        } else if end > b {
            path.to(b, v + 1);
            if let Some(&(row, first, _)) = self.runs.get(run + 1)
                && row == v
                && first < end
            {
                path.to(first - 1, v + 1);
                return End::Left(run + 1);
            }
        }
        End::Right(next)
    }
}

/// The pixels of a ring.
struct Path {
    points: Vec<Point2<f64>>,
    last: (i32, i32),
    /// The direction of the last step, none before the first.
    way: i32,
}

impl Path {
    /// From a pixel, with room for so many.
    fn new(u: u32, v: u32, room: usize) -> Self {
        let mut points = Vec::with_capacity(room);
        points.push(Point2::new(u.into(), v.into()));
        Self {
            points,
            last: (u as i32, v as i32),
            way: 0,
        }
    }

    /// Goes on to a pixel, straight or to one beside it.
    #[inline]
    fn to(&mut self, u: u32, v: u32) {
        let (u, v) = (u as i32, v as i32);
        // One number for each of the eight directions.
        let way = (u - self.last.0).signum() + 3 * (v - self.last.1).signum();
        if way == 0 {
            return;
        }
        let point = Point2::new(u.into(), v.into());
        // Of pixels in a row the last one stands for those between.
        match self.points.last_mut() {
            Some(last) if way == self.way => *last = point,
            _ => self.points.push(point),
        }
        self.way = way;
        self.last = (u, v);
    }

    /// The pixels, back at the first one.
    fn closed(mut self, u: u32, v: u32) -> Vec<Point2<f64>> {
        self.to(u, v);
        if self.points.len() > 1 {
            self.points.pop();
        }
        self.points
    }
}
