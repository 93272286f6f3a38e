//! Convex polygons that are only compared.

use nalgebra::{Matrix2, Point2, Vector2};
use surfaces::HalfPlane;

/// Corners of a convex polygon, counter-clockwise: [`surfaces::ConvexPolygon`] without its checks, for the
/// many polygons that are only compared.
#[derive(Clone, Default)]
pub(super) struct Ring(pub Vec<Point2<f64>>);

impl Ring {
    pub fn edges(&self) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
        let next = self.0[1.min(self.0.len())..].iter().chain(self.0.first());
        self.0.iter().zip(next)
    }

    pub fn area(&self) -> f64 {
        let Some(o) = self.0.first() else { return 0.0 };
        self.edges()
            .map(|(a, b)| (a - o).perp(&(b - o)))
            .sum::<f64>()
            / 2.0
    }

    pub fn contains(&self, p: &Point2<f64>) -> bool {
        self.edges().all(|(a, b)| (b - a).perp(&(p - a)) >= 0.0)
    }

    /// Becomes what another one is.
    pub fn copy(&mut self, other: &Self) {
        self.0.clone_from(&other.0);
    }

    /// The smallest convex ring around points, which are sorted; two corners if they lie on a line.
    ///
    /// Source: Andrew's monotone chain.
    pub fn hull(&mut self, points: &mut [Point2<f64>]) {
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        self.0.clear();
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

    /// Leaves the part in the half-plane {n·p ≤ b}; `spare` is overwritten.
    pub fn clip(&mut self, cut: &HalfPlane, spare: &mut Self) {
        spare.0.clear();
        self.clipped(cut, |p| spare.0.push(p));
        std::mem::swap(self, spare);
    }

    /// Area of the part in the half-plane {n·p ≤ b}.
    pub fn area_within(&self, cut: &HalfPlane) -> f64 {
        // A fan of triangles from the first corner.
        let (mut origin, mut last, mut double) = (None, Vector2::zeros(), 0.0);
        self.clipped(cut, |p| {
            let here = p - *origin.get_or_insert(p);
            double += last.perp(&here);
            last = here;
        });
        double / 2.0
    }

    /// Calls `with` for the corners of the part in the half-plane.
    #[inline]
    fn clipped(&self, cut: &HalfPlane, mut with: impl FnMut(Point2<f64>)) {
        let Some(mut a) = self.0.first() else { return };
        let mut ha = cut.value(a);
        for c in self.0[1..].iter().chain(self.0.first()) {
            let hc = cut.value(c);
            if ha <= 0.0 {
                with(*a);
            }
            if (ha < 0.0 && hc > 0.0) || (ha > 0.0 && hc < 0.0) {
                with(a + (c - a) * (ha / (ha - hc)));
            }
            (a, ha) = (c, hc);
        }
    }

    /// Centroid, and a matrix that makes the second moments those of a circle.
    pub fn ellipse(&self) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let o = self.0.first()?;
        let (mut area, mut first, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
        for (a, b) in self.edges() {
            // ∫ 1, p and p pᵀ over the triangle (o, a, b), about o.
            let (a, b) = (a - o, b - o);
            let (sum, double) = (a + b, a.perp(&b));
            area += double / 2.0;
            first += sum * (double / 6.0);
            second +=
                (a * a.transpose() + b * b.transpose() + sum * sum.transpose()) * (double / 24.0);
        }
        let mean: Vector2<f64> = first / area;
        // Of Σ = L Lᵀ, L⁻¹: which of the matrices M with Mᵀ M = Σ⁻¹ it is turns nothing.
        let sigma = second / area - mean * mean.transpose();
        let l = sigma[(0, 0)].sqrt();
        let m = sigma[(0, 1)] / l;
        let k = (sigma[(1, 1)] - m * m).sqrt();
        let metric = Matrix2::new(1.0 / l, 0.0, -m / (l * k), 1.0 / k);
        metric
            .iter()
            .all(|x| x.is_finite())
            .then_some((o + mean, metric))
    }
}
