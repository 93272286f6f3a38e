//! Convex polygons that are only compared.

use nalgebra::{Point2, Vector2};
use surfaces::HalfPlane;

use super::segments::{Cut, Point};

/// Corners of a convex polygon, counter-clockwise: [`surfaces::ConvexPolygon`] without its checks, for the
/// many polygons that are only compared.
#[derive(Clone, Default)]
pub(in crate::organised) struct Ring(pub Vec<Point2<f64>>);

impl Ring {
    /// Its sides, each from a corner to the next.
    pub fn edges(&self) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
        let next = self.0[1.min(self.0.len())..].iter().chain(self.0.first());
        self.0.iter().zip(next)
    }

    /// The least and the largest coordinates.
    pub fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let first = self.0.first().copied().unwrap_or(Point2::origin());
        self.0
            .iter()
            .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        let Some(o) = self.0.first() else { return 0.0 };
        self.edges()
            .map(|(a, b)| (a - o).perp(&(b - o)))
            .sum::<f64>()
            / 2.0
    }

    /// The smallest convex ring around points, which are sorted; two corners if they lie on a line.
    ///
    /// Source: Andrew's monotone chain.
    pub fn hull(&mut self, points: &mut [Point2<f64>]) {
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        self.0.clear();
        self.0.reserve(points.len() + 1);
        for back in [false, true] {
            let start = self.0.len();
            let mut push = |p: &Point2<f64>| {
                while let [.., a, b] = &self.0[start..] {
                    if (b - a).perp(&(p - b)) > 0.0 {
                        break;
                    }
                    self.0.pop();
                }
                self.0.push(*p);
            };
            if back {
                points.iter().rev().for_each(&mut push);
            } else {
                points.iter().for_each(&mut push);
            }
            // The last point of a chain is the first of the other one.
            self.0.pop();
        }
    }

    /// What cuts leave that are about `origin`.
    pub(super) fn without(mut self, cuts: &[Cut], origin: &Point2<f64>) -> Self {
        let mut spare = Self(Vec::with_capacity(self.0.len() + cuts.len()));
        for cut in cuts {
            let n = Vector2::from(cut.n.map(f64::from));
            let b = f64::from(cut.b) + n.dot(&origin.coords);
            self.clip(&HalfPlane { n, b }, &mut spare);
        }
        self
    }

    /// The half-planes along its sides, `near` the region's middle.
    pub(super) fn sides(&self, near: impl Fn(&Point2<f64>) -> Point) -> Vec<Cut> {
        self.edges()
            .filter_map(|(a, b)| Cut::left_of(&near(a), &near(b)))
            .collect()
    }

    /// Whether a circle of this diameter fits in, m.
    pub fn is_wide(&self, width_m: f64) -> bool {
        // That of the largest circle is between 2 A/L and 4 A/L.
        let around: f64 = self.edges().map(|(a, b)| (b - a).norm()).sum();
        let ratio = 2.0 * self.area() / around;
        if ratio >= width_m {
            return true;
        }
        if 2.0 * ratio < width_m {
            return false;
        }
        let mut inner = self.clone();
        let mut spare = Self(Vec::with_capacity(2 * self.0.len()));
        for (a, b) in self.edges().filter(|(a, b)| a != b) {
            let mut side = HalfPlane::left_of(a, b);
            side.b -= 0.5 * width_m;
            inner.clip(&side, &mut spare);
        }
        inner.area() > 0.0
    }

    /// Leaves the part in the half-plane {n·p ≤ b}; `spare` is overwritten.
    fn clip(&mut self, cut: &HalfPlane, spare: &mut Self) {
        spare.0.clear();
        let Some(mut a) = self.0.first() else { return };
        let mut ha = cut.value(a);
        for c in self.0[1..].iter().chain(self.0.first()) {
            let hc = cut.value(c);
            if ha <= 0.0 {
                spare.0.push(*a);
            }
            if (ha < 0.0 && hc > 0.0) || (ha > 0.0 && hc < 0.0) {
                spare.0.push(a + (c - a) * (ha / (ha - hc)));
            }
            (a, ha) = (c, hc);
        }
        std::mem::swap(self, spare);
    }

    /// Centroid; the first corner where there is no area.
    pub fn centroid(&self) -> Point2<f64> {
        let Some(o) = self.0.first() else {
            return Point2::origin();
        };
        let (mut double, mut first) = (0.0, Vector2::zeros());
        for (a, b) in self.edges() {
            let (a, b) = (a - o, b - o);
            let part = a.perp(&b);
            double += part;
            first += (a + b) * part;
        }
        if double > 0.0 {
            o + first / (3.0 * double)
        } else {
            *o
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_is_that_of_the_largest_circle() {
        let ring = |corners: &[[f64; 2]]| Ring(corners.iter().map(|&c| Point2::from(c)).collect());
        // The circles in all have a diameter of 2.
        let square = ring(&[[0., 0.], [2., 0.], [2., 2.], [0., 2.]]);
        let board = ring(&[[0., 0.], [90., 0.], [90., 2.], [0., 2.]]);
        let triangle = ring(&[[0., 0.], [3., 0.], [0., 4.]]);
        for shape in [square, board, triangle] {
            assert!(shape.is_wide(1.0) && shape.is_wide(1.99));
            assert!(!shape.is_wide(2.01) && !shape.is_wide(5.0));
        }
    }
}
