//! Additive moments of points, and the plane they give.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// A plane n·p = d; n is a unit vector either way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    pub normal: Vector3<f64>,
    pub offset: f64,
}

impl Plane {
    /// Signed distance of a point, m.
    pub fn height(&self, p: &Vector3<f64>) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// The least-squares plane of some points, with their variances along its axes, m².
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub plane: Plane,
    /// Along the normal.
    pub least: f64,
    /// Along the shorter axis of the points in the plane.
    pub middle: f64,
}

/// Sums over points of 1, p and p pᵀ, each counted with a weight.
///
/// Moments of disjoint sets of points add; that is all that growing and merging need.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Moments {
    pub n: f64,
    pub sum: Vector3<f64>,
    /// xx, yy, zz, xy, xz, yz.
    square: [f64; 6],
}

impl Moments {
    /// Adds one point.
    pub fn push(&mut self, p: &Vector3<f64>, weight: f64) {
        self.n += weight;
        self.sum += p * weight;
        let w = p * weight;
        let products = [
            w.x * p.x,
            w.y * p.y,
            w.z * p.z,
            w.x * p.y,
            w.x * p.z,
            w.y * p.z,
        ];
        for (to, product) in self.square.iter_mut().zip(products) {
            *to += product;
        }
    }

    /// Adds another set, each of its points counted `weight` times.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.n += weight * other.n;
        self.sum += other.sum * weight;
        for (to, from) in self.square.iter_mut().zip(other.square) {
            *to += weight * from;
        }
    }

    /// Area of a rectangle with the two larger variances of the points, m².
    pub fn area(&self) -> f64 {
        let scatter = self.scatter();
        let minor = |i: usize, j: usize| {
            scatter[(i, i)] * scatter[(j, j)] - scatter[(i, j)] * scatter[(i, j)]
        };
        // λ₁λ₂ + λ₁λ₃ + λ₂λ₃, of which the last is nearly all on a plane.
        let second = minor(0, 1) + minor(0, 2) + minor(1, 2);
        12.0 * second.max(0.0).sqrt()
    }

    /// Covariance of the points, m².
    fn scatter(&self) -> Matrix3<f64> {
        let mean = self.mean();
        let [xx, yy, zz, xy, xz, yz] = self.square.map(|s| s / self.n);
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - mean * mean.transpose()
    }

    /// The mean of the points.
    pub fn mean(&self) -> Vector3<f64> {
        self.sum / self.n
    }

    /// Mean square distance from a plane, m².
    pub fn mean_square(&self, plane: &Plane) -> f64 {
        let [xx, yy, zz, xy, xz, yz] = self.square;
        let (n, d) = (&plane.normal, plane.offset);
        let squares = n.x * n.x * xx + n.y * n.y * yy + n.z * n.z * zz;
        let products = n.x * n.y * xy + n.x * n.z * xz + n.y * n.z * yz;
        let whole = squares + 2.0 * products - 2.0 * d * n.dot(&self.sum) + d * d * self.n;
        (whole / self.n).max(0.0)
    }

    /// The least-squares plane; `None` for fewer than three points.
    pub fn fit(&self) -> Option<Fit> {
        if self.n < 3.0 {
            return None;
        }
        let mean = self.mean();
        let scatter = self.scatter();
        let (least, middle) = lower_eigenvalues(&scatter);
        let normal = null_direction(&(scatter - Matrix3::identity() * least)).or_else(|| {
            // Two directions alike: a line of points, or a ball.
            let eigen = SymmetricEigen::new(scatter);
            let least = eigen.eigenvalues.imin();
            eigen.eigenvectors.column(least).try_normalize(1e-12)
        })?;
        let offset = normal.dot(&mean);
        Some(Fit {
            plane: Plane { normal, offset },
            least: least.max(0.0),
            middle: middle.max(0.0),
        })
    }
}

/// The two smaller eigenvalues of a symmetric matrix, by the trigonometric solution of its cubic.
///
/// Source: [smith1961].
fn lower_eigenvalues(a: &Matrix3<f64>) -> (f64, f64) {
    let mean = a.trace() / 3.0;
    let off = a[(0, 1)].powi(2) + a[(0, 2)].powi(2) + a[(1, 2)].powi(2);
    let diagonal: f64 = (0..3).map(|i| (a[(i, i)] - mean).powi(2)).sum();
    let p = ((diagonal + 2.0 * off) / 6.0).sqrt();
    if p <= 0.0 {
        return (mean, mean);
    }
    let b = (a - Matrix3::identity() * mean) / p;
    let angle = (b.determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
    let largest = mean + 2.0 * p * angle.cos();
    let least = mean + 2.0 * p * (angle + std::f64::consts::TAU / 3.0).cos();
    (least, 3.0 * mean - largest - least)
}

/// The direction that a symmetric matrix of rank two maps to zero: the longest cross product of
/// its rows; `None` where its rank is less.
fn null_direction(a: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let rows = [0, 1, 2].map(|i| Vector3::new(a[(i, 0)], a[(i, 1)], a[(i, 2)]));
    let crosses = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| rows[i].cross(&rows[j]));
    let longest = crosses.into_iter().reduce(|a, b| {
        if b.norm_squared() > a.norm_squared() {
            b
        } else {
            a
        }
    })?;
    let scale = rows.iter().map(Vector3::norm_squared).fold(0.0, f64::max);
    (longest.norm() > 1e-6 * scale)
        .then(|| longest.try_normalize(0.0))
        .flatten()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_plane_is_that_of_an_eigen_solver(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..40),
            flat in 1e-4..0.5_f64, away in -20.0..20.0_f64,
        ) {
            let mut moments = Moments::default();
            let at = |p: &[f64; 3]| Vector3::new(p[0] + away, p[1] + 0.3 * p[2], flat * p[2] - away);
            points.iter().for_each(|p| moments.push(&at(p), 1.0));
            let fit = moments.fit().unwrap();
            let mean = moments.mean();
            let scatter: Matrix3<f64> = points.iter()
                .map(|p| (at(p) - mean) * (at(p) - mean).transpose()).sum::<Matrix3<f64>>()
                / points.len() as f64;
            let mut values: Vec<f64> = scatter.symmetric_eigenvalues().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            prop_assert!((fit.least - values[0]).abs() < 1e-9);
            prop_assert!((fit.middle - values[1]).abs() < 1e-9);
            prop_assert!((moments.mean_square(&fit.plane) - values[0]).abs() < 1e-9);
        }
    }

    #[test]
    fn sums_of_parts_are_the_sum() {
        let points = [[0.0, 1.0, 2.0], [3.0, -1.0, 0.5], [0.2, 0.1, 0.9]].map(Vector3::from);
        let (mut all, mut a, mut b) = <(Moments, Moments, Moments)>::default();
        for (i, p) in points.iter().enumerate() {
            all.push(p, 1.0);
            if i == 0 { &mut a } else { &mut b }.push(p, 1.0);
        }
        a.add(&b, 1.0);
        assert!((a.mean() - all.mean()).norm() < 1e-15 && a.n == all.n);
        let (a, all) = (a.fit().unwrap(), all.fit().unwrap());
        assert!((a.least - all.least).abs() < 1e-12 && (a.middle - all.middle).abs() < 1e-12);
    }
}
