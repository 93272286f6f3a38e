//! Poses as \[chai2015\] writes them: three fixed angles and a position, y up.

use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// (α, β, γ) about Y, Z and X, and a position, in the paper's axes: x forward, **y up**, z to the
/// right, for the ground, the robot and the sensor alike.
///
///   R = R_Y(α) R_Z(β) R_X(γ)
///
/// Source: \[chai2015\] Eqs. 1–3 and 17–19.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PaperParameters {
    /// α, β, γ, rad.
    pub angles_rad: [f64; 3],
    /// p_x, p_y, p_z, m.
    pub position_m: [f64; 3],
}

/// From the axes of R and G (x forward, y left, z up) to the paper's.
fn from_body() -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0)
}

/// From the axes of V (x right, y down, z forward) to the paper's.
fn from_optical() -> Matrix3<f64> {
    Matrix3::new(0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0)
}

impl PaperParameters {
    fn rotation(&self) -> Matrix3<f64> {
        let [alpha, beta, gamma] = self.angles_rad;
        let R_Y = Rotation3::from_axis_angle(&Vector3::y_axis(), alpha);
        let R_Z = Rotation3::from_axis_angle(&Vector3::z_axis(), beta);
        let R_X = Rotation3::from_axis_angle(&Vector3::x_axis(), gamma);
        (R_Y * R_Z * R_X).into_inner()
    }

    fn from_rotation(R: &Matrix3<f64>, position: Vector3<f64>) -> Self {
        let beta = R[(1, 0)].clamp(-1.0, 1.0).asin();
        let gamma = (-R[(1, 2)]).atan2(R[(1, 1)]);
        let alpha = (-R[(2, 0)]).atan2(R[(0, 0)]);
        Self {
            angles_rad: [alpha, beta, gamma],
            position_m: position.into(),
        }
    }

    /// The mount of a sensor with these parameters.
    pub fn X_RV(&self) -> Isometry3<f64> {
        let R = from_body().transpose() * self.rotation() * from_optical();
        self.pose(&R)
    }

    /// The pose of a robot over the ground with these parameters.
    pub fn X_GR(&self) -> Isometry3<f64> {
        let R = from_body().transpose() * self.rotation() * from_body();
        self.pose(&R)
    }

    fn pose(&self, R: &Matrix3<f64>) -> Isometry3<f64> {
        let position = from_body().transpose() * Vector3::from(self.position_m);
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*R));
        Isometry3::from_parts(position.into(), rotation)
    }

    /// The parameters of a sensor's mount.
    pub fn of_mount(X_RV: &Isometry3<f64>) -> Self {
        let R = X_RV.rotation.to_rotation_matrix().into_inner();
        let R = from_body() * R * from_optical().transpose();
        Self::from_rotation(&R, from_body() * X_RV.translation.vector)
    }

    /// The parameters of a robot's pose.
    pub fn of_stance(X_GR: &Isometry3<f64>) -> Self {
        let R = X_GR.rotation.to_rotation_matrix().into_inner();
        let R = from_body() * R * from_body().transpose();
        Self::from_rotation(&R, from_body() * X_GR.translation.vector)
    }

    /// ∂(δθ, δp)/∂(α, β, γ, p) with (δθ, δp) in R, ours: what turns a derivative by the one into a
    /// derivative by the other.
    ///
    ///   δθ = Cᵀ [ e_y   R_Y e_z   R_Y R_Z e_x ] (δα, δβ, δγ),   δp = Cᵀ δp'
    pub fn to_step(&self) -> Matrix6<f64> {
        let [alpha, beta, _] = self.angles_rad;
        let R_Y = Rotation3::from_axis_angle(&Vector3::y_axis(), alpha);
        let R_Z = Rotation3::from_axis_angle(&Vector3::z_axis(), beta);
        let axes = [Vector3::y(), R_Y * Vector3::z(), R_Y * (R_Z * Vector3::x())];
        let axes = Matrix3::from_columns(&axes);
        let C_t = from_body().transpose();
        let mut out = Matrix6::zeros();
        out.fixed_view_mut::<3, 3>(0, 0).copy_from(&(C_t * axes));
        out.fixed_view_mut::<3, 3>(3, 3).copy_from(&C_t);
        out
    }

    /// Standard deviations of (α, β, γ, p) where (δθ, δp) has this covariance; rad, m. `None` at
    /// β = ±90°, where α and γ turn about one axis.
    pub fn deviations(&self, covariance: &Matrix6<f64>) -> Option<[f64; 6]> {
        let regular = self.angles_rad[1].cos() > 1e-6;
        let inverse = self.to_step().try_inverse().filter(|_| regular)?;
        let own = inverse * covariance * inverse.transpose();
        Some([0, 1, 2, 3, 4, 5].map(|k| own[(k, k)].max(0.0).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// [chai2015] Eq. 33, from the parameters of Eq. 32.
    #[test]
    fn the_matrix_is_the_printed_one() {
        let parameters = PaperParameters {
            angles_rad: [-0.4398_f64, -37.4072, -3.0471].map(f64::to_radians),
            position_m: [0.0; 3],
        };
        let printed = Matrix3::new(
            0.7943, 0.6070, 0.0246, -0.6075, 0.7932, 0.0422, 0.0061, -0.0485, 0.9988,
        );
        // Four printed decimals.
        assert!((parameters.rotation() - printed).amax() < 6e-5);
    }

    #[test]
    fn a_sensor_without_angles_looks_ahead() {
        let none = PaperParameters {
            angles_rad: [0.0; 3],
            position_m: [0.5, 0.4, -0.1],
        };
        let X_RV = none.X_RV();
        assert!((X_RV.rotation * Vector3::z() - Vector3::x()).norm() < 1e-12);
        assert!((X_RV.rotation * -Vector3::y() - Vector3::z()).norm() < 1e-12);
        assert!((X_RV.translation.vector - Vector3::new(0.5, 0.1, 0.4)).norm() < 1e-12);
        // Negative β looks down.
        let down = PaperParameters {
            angles_rad: [0.0, -0.6, 0.0],
            ..none
        };
        assert!((down.X_RV().rotation * Vector3::z()).z < -0.5);
        // A robot with positive β has its nose up, with positive γ its right side down.
        let up = PaperParameters {
            angles_rad: [0.0, 0.2, 0.1],
            ..none
        };
        assert!((up.X_GR().rotation * Vector3::x()).z > 0.1);
        assert!((up.X_GR().rotation * Vector3::y()).z > 0.05);
    }

    proptest! {
        #[test]
        fn parameters_go_there_and_back(
            angles in prop::array::uniform3(-1.4f64..1.4),
            position_m in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let parameters = PaperParameters { angles_rad: angles, position_m };
            for back in [
                PaperParameters::of_mount(&parameters.X_RV()),
                PaperParameters::of_stance(&parameters.X_GR()),
            ] {
                for k in 0..3 {
                    prop_assert!((back.angles_rad[k] - angles[k]).abs() < 1e-9);
                    prop_assert!((back.position_m[k] - position_m[k]).abs() < 1e-12);
                }
            }
            // to_step is the derivative of the pose.
            let h = 1e-6;
            for k in 0..3 {
                let moved = |sign: f64| {
                    let mut p = parameters;
                    p.angles_rad[k] += sign * h;
                    p.X_RV().rotation
                };
                let turn = (moved(1.0) * moved(-1.0).inverse()).scaled_axis() / (2.0 * h);
                let column = parameters.to_step().fixed_view::<3, 1>(0, k).into_owned();
                prop_assert!((turn - column).norm() < 1e-7);
            }
        }
    }
}
