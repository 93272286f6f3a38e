//! How well a plane is known, from where its points lie.

use nalgebra::{Matrix3, Vector2};

/// Covariance of (rotation about x, rotation about y, offset along z) of a plane, rad, rad, m, at a place that is
/// `to` from the middle of its points; x and y are tangents.
///
///   Σ = (Σ g gᵀ/σ_n²)⁻¹ + D (Σ g gᵀ/s²)⁻¹ D,  D² = 1/(1 + variance/limit²),  g = (y, −x, 1) from the middle
///
/// with the noise σ_n of points whose errors are independent (`white`), and the slowly varying error s of its waves
/// (`slow`). The second term is that of a plane much larger than a wave; `limits` are the standard deviations at the
/// middle of one much smaller, where all of it is an offset. Between them the two are combined as 1/σ² + 1/limit²: the
/// mean of a wave over a square of 4 of its scales has .41 of its variance, and .44 this way, where the first alone
/// says .79. `None` where the points do not determine the plane.
pub(crate) fn covariance(
    white: &Matrix3<f64>,
    slow: &Matrix3<f64>,
    limits: [f64; 3],
    to: &Vector2<f64>,
) -> Option<[[f64; 3]; 3]> {
    let mut slow = slow.try_inverse()?;
    // Rows and columns are scaled, which keeps the matrix positive.
    for (i, limit) in limits.into_iter().enumerate() {
        let variance = slow[(i, i)].max(0.0);
        if variance > 0.0 {
            let scale = 1.0 / (1.0 + variance / (limit * limit)).sqrt();
            slow.row_mut(i).scale_mut(scale);
            slow.column_mut(i).scale_mut(scale);
        }
    }
    let sigma = white.try_inverse()? + slow;
    let symmetric = (sigma + sigma.transpose()) * 0.5;
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| symmetric[(i, j)]));
    let finite = rows.iter().flatten().all(|x| x.is_finite());
    finite.then(|| surfaces::covariance::carried(&rows, to))
}
