//! A plane in the sensor's frame, and how far a measured point may be from it.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// The points p with n·p + d = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal n, toward the sensor.
    pub normal: Vector3<f64>,
    /// d, m: the sensor's distance from the plane, not negative.
    pub offset_m: f64,
}

impl Plane {
    /// The plane through three points; `None` for points in a line or nearer than `least_m` to one.
    pub fn through(
        a: &Vector3<f64>,
        b: &Vector3<f64>,
        c: &Vector3<f64>,
        least_m: f64,
    ) -> Option<Self> {
        let (u, v) = (b - a, c - a);
        let cross = u.cross(&v);
        let longest = u.norm().max(v.norm()).max((c - b).norm());
        // The triangle's height over its longest side.
        (cross.norm() > least_m * longest).then(|| Self::new(cross.normalize(), a))
    }

    /// The plane with a unit normal through a point, turned toward the sensor.
    pub fn new(normal: Vector3<f64>, point: &Vector3<f64>) -> Self {
        let offset = -normal.dot(point);
        if offset < 0.0 {
            Self {
                normal: -normal,
                offset_m: -offset,
            }
        } else {
            Self {
                normal,
                offset_m: offset,
            }
        }
    }

    /// The plane of least squared distances from points, from their moments.
    pub fn fitted(points: impl Iterator<Item = Vector3<f64>> + Clone) -> Option<Self> {
        let n = points.clone().count();
        if n < 3 {
            return None;
        }
        let mean = points.clone().sum::<Vector3<f64>>() / n as f64;
        let mut scatter = Matrix3::zeros();
        for p in points {
            let d = p - mean;
            scatter += d * d.transpose();
        }
        let eigen = SymmetricEigen::new(scatter);
        let normal = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imin())
            .into_owned();
        normal
            .iter()
            .all(|c| c.is_finite())
            .then(|| Self::new(normal, &mean))
    }

    /// Signed distance of a point, positive on the sensor's side, m.
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        self.normal.dot(p) + self.offset_m
    }

    /// Two unit tangents t₁, t₂ with t₁ × t₂ = n.
    pub fn tangents(&self) -> [Vector3<f64>; 2] {
        let n = self.normal;
        let axis = if n.x.abs() < 0.6 {
            Vector3::x()
        } else {
            Vector3::y()
        };
        let first = (axis - n * n.dot(&axis)).normalize();
        [first, n.cross(&first)]
    }
}

/// Standard deviation of one range, m: what a VLP-16 shows on planes; its sheet allows 30 mm in all.
const RANGE_SIGMA_M: f64 = 0.008;
/// Standard deviation of a ring's constant range error where it is not calibrated, m.
pub(super) const RING_BIAS_SIGMA_M: f64 = 0.010;
/// Standard deviation of a beam's direction, rad.
const ANGLE_SIGMA_RAD: f64 = 0.0004;

/// Variance of a point's distance from a plane but for its ring's bias, m²: the range's along the ray, the
/// direction's across.
///
///   σ² = (n·u)² σ_r² + (1 − (n·u)²) (r σ_a)²
pub(super) fn variance(n_u: f64, range_m: f64) -> f64 {
    let along = n_u * n_u;
    along * RANGE_SIGMA_M.powi(2)
        + (1.0 - along).max(0.0) * (range_m * ANGLE_SIGMA_RAD).powi(2)
        + 1e-8
}
