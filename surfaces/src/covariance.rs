//! What the covariance of a fitted plane says of its points, and in other frames.
//!
//! The plane's errors (θ_x, θ_y, z) are small rotations about x_S and y_S and an offset along
//! z_S; they move the plane's point (x, y) along the normal by
//!
//!   δ(x, y) = θ_x y − θ_y x + z = g · (θ_x, θ_y, z),    g = (y, −x, 1),    σ² = gᵀ Σ g.

use nalgebra::{Isometry3, Matrix3, Point2, Vector3};

/// Standard deviation along the normal at the plane's point `p`, m.
///
/// `covariance` of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
pub fn sigma_at(covariance: &[[f64; 3]; 3], p: &Point2<f64>) -> f64 {
    let sigma = Matrix3::from_fn(|i, j| covariance[i][j]);
    let g = Vector3::new(p.y, -p.x, 1.0);
    // Rounding can take the form below zero where the plane is known exactly.
    g.dot(&(sigma * g)).max(0.0).sqrt()
}

/// The covariance of the same plane in a frame whose origin is at `p` of the first, the axes alike.
pub fn carried(covariance: &[[f64; 3]; 3], p: &nalgebra::Vector2<f64>) -> [[f64; 3]; 3] {
    let sigma = Matrix3::from_fn(|i, j| covariance[i][j]);
    let carry = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, p.y, -p.x, 1.0);
    rows(&(carry * sigma * carry.transpose()))
}

/// The rows of a covariance, made symmetric to the last bit.
pub(crate) fn rows(sigma: &Matrix3<f64>) -> [[f64; 3]; 3] {
    let mean = |i, j| 0.5 * (sigma[(i, j)] + sigma[(j, i)]);
    std::array::from_fn(|i| std::array::from_fn(|j| mean(i, j)))
}

/// A plane as it looks from a frame C near it: (θ_x, θ_y, z) that would bring C's plane z = 0 onto
/// it, and their covariance. `None` where the plane leans by more than 60° in C.
///
///   Σ_C = T Σ_S Tᵀ,   T: the rotations turn with the axes, z is taken at C's origin
///
/// Frames: S on the plane with the covariance `sigma` of (rotation about x_S, about y_S, offset along
/// z_S): rad, rad, m.
pub fn plane_in(
    X_CS: &Isometry3<f64>,
    sigma: &Matrix3<f64>,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let n = X_CS.rotation * Vector3::z();
    if n.z < 0.5 {
        return None;
    }
    let origin = X_CS.translation.vector;
    let x = Vector3::new(-n.y / n.z, n.x / n.z, n.dot(&origin) / n.z);
    let (ex, ey) = (X_CS.rotation * Vector3::x(), X_CS.rotation * Vector3::y());
    let to_C = X_CS.rotation.inverse() * -origin;
    let carry = Matrix3::new(
        ex.x, ey.x, 0.0, //
        ex.y, ey.y, 0.0, //
        to_C.y, -to_C.x, 1.0,
    );
    let carried = carry * sigma * carry.transpose();
    Some((x, (carried + carried.transpose()) * 0.5))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A covariance of rank one is one error: carried to another frame of the plane it is the
        /// error that the moved plane has there.
        #[test]
        fn a_plane_error_is_the_same_seen_from_elsewhere(
            at in prop::array::uniform2(-2.0..2.0_f64), yaw in -3.0..3.0_f64,
            e in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let error = Vector3::from(e) * 1e-4;
            let turn = Vector3::new(error.x, error.y, 0.0);
            let moved = Isometry3::new(Vector3::z() * error.z, turn);
            let X_SC = Isometry3::new(Vector3::new(at[0], at[1], 0.0), Vector3::z() * yaw);
            let X_CS = X_SC.inverse();
            let (x, sigma) = plane_in(&X_CS, &(error * error.transpose())).unwrap();
            prop_assert!(x.norm() < 1e-12);
            let (x, _) = plane_in(&(X_CS * moved), &Matrix3::zeros()).unwrap();
            // Second order in the error: 1e-8 times a few metres.
            prop_assert!((sigma - x * x.transpose()).norm() < 1e-7 * (1.0 + 1e3 * x.norm()));
            prop_assert!((sigma.diagonal().map(f64::sqrt) - x.abs()).norm() < 1e-7);
        }

        #[test]
        fn sigma_is_that_of_a_plane_moved_by_its_errors(
            x in -2.0..2.0, y in -2.0..2.0, a in -1.0..1.0, b in -1.0..1.0, c in -1.0..1.0,
        ) {
            // A covariance of rank one is one error vector; move the plane by it, exactly.
            let error = Vector3::new(a, b, c) * 1e-4;
            let outer = error * error.transpose();
            let covariance = [0, 1, 2].map(|i| [0, 1, 2].map(|j| outer[(i, j)]));
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(error.x, error.y, 0.0));
            let moved = turn * Vector3::new(x, y, 0.0) + Vector3::z() * error.z;
            // Second order in the error: 1e-8 times a few metres.
            let sigma = sigma_at(&covariance, &Point2::new(x, y));
            prop_assert!((sigma - moved.z.abs()).abs() < 1e-7);
        }
    }
}
