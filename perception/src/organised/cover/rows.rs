//! Areas measured along rows, eight side by side.

use wide::f32x8;

use super::segments::{Cut, LANES, Point};

/// Rows over the height of a region, in groups that are side by side.
pub(super) const GROUPS: usize = 32 / LANES;
pub(super) const ROWS: usize = LANES * GROUPS;

/// What is where no row is.
pub(super) const NOWHERE: f32 = 1e15;

/// Where the rows are.
pub(super) struct Frame {
    pub low: f32,
    pub pitch_m: f32,
    pub y: [f32x8; GROUPS],
}

impl Frame {
    /// Rows from `low` to `high`.
    pub fn new(low: f32, high: f32) -> Self {
        let pitch_m = (high - low) / ROWS as f32;
        let y = |row: usize| low + (row as f32 + 0.5) * pitch_m;
        Self {
            low,
            pitch_m,
            y: std::array::from_fn(|i| f32x8::from(std::array::from_fn(|k| y(LANES * i + k)))),
        }
    }

    /// Where a row is.
    pub fn y(&self, row: usize) -> f32 {
        self.low + (row as f32 + 0.5) * self.pitch_m
    }

    /// Distance from the lowest or the highest place.
    #[inline]
    pub fn end(&self, y: f32x8) -> f32x8 {
        let high = self.low + self.pitch_m * ROWS as f32;
        (y - self.low).fast_min(-y + high)
    }
}

/// One interval of each row.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub from: [f32x8; GROUPS],
    pub to: [f32x8; GROUPS],
}

/// Where a line leaves the rows.
struct Line {
    start: f32,
    slope: f32,
    /// Whether the half-plane is on the left.
    left: bool,
}

impl Line {
    #[inline]
    fn new(cut: &Cut) -> Self {
        let [nx, ny] = cut.n;
        let nx = if nx.abs() < 1e-6 { 1e-6 } else { nx };
        Self {
            start: cut.b / nx,
            slope: ny / nx,
            left: nx > 0.0,
        }
    }

    #[inline]
    fn at(&self, y: f32x8) -> f32x8 {
        -(y * self.slope) + self.start
    }
}

impl Rows {
    /// Whole rows.
    pub const ALL: Self = Self {
        from: [f32x8::splat(-NOWHERE); GROUPS],
        to: [f32x8::splat(NOWHERE); GROUPS],
    };
    /// Nothing of any.
    pub const NONE: Self = Self {
        from: [f32x8::splat(NOWHERE); GROUPS],
        to: [f32x8::splat(-NOWHERE); GROUPS],
    };

    /// The interval of a row.
    pub fn get(&self, row: usize) -> (f32, f32) {
        let (i, k) = (row / LANES, row % LANES);
        (self.from[i].as_array()[k], self.to[i].as_array()[k])
    }

    /// Makes it another one.
    pub fn set(&mut self, row: usize, (from, to): (f32, f32)) {
        let (i, k) = (row / LANES, row % LANES);
        self.from[i].as_mut_array()[k] = from;
        self.to[i].as_mut_array()[k] = to;
    }

    /// Leaves what is in a half-plane.
    #[inline]
    pub fn cut(&mut self, frame: &Frame, cut: &Cut) {
        let line = Line::new(cut);
        for i in 0..GROUPS {
            let x = line.at(frame.y[i]);
            if line.left {
                self.to[i] = self.to[i].fast_min(x);
            } else {
                self.from[i] = self.from[i].fast_max(x);
            }
        }
    }

    /// Leaves what is in both.
    #[inline]
    pub fn both(&mut self, other: &Self) {
        for i in 0..GROUPS {
            self.from[i] = self.from[i].fast_max(other.from[i]);
            self.to[i] = self.to[i].fast_min(other.to[i]);
        }
    }

    /// Area, m².
    #[inline]
    pub fn area(&self, frame: &Frame) -> f32 {
        sum(|i| self.to[i] - self.from[i]) * frame.pitch_m
    }

    /// Area of what is in both, m².
    #[inline]
    pub fn area_both(&self, frame: &Frame, other: &Self) -> f32 {
        let width =
            |i: usize| self.to[i].fast_min(other.to[i]) - self.from[i].fast_max(other.from[i]);
        sum(width) * frame.pitch_m
    }

