//! Segments that half-planes cut, four side by side.

use wide::f32x4;

/// How many are side by side.
pub(super) const LANES: usize = 4;

/// A point of the plane, m.
pub(super) type Point = [f32; 2];

/// Where segments are of which nothing is left.
const GONE: f32 = 1e15;

/// The half-plane {n·p ≤ b}, n a unit vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub n: Point,
    pub b: f32,
}

impl Cut {
    /// What is on the left of the line from `a` to `b`; none where they are at one place.
    pub fn left_of(a: &Point, b: &Point) -> Option<Self> {
        let n = [b[1] - a[1], a[0] - b[0]];
        let inverse = 1.0 / (n[0] * n[0] + n[1] * n[1]).sqrt();
        let n = n.map(|x| x * inverse);
        let b = n[0] * a[0] + n[1] * a[1];
        b.is_finite().then_some(Self { n, b })
    }

    /// How far a point is outside, m.
    #[inline]
    pub fn value(&self, p: &Point) -> f32 {
        self.n[0] * p[0] + self.n[1] * p[1] - self.b
    }
}

/// Segments from `a` to `b`.
#[derive(Clone, Copy)]
pub(super) struct Segments {
    a: [f32x4; 2],
    b: [f32x4; 2],
}

impl Segments {
    /// The segments of a list, four at a time.
    pub fn list(segments: &[(Point, Point)]) -> Vec<Self> {
        let four = |four: &[(Point, Point)]| {
            let lanes = |of: &dyn Fn(&(Point, Point)) -> f32| {
                let mut lanes = [GONE; LANES];
                for (lane, segment) in lanes.iter_mut().zip(four) {
                    *lane = of(segment);
                }
                f32x4::from(lanes)
            };
            Self {
                a: [lanes(&|(a, _)| a[0]), lanes(&|(a, _)| a[1])],
                b: [lanes(&|(_, b)| b[0]), lanes(&|(_, b)| b[1])],
            }
        };
        segments.chunks(LANES).map(four).collect()
    }

    /// Those of which something is left.
    pub fn iter(&self) -> impl Iterator<Item = (usize, Point, Point)> {
        let [ax, ay, bx, by] =
            [self.a[0], self.a[1], self.b[0], self.b[1]].map(|lanes| lanes.to_array());
        (0..LANES)
            .filter(move |&k| ax[k] < GONE)
            .map(move |k| (k, [ax[k], ay[k]], [bx[k], by[k]]))
    }

    /// How far the ends are out of {n·p ≤ b}; n need not be a unit vector.
    #[inline]
    pub fn values(&self, n: &Point, b: f32) -> [f32x4; 2] {
        [self.a, self.b].map(|[x, y]| x * n[0] + y * n[1] - b)
    }

    /// Leaves the parts in the half-plane {n·p ≤ b}; n need not be a unit vector. Returns whether
    /// that changes any.
    #[inline]
    pub fn clip(&mut self, n: &Point, b: f32) -> bool {
        let [ha, hb] = self.values(n, b);
        let (a_out, b_out) = (ha.simd_ge(f32x4::ZERO), hb.simd_ge(f32x4::ZERO));
        if !(a_out | b_out).any() {
            return false;
        }
        let t = ha / (ha - hb);
        let gone = a_out & b_out;
        for k in 0..2 {
            let (a, b) = (self.a[k], self.b[k]);
            let p = gone.select(f32x4::splat(GONE), a + (b - a) * t);
            self.a[k] = a_out.select(p, a);
            self.b[k] = b_out.select(p, b);
        }
        true
    }

    /// Whether nothing is left of any.
    #[inline]
    pub fn is_gone(&self) -> bool {
        self.a[0].simd_ge(f32x4::splat(GONE)).all()
    }

    /// The segments as M (p − c) has them, M = [[m₀, 0], [m₁, m₂]].
    #[inline]
    fn about(&self, centre: &Point, metric: &[f32; 3]) -> Self {
        let gone = self.a[0].simd_ge(f32x4::splat(GONE));
        let at = |[x, y]: [f32x4; 2]| {
            let (x, y) = (x - centre[0], y - centre[1]);
            [x * metric[0], x * metric[1] + y * metric[2]]
                .map(|x| gone.select(f32x4::splat(GONE), x))
        };
        Self {
            a: at(self.a),
            b: at(self.b),
        }
    }

    /// The points of each that are nearest to the origin.
    #[inline]
    fn nearest(&self) -> Nearest {
        let [ax, ay] = self.a;
        let (dx, dy) = (self.b[0] - ax, self.b[1] - ay);
        let square = (dx * dx + dy * dy).fast_max(f32x4::splat(1e-30));
        let t = -(ax * dx + ay * dy) / square;
        let t = t.fast_max(f32x4::ZERO).fast_min(f32x4::ONE);
        let (x, y) = (ax + dx * t, ay + dy * t);
        Nearest {
            point: [x, y],
            square: x * x + y * y,
        }
    }
}

/// Segments ahead of a growing piece, about its centre, each with its point nearest to that.
#[derive(Clone, Copy)]
pub(super) struct Ahead {
    segments: Segments,
    nearest: Nearest,
}

impl Ahead {
    /// The segments as M (p − c) has them, M = [[m₀, 0], [m₁, m₂]].
    #[inline]
    pub fn new(segments: &Segments, centre: &Point, metric: &[f32; 3]) -> Self {
        let segments = segments.about(centre, metric);
        Self {
            segments,
            nearest: segments.nearest(),
        }
    }

    /// The nearest points.
    #[inline]
    pub fn nearest(&self) -> &Nearest {
        &self.nearest
    }

    /// Leaves the parts in the half-plane {n·p ≤ b}; returns whether anything is left.
    #[inline]
    pub fn clip(&mut self, n: &Point, b: f32) -> bool {
        if self.segments.clip(n, b) {
            if self.segments.is_gone() {
                return false;
            }
            self.nearest = self.segments.nearest();
        }
        true
    }
}

/// Points of four segments, or of more the nearest.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    point: [f32x4; 2],
    square: f32x4,
}

impl Nearest {
    /// None.
    pub const NONE: Self = Self {
        point: [f32x4::ZERO; 2],
        square: f32x4::splat(GONE),
    };

    /// The nearer ones.
    #[inline]
    pub fn take(&mut self, other: &Self) {
        let nearer = other.square.simd_lt(self.square);
        for k in 0..2 {
            self.point[k] = nearer.select(other.point[k], self.point[k]);
        }
        self.square = other.square.fast_min(self.square);
    }

    /// The nearest of all, none where there are no segments.
    pub fn point(&self) -> Option<Point> {
        let square = self.square.to_array();
        let nearer = |best: usize, k: usize| if square[k] < square[best] { k } else { best };
        let best = (1..LANES).fold(0, nearer);
        let point = self.point.map(|x| x.to_array()[best]);
        (square[best] < GONE).then_some(point)
    }
}
