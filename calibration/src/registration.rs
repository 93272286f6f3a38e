//! Rotations and poses that bring points or directions onto others.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::Error;

/// The rotation R nearest to turning every `from` into its `to`:
///
///   min Σ ‖to − R from‖²,   M = Σ to fromᵀ = U S Vᵀ,   R = U diag(1, 1, det U Vᵀ) Vᵀ
///
/// # Errors
/// [`Error::Collinear`] with `what` when fewer than two directions are different.
/// Source: \[kabsch1976\].
pub fn nearest_rotation<'a>(
    pairs: impl Iterator<Item = (&'a Vector3<f64>, &'a Vector3<f64>)>,
    what: &'static str,
) -> Result<UnitQuaternion<f64>, Error> {
    let M: Matrix3<f64> = pairs.map(|(from, to)| to * from.transpose()).sum();
    let svd = M.svd(true, true);
    let (Some(U), Some(V_t)) = (svd.u, svd.v_t) else {
        return Err(Error::Collinear { what });
    };
    // Largest first; the second tells directions that span a plane from those that do not.
    let mut values: Vec<f64> = svd.singular_values.iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let spans_a_plane = values[1] > 1e-9 * values[0];
    if !spans_a_plane {
        return Err(Error::Collinear { what });
    }
    let mut D = Matrix3::identity();
    let smallest = svd.singular_values.imin();
    D[(smallest, smallest)] = (U * V_t).determinant().signum();
    let R = Rotation3::from_matrix_unchecked(U * D * V_t);
    Ok(UnitQuaternion::from_rotation_matrix(&R))
}

/// The pose X that brings every point `from` nearest to its `to`:  min Σ ‖to − X from‖².
///
/// # Errors
/// [`Error::Collinear`] with `what` when the points do not span a plane (three at least do).
/// Source: \[kabsch1976\].
pub fn register(
    from: &[Point3<f64>],
    to: &[Point3<f64>],
    what: &'static str,
) -> Result<Isometry3<f64>, Error> {
    let n = from.len().min(to.len());
    if n < 3 {
        return Err(Error::Collinear { what });
    }
    let mean = |points: &[Point3<f64>]| -> Vector3<f64> {
        points[..n].iter().map(|p| p.coords).sum::<Vector3<f64>>() / n as f64
    };
    let (from_mean, to_mean) = (mean(from), mean(to));
    let centred = |points: &[Point3<f64>], mean: &Vector3<f64>| -> Vec<Vector3<f64>> {
        points[..n].iter().map(|p| p.coords - mean).collect()
    };
    let (a, b) = (centred(from, &from_mean), centred(to, &to_mean));
    let rotation = nearest_rotation(a.iter().zip(&b), what)?;
    let translation = to_mean - rotation * from_mean;
    Ok(Isometry3::from_parts(translation.into(), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_moved_triangle_is_moved_back(
            rpy in prop::array::uniform3(-3.0f64..3.0),
            p in prop::array::uniform3(-2.0f64..2.0),
        ) {
            let X = Isometry3::from_parts(
                Vector3::from(p).into(),
                UnitQuaternion::from_euler_angles(rpy[0], rpy[1] / 2.0, rpy[2]),
            );
            // Three points in a plane: the sign of the third axis comes from the determinant.
            let from = [[0.7, 0.1, 0.0], [-0.4, 0.6, 0.0], [-0.2, -0.8, 0.0]].map(Point3::from);
            let to = from.map(|p| X * p);
            let found = register(&from, &to, "feet").unwrap();
            prop_assert!((found.to_homogeneous() - X.to_homogeneous()).norm() < 1e-9);
        }
    }

    #[test]
    fn points_on_a_line_are_refused() {
        let line = [0.0, 1.0, 3.0].map(|t| Point3::new(t, 2.0 * t, 0.0));
        let error = register(&line, &line, "feet").unwrap_err();
        assert!(error.to_string().contains("feet"), "{error}");
    }
}
