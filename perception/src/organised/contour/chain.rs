//! How far points in a row are off a chord, four at a time.

use std::ops::Range;

use nalgebra::{Point2, Vector2};
use wide::f64x4;

/// How far a ring may leave the traced one.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// 1 over the squares of how far it may lie outside, and inside, 1/px².
    outside: f64,
    inside: f64,
}

impl Limits {
    pub fn new(notch_px: f64, bulge_px: f64) -> Self {
        let inverse = |px: f64| 1.0 / (px * px).max(1e-9);
        Self {
            outside: inverse(notch_px),
            inside: inverse(bulge_px),
        }
    }
}

/// A segment from which distances are taken (not its line: a ring may double back).
pub(super) struct Chord {
    from: Point2<f64>,
    along: Vector2<f64>,
    /// 1 / ‖along‖², or 0 for a point.
    inverse: f64,
    limits: Limits,
}

impl Chord {
    pub fn new(a: &Point2<f64>, b: &Point2<f64>, limits: Limits) -> Self {
        let along = b - a;
        let square = along.norm_squared();
        Self {
            from: *a,
            along,
            inverse: if square > 0.0 { 1.0 / square } else { 0.0 },
            limits,
        }
    }

    /// Squares of how far points are off it, in units of what is allowed there.
    #[inline(always)]
    fn excesses(&self, x: f64x4, y: f64x4) -> f64x4 {
        let (x, y) = (x - self.from.x, y - self.from.y);
        let (ahead, up) = (f64x4::splat(self.along.x), f64x4::splat(self.along.y));
        let t = (x * ahead + y * up) * self.inverse;
        let t = t.fast_max(f64x4::ZERO).fast_min(f64x4::ONE);
        // The face is on the left of its rings: there the chord lies outside of it.
        let left = (ahead * y - up * x).simd_gt(f64x4::ZERO);
        let [outside, inside] = [self.limits.outside, self.limits.inside].map(f64x4::splat);
        let (x, y) = (x - ahead * t, y - up * t);
        (x * x + y * y) * left.select(outside, inside)
    }
}

/// Points in a row.
pub(super) struct Chain {
    /// Their coordinates, and three more: from any of them on there are four.
    x: Vec<f64>,
    y: Vec<f64>,
    pub count: usize,
}

impl Chain {
    pub fn new(points: &[Point2<f64>]) -> Self {
        let padded = |of: fn(&Point2<f64>) -> f64| {
            let mut all = Vec::with_capacity(points.len() + 3);
            all.extend(points.iter().map(of));
            all.resize(points.len() + 3, 0.0);
            all
        };
        Self {
            x: padded(|p| p.x),
            y: padded(|p| p.y),
            count: points.len(),
        }
    }

    /// Its `i`th point.
    pub fn at(&self, i: usize) -> Point2<f64> {
        Point2::new(self.x[i], self.y[i])
    }

    /// The first of those points of a range, which is in the chain, that are farthest off a chord in units
    /// of what is allowed there; none where all are within that.
    #[inline]
    pub fn worst(&self, chord: &Chord, range: Range<usize>) -> Option<usize> {
        let (mut most, mut which) = (f64x4::ONE, f64x4::ZERO);
        self.for_each(chord, range, |places, excesses| {
            let more = excesses.simd_gt(most);
            most = more.select(excesses, most);
            which = more.select(places, which);
        });
        let lanes = most.to_array().into_iter().zip(which.to_array());
        let (most, which) = lanes.fold((1.0, 0.0), |worst: (f64, f64), (most, which)| {
            if most > worst.0 || most == worst.0 && which < worst.1 {
                (most, which)
            } else {
                worst
            }
        });
        (most > 1.0).then_some(which as usize)
    }

    /// How far the farthest of the points of a range, which is in the chain, is off a chord, squared, in
    /// units of what is allowed.
    #[inline]
    pub fn farthest(&self, chord: &Chord, range: Range<usize>) -> f64 {
        let mut most = f64x4::ZERO;
        self.for_each(chord, range, |_, excesses| most = most.fast_max(excesses));
        let [a, b, c, d] = most.to_array();
        a.max(b).max(c.max(d))
    }

    /// Calls `with` for four points of a range after another: their places, and how far they are off a
    /// chord; 0 where a place is not in the range.
    #[inline(always)]
    fn for_each(&self, chord: &Chord, range: Range<usize>, mut with: impl FnMut(f64x4, f64x4)) {
        let end = f64x4::splat(range.end as f64);
        let first = range.start as f64;
        let mut places = f64x4::from([first, first + 1.0, first + 2.0, first + 3.0]);
        let [xs, ys] = [&self.x, &self.y].map(|all| &all[range.start..range.end + 3]);
        for (x, y) in xs.as_chunks().0.iter().zip(ys.as_chunks().0) {
            let excesses = chord.excesses(f64x4::from(*x), f64x4::from(*y));
            with(places, excesses & places.simd_lt(end));
            places += 4.0;
        }
    }
}
