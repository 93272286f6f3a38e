//! Segments that half-planes cut, eight side by side.

use wide::bytemuck::cast;
use wide::{f32x4, f32x8};

use super::super::words::Ones;

/// How many are side by side.
pub(super) const LANES: usize = 8;

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
    a: [f32x8; 2],
    b: [f32x8; 2],
}

impl Segments {
    /// The segments of a list, eight at a time.
    pub fn list(segments: &[(Point, Point)]) -> Vec<Self> {
        let group = |few: &[(Point, Point)]| {
            let lanes = |of: &dyn Fn(&(Point, Point)) -> f32| {
                let mut lanes = [GONE; LANES];
                for (lane, segment) in lanes.iter_mut().zip(few) {
                    *lane = of(segment);
                }
                f32x8::from(lanes)
            };
            Self {
                a: [lanes(&|(a, _)| a[0]), lanes(&|(a, _)| a[1])],
                b: [lanes(&|(_, b)| b[0]), lanes(&|(_, b)| b[1])],
            }
        };
        segments.chunks(LANES).map(group).collect()
    }

    /// Those of some, one bit each, of which something is left.
    pub fn of(&self, some: u32) -> impl Iterator<Item = (usize, Point, Point)> {
        let [ax, ay, bx, by] =
            [self.a[0], self.a[1], self.b[0], self.b[1]].map(|lanes| lanes.to_array());
        let left = self.a[0].simd_lt(f32x8::splat(GONE)).to_bitmask();
        Ones((left & some).into()).map(move |k| (k, [ax[k], ay[k]], [bx[k], by[k]]))
    }

    /// How far the ends are out of {n·p ≤ b}; n need not be a unit vector.
    #[inline]
    pub fn values(&self, n: &Point, b: f32) -> [f32x8; 2] {
        [self.a, self.b].map(|[x, y]| x * n[0] + y * n[1] - b)
    }

    /// Leaves the parts in the half-plane {n·p ≤ b}; n need not be a unit vector.
    #[inline]
    pub fn clip(&mut self, n: &Point, b: f32) {
        let [ha, hb] = self.values(n, b);
        let (a_out, b_out) = (ha.simd_ge(f32x8::ZERO), hb.simd_ge(f32x8::ZERO));
        if !(a_out | b_out).any() {
            return;
        }
        let t = ha / (ha - hb);
        let gone = a_out & b_out;
        for k in 0..2 {
            let (a, b) = (self.a[k], self.b[k]);
            let p = gone.select(f32x8::splat(GONE), a + (b - a) * t);
            self.a[k] = a_out.select(p, a);
            self.b[k] = b_out.select(p, b);
        }
    }

    /// Whether nothing is left of any.
    #[inline]
    pub fn is_gone(&self) -> bool {
        self.a[0].simd_ge(f32x8::splat(GONE)).all()
    }
}

/// Segments ahead of a growing piece, about its centre.
#[derive(Default)]
pub(super) struct Ahead {
    groups: Vec<Group>,
    /// The least squares of distances from the centre.
    least: f32x8,
}

impl Ahead {
    /// The segments as M (p − c) has them, M = [[m₀, 0], [m₁, m₂]], in place of those before.
    pub fn fill(&mut self, segments: &[Segments], centre: &Point, metric: &[f32; 3]) {
        let mut least = f32x8::splat(GONE);
        self.groups.clear();
        self.groups.extend(segments.iter().map(|segments| {
            let group = Group::new(segments, centre, metric);
            least = least.fast_min(group.square);
            group
        }));
        self.least = least;
    }

    /// Leaves the parts in the half-plane {n·p ≤ b}; n need not be a unit vector.
    pub fn clip(&mut self, n: &Point, b: f32) {
        let gone = f32x8::splat(GONE);
        let mut least = gone;
        let mut i = 0;
        while let Some(group) = self.groups.get_mut(i) {
            group.clip(n, b);
            if group.square.simd_lt(gone).any() {
                least = least.fast_min(group.square);
                i += 1;
            } else {
                self.groups.swap_remove(i);
            }
        }
        self.least = least;
    }

    /// The point that is nearest to the centre, none where nothing is left.
    pub fn nearest(&self) -> Option<Point> {
        let least = least(self.least);
        let lanes = |group: &Group| group.square.simd_eq(f32x8::splat(least)).to_bitmask();
        let group = self.groups.iter().find(|group| lanes(group) != 0);
        let group = group.filter(|_| least < GONE)?;
        let k = lanes(group).trailing_zeros() as usize;
        Some(group.nearest().map(|lanes| lanes.as_array()[k]))
    }
}