    /// Area of the part in a half-plane, m².
    #[inline]
    pub fn area_within(&self, frame: &Frame, cut: &Cut) -> f32 {
        let line = Line::new(cut);
        let x = |i: usize| line.at(frame.y[i]);
        let sum = if line.left {
            sum(|i| self.to[i].fast_min(x(i)) - self.from[i])
        } else {
            sum(|i| self.to[i] - self.from[i].fast_max(x(i)))
        };
        sum * frame.pitch_m
    }

    /// Centroid, and a matrix [[m₀, 0], [m₁, m₂]] that makes the second moments those of a circle.
    pub fn ellipse(&self, frame: &Frame, about: &Point) -> Option<(Point, [f32; 3])> {
        // Sums of 1, x, y, x², x y, y², about a place nearby.
        let mut sums = [f32x8::ZERO; 6];
        for i in 0..GROUPS {
            let width = (self.to[i] - self.from[i]).fast_max(f32x8::ZERO);
            // Where there is nothing the middle is anything finite.
            let x = (self.to[i] + self.from[i]) * 0.5 - about[0];
            let y = frame.y[i] - about[1];
            sums[0] += width;
            sums[1] += width * x;
            sums[2] += width * y;
            sums[3] += width * (x * x + width * width * (1.0 / 12.0));
            sums[4] += width * x * y;
            sums[5] += width * y * y;
        }
        let [n, x, y, xx, xy, yy] = sums.map(total);
        let [x, y, xx, xy, yy] = [x, y, xx, xy, yy].map(|s| s / n);
        let thick = frame.pitch_m * frame.pitch_m / 12.0;
        let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y + thick);
        // Of Σ = L Lᵀ, L⁻¹.
        let l = xx.sqrt();
        let m = xy / l;
        let k = (yy - m * m).sqrt();
        let metric = [1.0 / l, -m / (l * k), 1.0 / k];
        let finite = metric.iter().all(|m| m.is_finite());
        finite.then_some(([about[0] + x, about[1] + y], metric))
    }
}

/// Sum of all lanes, in one order on every machine.
#[inline]
fn total(lanes: f32x8) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Sum of what is positive.
#[inline]
fn sum(of: impl Fn(usize) -> f32x8) -> f32 {
    let mut sum = f32x8::ZERO;
    for i in 0..GROUPS {
        sum += of(i).fast_max(f32x8::ZERO);
    }
    total(sum)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The sides of a square.
    pub fn square(x0: f32, y0: f32, side: f32) -> Vec<(Point, Point)> {
        let corner = |x: f32, y: f32| [x0 + x * side, y0 + y * side];
        let ring = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ];
        (0..4).map(|i| (ring[i], ring[(i + 1) % 4])).collect()
    }

    /// What is in a convex ring.
    pub fn rows(frame: &Frame, sides: &[(Point, Point)]) -> Rows {
        let mut rows = Rows::ALL;
        for (a, b) in sides {
            rows.cut(frame, &Cut::left_of(a, b).unwrap());
        }
        rows
    }

    pub fn near(a: f32, b: f32) -> bool {
        (a - b).abs() < 1e-5
    }

    #[test]
    fn a_half_plane_cuts_off_what_its_triangle_has() {
        let frame = Frame::new(-1.0, 1.0);
        let mut whole = rows(&frame, &square(-1.0, -1.0, 2.0));
        let cut = Cut::left_of(&[1.0, -1.0], &[-1.0, 1.0]).unwrap();
        assert!(near(whole.area_within(&frame, &cut), 2.0));
        whole.cut(&frame, &cut);
        assert!(near(whole.area(&frame), 2.0));
        let (centre, _) = whole.ellipse(&frame, &[0.5, 0.5]).unwrap();
        assert!(
            centre.iter().all(|x| (x + 1.0 / 3.0).abs() < 1e-3),
            "{centre:?}"
        );
    }

    #[test]
    fn the_ellipse_makes_a_rectangle_as_wide_as_high() {
        let frame = Frame::new(0.0, 1.0);
        let mut rows = rows(&frame, &square(0.0, 0.0, 1.0));
        rows.cut(
            &frame,
            &Cut {
                n: [1.0, 0.0],
                b: 0.2,
            },
        );
        let (centre, [m0, m1, m2]) = rows.ellipse(&frame, &[0.0; 2]).unwrap();
        assert!(near(centre[0], 0.1) && near(centre[1], 0.5));
        assert!(near(m2 / m0, 0.2) && near(m1, 0.0), "{m0} {m1} {m2}");
    }
}
