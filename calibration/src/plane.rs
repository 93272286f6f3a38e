//! The ground's plane with its uncertainty.

use nalgebra::{Isometry3, Matrix3, Matrix3x2, Unit, Vector3};

/// The ground's plane n·p + d = 0 in some frame F, n the unit normal toward the origin's side.
///
/// `covariance` is that of (η₁, η₂, d), where the true normal is n + e₁η₁ + e₂η₂ to first order and
/// e₁, e₂ are [`GroundPlane::tangents`]; rad, rad, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundPlane {
    /// n, in F.
    pub normal: Unit<Vector3<f64>>,
    /// d: distance of F's origin from the plane, m; positive on the normal's side.
    pub distance_m: f64,
    /// Covariance of (η₁, η₂, d).
    pub covariance: Matrix3<f64>,
}

impl GroundPlane {
    /// The plane with this normal and distance, exactly known.
    pub fn exact(normal: Unit<Vector3<f64>>, distance_m: f64) -> Self {
        Self {
            normal,
            distance_m,
            covariance: Matrix3::zeros(),
        }
    }

    /// The ground z_G = 0 as the frame R at `X_GR` has it.
    ///
    ///   n_R = R_GRᵀ e_z,   d_R = z of p_GR
    pub fn ground(X_GR: &Isometry3<f64>, covariance: Matrix3<f64>) -> Self {
        Self {
            normal: Unit::new_normalize(X_GR.rotation.inverse() * Vector3::z()),
            distance_m: X_GR.translation.z,
            covariance,
        }
    }

    /// The same plane, exactly known, in the frame V at `X_RV` in this plane's frame R.
    ///
    ///   n_V = R_RVᵀ n_R,   d_V = n_R · p_RV + d_R
    pub fn seen_from(&self, X_RV: &Isometry3<f64>) -> Self {
        Self::exact(
            Unit::new_normalize(X_RV.rotation.inverse() * self.normal.into_inner()),
            self.normal.dot(&X_RV.translation.vector) + self.distance_m,
        )
    }

    /// Two unit vectors that are orthogonal to the normal and to each other.
    pub fn tangents(&self) -> Matrix3x2<f64> {
        tangents(&self.normal)
    }

    /// Angle between the normals, rad.
    pub fn angle_to(&self, other: &Self) -> f64 {
        // atan2 keeps its digits at small angles, where the cosine does not.
        let (a, b) = (&self.normal, &other.normal);
        a.cross(b).norm().atan2(a.dot(b))
    }
}

/// Two unit vectors that are orthogonal to `normal` and to each other.
pub(crate) fn tangents(normal: &Unit<Vector3<f64>>) -> Matrix3x2<f64> {
    // The axis that is farthest from the normal.
    let axis = if normal.x.abs() <= normal.y.abs().min(normal.z.abs()) {
        Vector3::x()
    } else if normal.y.abs() <= normal.z.abs() {
        Vector3::y()
    } else {
        Vector3::z()
    };
    let first = normal.cross(&axis).normalize();
    Matrix3x2::from_columns(&[first, normal.cross(&first)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, UnitQuaternion};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_plane_holds_the_same_points_in_either_frame(
            rpy in prop::array::uniform3(-1.0f64..1.0),
            p in prop::array::uniform3(-1.0f64..1.0),
            q in prop::array::uniform3(-2.0f64..2.0),
        ) {
            let [r, t, y] = rpy;
            let X_GR = Isometry3::from_parts(
                Vector3::new(p[0], p[1], 1.0 + p[2]).into(),
                UnitQuaternion::from_euler_angles(r, t, y),
            );
            let X_RV = Isometry3::from_parts(
                Vector3::new(q[2], q[0], q[1]).into(),
                UnitQuaternion::from_euler_angles(y, r, t),
            );
            let in_R = GroundPlane::ground(&X_GR, Matrix3::zeros());
            let in_V = in_R.seen_from(&X_RV);
            let p_G = Point3::new(q[0], q[1], 0.0);
            let p_R = X_GR.inverse() * p_G;
            let p_V = X_RV.inverse() * p_R;
            for (plane, p) in [(in_R, p_R), (in_V, p_V)] {
                prop_assert!((plane.normal.dot(&p.coords) + plane.distance_m).abs() < 1e-12);
            }
            let e = in_V.tangents();
            prop_assert!((e.transpose() * e - nalgebra::Matrix2::identity()).norm() < 1e-12);
            prop_assert!((e.transpose() * in_V.normal.into_inner()).norm() < 1e-12);
        }
    }
}
