//! Axis-parallel boxes around points, and what is in them.

use nalgebra::Point3;

/// The box around some points.
pub(crate) struct Bounds {
    pub low: Point3<f64>,
    pub high: Point3<f64>,
}

impl Bounds {
    pub fn new(points: &[Point3<f64>]) -> Self {
        let fold = |pick: fn(f64, f64) -> f64, start: f64| {
            let init = Point3::from([start; 3]);
            points
                .iter()
                .fold(init, |a, b| Point3::from(a.coords.zip_map(&b.coords, pick)))
        };
        Self {
            low: fold(f64::min, f64::INFINITY),
            high: fold(f64::max, f64::NEG_INFINITY),
        }
    }

    /// Whether two boxes have a point in common, up to a millimetre.
    pub fn overlaps(&self, other: &Self) -> bool {
        let apart =
            |i: usize| self.low[i] > other.high[i] + 1e-3 || other.low[i] > self.high[i] + 1e-3;
        !(0..3).any(apart)
    }
}

/// The part of a convex ring in space where a linear function is not positive.
pub(crate) fn clip(ring: &[Point3<f64>], value: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (value_a, value_b) = (value(a), value(b));
        if value_a <= 0.0 {
            kept.push(*a);
        }
        if (value_a < 0.0 && value_b > 0.0) || (value_a > 0.0 && value_b < 0.0) {
            kept.push(a + (b - a) * (value_a / (value_a - value_b)));
        }
    }
    kept
}
