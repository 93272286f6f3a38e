//! How well a plane is known, from where its points lie.

use nalgebra::{Matrix3, Vector2};

/// Covariance of (rotation about x, rotation about y, offset along z) of a plane, rad, rad, m, at a place that is
/// `to` from the middle of its points; x and y are tangents.
///
///   Σ = (Σ g gᵀ/σ_n²)⁻¹ + bounded (Σ g gᵀ/s²)⁻¹,  g = (y, −x, 1) from the middle
///
/// with the noise σ_n of points whose errors are independent (`white`), and the slowly varying error s of its waves
/// (`slow`). The second term is bounded by `limits` at the middle, for planes smaller than a wave: there all of it is an
/// offset. `None` where the points do not determine the plane.
pub(crate) fn covariance(
    white: &Matrix3<f64>,
    slow: &Matrix3<f64>,
    limits: [f64; 3],
    to: &Vector2<f64>,
) -> Option<[[f64; 3]; 3]> {
    let mut slow = slow.try_inverse()?;
    // Rows and columns are scaled, which keeps the matrix positive.
    for (i, limit) in limits.into_iter().enumerate() {
        let sigma = slow[(i, i)].max(0.0).sqrt();
        if sigma > limit && sigma > 0.0 {
            slow.row_mut(i).scale_mut(limit / sigma);
            slow.column_mut(i).scale_mut(limit / sigma);
        }
    }
    let sigma = white.try_inverse()? + slow;
    let symmetric = (sigma + sigma.transpose()) * 0.5;
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| symmetric[(i, j)]));
    let finite = rows.iter().flatten().all(|x| x.is_finite());
    finite.then(|| surfaces::covariance::carried(&rows, to))
}
