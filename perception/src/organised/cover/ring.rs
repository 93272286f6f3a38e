//! Convex polygons that are only compared.

use nalgebra::{Matrix2, Point2, SymmetricEigen, Vector2};
use surfaces::HalfPlane;

/// Corners of a convex polygon, counter-clockwise: [`surfaces::ConvexPolygon`] without its checks, for the
/// many polygons that are only compared.
#[derive(Clone)]
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

    /// The part in the half-plane {n·p ≤ b}.
    pub fn clip(&self, cut: &HalfPlane) -> Self {
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for (a, c) in self.edges() {
            let (ha, hc) = (cut.value(a), cut.value(c));
            if ha <= 0.0 {
                kept.push(*a);
            }
            if (ha < 0.0 && hc > 0.0) || (ha > 0.0 && hc < 0.0) {
                kept.push(a + (c - a) * (ha / (ha - hc)));
            }
        }
        Self(kept)
    }

    /// Centroid, and the matrix that makes the second moments those of a circle.
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
        let eigen = SymmetricEigen::new(second / area - mean * mean.transpose());
        let scale = eigen.eigenvalues.map(|l| 1.0 / l.sqrt());
        let metric = Matrix2::from_diagonal(&scale) * eigen.eigenvectors.transpose();
        metric
            .iter()
            .all(|x| x.is_finite())
            .then_some((o + mean, metric))
    }
}
