//! How far the uncertainty of a fitted plane moves its edges.
//!
//! The plane's errors (θ_x, θ_y, z) are small rotations about x_S and y_S and an offset along
//! z_S; they move the plane's point (x, y) along the normal by
//!
//!   δ(x, y) = θ_x y − θ_y x + z = g · (θ_x, θ_y, z),    g = (y, −x, 1),    σ² = gᵀ Σ g.
//!
//! Where an edge was seen along a ray with direction d (in S, d_z < 0), a plane that is δ too high
//! is met δ / d_z further along the ray, and the edge with outward normal n moves in the plane by
//! n · d_xy · δ / d_z. With the independent error σ_edge of finding the edge in the image:
//!
//!   σ_l² = σ_edge² + (n_l · d_xy / d_z)² max_{p on l} σ(p)²,     inset_l = k σ_l.

use nalgebra::{Isometry3, Matrix3, Point2, Vector3};

use crate::{ConvexPolygon, Error, Surface};

/// Standard deviation along the normal at the plane's point `p`, m.
///
/// `covariance` of (rotation about x_S, rotation about y_S, offset along z_S): rad, rad, m.
pub fn sigma_at(covariance: &[[f64; 3]; 3], p: &Point2<f64>) -> f64 {
    let sigma = Matrix3::from_fn(|i, j| covariance[i][j]);
    let g = Vector3::new(p.y, -p.x, 1.0);
    // Rounding can take the form below zero where the plane is known exactly.
    g.dot(&(sigma * g)).max(0.0).sqrt()
}

/// A plane as it looks from a frame C near it: (θ_x, θ_y, z) that would bring C's plane z = 0 onto
/// it, and their covariance. `None` where the plane leans by more than 60° in C.
///
///   Σ_C = T Σ_S Tᵀ,   T: the rotations turn with the axes, z is taken at C's origin
///
/// Frames: S on the plane with the covariance `sigma` of (rotation about x_S, about y_S, offset along
/// z_S): rad, rad, m.
#[allow(non_snake_case)]
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

/// The largest standard deviation along the normal anywhere on the polygon, m.
///
/// The variance is a convex function of the point, so a vertex has the largest.
pub fn sigma_max(covariance: &[[f64; 3]; 3], polygon: &ConvexPolygon) -> f64 {
    let at = |p| sigma_at(covariance, p);
    polygon.vertices().iter().map(at).fold(0.0, f64::max)
}

/// What is known of how the edges of a surface were seen.
#[allow(non_snake_case)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeView {
    /// Standard deviation of an edge's place in the surface, m (1–2 pixels · z / f).
    pub sigma_edge_m: f64,
    /// Direction of the rays to the surface, in W; need not be a unit vector.
    pub ray_W: Vector3<f64>,
    /// Number k of standard deviations to keep off the edges.
    pub k: f64,
}

/// The distance k·σ_l by which each edge may be nearer than it seems, m, in the order of the edges.
///
/// A surface without a covariance has only the edge error.
/// # Errors
/// [`Error::BadNumber`] when k or σ_edge is negative or not finite, or the ray does not come from
/// the free side of the surface.
#[allow(non_snake_case)]
pub fn edge_insets_m(surface: &Surface, view: &EdgeView) -> Result<Vec<f64>, Error> {
    for (field, value) in [("k", view.k), ("sigma_edge_m", view.sigma_edge_m)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(bad(field, value, "a finite number ≥ 0"));
        }
    }
    let ray_S = surface.X_WS.rotation.inverse() * view.ray_W;
    if !(ray_S.z < 0.0 && ray_S.iter().all(|c| c.is_finite())) {
        return Err(bad(
            "ray_W · normal",
            ray_S.z,
            "negative: rays fall on the free side",
        ));
    }
    let slide = ray_S.xy() / ray_S.z;
    let off_plane = |p: &Point2<f64>| {
        let covariance = surface.plane_covariance.as_ref();
        covariance.map_or(0.0, |c| sigma_at(c, p))
    };
    let edges = surface.polygon.edges().zip(surface.polygon.half_planes());
    let inset = |((a, b), half_plane): ((&Point2<f64>, &Point2<f64>), crate::HalfPlane)| {
        let across = half_plane.n.dot(&slide) * off_plane(a).max(off_plane(b));
        view.k * view.sigma_edge_m.hypot(across)
    };
    Ok(edges.map(inset).collect())
}

/// The largest of [`edge_insets_m`]: a value for [`Surface::inset_m`].
///
/// # Errors  as [`edge_insets_m`].
#[allow(non_snake_case)]
pub fn inset_m(surface: &Surface, view: &EdgeView) -> Result<f64, Error> {
    Ok(edge_insets_m(surface, view)?
        .into_iter()
        .fold(0.0, f64::max))
}

fn bad(field: &str, value: f64, expected: &'static str) -> Error {
    Error::BadNumber {
        field: field.into(),
        value,
        expected,
    }
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;

    fn surface() -> Surface {
        let corners = vec![[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]];
        let mut surface = Surface::new("s", Isometry3::identity(), corners.try_into().unwrap());
        let (tilt, height) = (0.01_f64.powi(2), 0.002_f64.powi(2));
        surface.plane_covariance =
            Some([[tilt, 0.0, 0.0], [0.0, 4.0 * tilt, 0.0], [0.0, 0.0, height]]);
        surface
    }

    #[test]
    fn a_ray_along_the_normal_leaves_only_the_edge_error() {
        let view = EdgeView {
            sigma_edge_m: 0.004,
            ray_W: -Vector3::z(),
            k: 2.0,
        };
        assert_eq!(edge_insets_m(&surface(), &view).unwrap(), [0.008; 4]);
    }

    #[test]
    fn a_slanted_ray_moves_the_edges_it_crosses() {
        // Seen at 45° along +x: an error along the normal moves the x edges by as much.
        let view = EdgeView {
            sigma_edge_m: 0.0,
            ray_W: Vector3::new(1.0, 0.0, -1.0),
            k: 1.0,
        };
        let insets = edge_insets_m(&surface(), &view).unwrap();
        let corner = (0.5_f64 * 0.01).hypot(1.0 * 0.02).hypot(0.002);
        approx::assert_relative_eq!(insets[1], corner, max_relative = 1e-12);
        assert_eq!(insets[0], 0.0);
        assert_eq!(inset_m(&surface(), &view).unwrap(), insets[1]);
    }

    #[test]
    fn bad_views_are_refused_by_name() {
        let good = EdgeView {
            sigma_edge_m: 0.004,
            ray_W: -Vector3::z(),
            k: 2.0,
        };
        for (view, field) in [
            (
                EdgeView {
                    k: f64::NAN,
                    ..good
                },
                "k",
            ),
            (
                EdgeView {
                    sigma_edge_m: -1.0,
                    ..good
                },
                "sigma_edge_m",
            ),
            (
                EdgeView {
                    ray_W: Vector3::z(),
                    ..good
                },
                "ray_W",
            ),
        ] {
            let error = inset_m(&surface(), &view).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        }
    }

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