/// The least of all lanes.
#[inline]
pub(super) fn least(lanes: f32x8) -> f32 {
    let [a, b]: [f32x4; 2] = cast(lanes);
    let [a, b, c, d] = a.fast_min(b).to_array();
    a.min(b).min(c.min(d))
}

/// Segments side by side, what cuts leave of each, and how near that is.
struct Group {
    /// One end, and the way to it from the other one: a − t · back, 0 ≤ t ≤ 1.
    a: [f32x8; 2],
    back: [f32x8; 2],
    /// Where the lines are nearest to the centre.
    foot: f32x8,
    /// Where what is left of them begins and ends.
    from: f32x8,
    to: f32x8,
    /// Square of its distance from the centre.
    square: f32x8,
}

impl Group {
    #[inline]
    fn new(segments: &Segments, centre: &Point, metric: &[f32; 3]) -> Self {
        let at = |[x, y]: [f32x8; 2]| {
            let (x, y) = (x - centre[0], y - centre[1]);
            [x * metric[0], x * metric[1] + y * metric[2]]
        };
        let (a, b) = (at(segments.a), at(segments.b));
        let back = [a[0] - b[0], a[1] - b[1]];
        let square = (back[0] * back[0] + back[1] * back[1]).fast_max(f32x8::splat(1e-30));
        let mut group = Self {
            a,
            back,
            foot: (a[0] * back[0] + a[1] * back[1]) / square,
            from: f32x8::ZERO,
            to: f32x8::ONE,
            square,
        };
        group.measure();
        group
    }

    /// Leaves the parts in the half-plane {n·p ≤ b}.
    ///
    /// Source: [liang1984], a line after another.
    #[inline]
    fn clip(&mut self, n: &Point, b: f32) {
        let value = |[x, y]: [f32x8; 2]| x * n[0] + y * n[1];
        let (ha, along) = (value(self.a) - b, value(self.back));
        let a_out = ha.simd_gt(f32x8::ZERO);
        let b_out = (ha - along).simd_gt(f32x8::ZERO);
        if (a_out | b_out).any() {
            let t = ha / along;
            self.from = self.from.fast_max(a_out & t);
            self.to = self.to.fast_min(b_out.select(t, f32x8::ONE));
            self.measure();
        }
    }

    /// Finds how near what is left is.
    #[inline]
    fn measure(&mut self) {
        let [x, y] = self.nearest();
        let gone = self.from.simd_ge(self.to);
        self.square = gone.select(f32x8::splat(GONE), x * x + y * y);
    }

    /// The nearest points of what is left.
    #[inline]
    fn nearest(&self) -> [f32x8; 2] {
        let t = self.foot.fast_max(self.from).fast_min(self.to);
        [0, 1].map(|k| self.a[k] - self.back[k] * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_that_of_what_cuts_leave() {
        // Segments and cuts of all kinds, from a congruential generator.
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
        };
        let mut left = 0;
        for _ in 0..50 {
            let segments: [(Point, Point); 7] =
                std::array::from_fn(|_| ([random(), random()], [random(), random()]));
            let centre = [random(), random()];
            let metric = [1.5 + random(), random(), 1.5 + random()];
            let [m0, m1, m2] = metric;
            let about = |p: [f32; 2]| {
                let (x, y) = (p[0] - centre[0], p[1] - centre[1]);
                [m0 * x, m1 * x + m2 * y]
            };
            let mut ahead = Ahead::default();
            ahead.fill(&Segments::list(&segments), &centre, &metric);
            let mut cuts: Vec<(Point, f32)> = Vec::new();
            for _ in 0..4 {
                // A dense sample of the segments.
                let samples = segments.iter().flat_map(|(a, b)| {
                    let at = |t: f32| [0, 1].map(|k| a[k] + (b[k] - a[k]) * t);
                    (0..=1000).map(move |i| about(at(i as f32 / 1000.0)))
                });
                let kept = samples.filter(|p| {
                    let value = |(n, b): &(Point, f32)| n[0] * p[0] + n[1] * p[1] - b;
                    cuts.iter().all(|cut| value(cut) <= 0.0)
                });
                let nearest = kept.map(|p| p[0].hypot(p[1])).reduce(f32::min);
                match (ahead.nearest(), nearest) {
                    (Some(p), Some(expected)) => {
                        left += 1;
                        // Samples are up to 3.5 · √8 / 1000 apart.
                        let off = p[0].hypot(p[1]) - expected;
                        assert!((-0.01..1e-4).contains(&off), "{p:?} {expected}");
                    }
                    // Samples may miss what is left of a segment, but not find what is gone.
                    (found, expected) => assert!(expected.is_none(), "{found:?} {expected:?}"),
                }
                let cut = ([random(), random()], random());
                ahead.clip(&cut.0, cut.1);
                cuts.push(cut);
            }
        }
        assert!(left > 100, "{left}");
    }
}
