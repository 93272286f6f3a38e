//! The frame W that the ground gives: level, below the sensor.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::plane::Plane;

/// Pose of V in the frame R below it that the ground levels: z_R is the ground's normal, x_R its
/// intersection with V's XZ plane.
///
///   Ẑ = (A, B, C),  X̂ = (C, 0, −A)/√(A² + C²),  Ŷ = Ẑ × X̂,  R_r = rows [X̂; Ŷ; Ẑ],  T = (0, 0, h)
///
/// Source: \[meng\] Eqs. 1, 7 and 8; deviation: the rotation is built from the axes, because the Euler
/// angles of Eq. 2 lose their signs and do not exist for a level sensor.
pub fn levelled(ground_V: &Plane) -> Isometry3<f64> {
    let z = ground_V.normal;
    // V's y straight up: any tangent does.
    let x = Vector3::new(z.z, 0.0, -z.x)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    let y = z.cross(&x);
    let R_RV = Matrix3::from_rows(&[x.transpose(), y.transpose(), z.transpose()]);
    Isometry3::from_parts(
        Translation3::new(0.0, 0.0, ground_V.offset_m),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R_RV)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Also where A < 0, where the printed arccos has the wrong sign.
        #[test]
        fn the_ground_is_level_and_x_stays_in_the_xz_plane(roll in -0.6f64..0.6, pitch in -0.6f64..0.6, h in 0.1f64..2.0) {
            let R_WV = Rotation3::from_euler_angles(roll, pitch, 0.0);
            let n = R_WV.inverse() * Vector3::z();
            let X = levelled(&Plane { normal: n, offset_m: h });
            prop_assert!((X.rotation * n - Vector3::z()).norm() < 1e-12);
            // x_R, in V: in the XZ plane, ahead.
            let x = X.rotation.inverse() * Vector3::x();
            prop_assert!(x.y.abs() < 1e-12 && x.x > 0.0);
            prop_assert_eq!(X.translation.vector, Vector3::new(0.0, 0.0, h));
        }
    }

    #[test]
    fn a_level_sensor_is_left_as_it_is() {
        let X = levelled(&Plane {
            normal: Vector3::z(),
            offset_m: 0.7,
        });
        assert_eq!(X.rotation.angle(), 0.0);
    }
}
