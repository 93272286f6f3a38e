//! Disagreement of the two planes of a posture, its covariance and its derivative.

use nalgebra::{Isometry3, Matrix3, Matrix3x6, Vector3};

use super::PlanePair;

/// e of one posture at one mount.
#[derive(Debug, Clone, Copy)]
pub(super) struct Residual {
    /// e = measured − predicted: two tangents of the sensor's normal, then the distance; rad, m.
    pub value: Vector3<f64>,
    /// ∂predicted/∂(δθ, δp) = −∂e/∂(δθ, δp).
    pub jacobian: Matrix3x6<f64>,
    /// Covariance of e: the sensor's and what the robot's pose noise makes of the prediction.
    pub covariance: Matrix3<f64>,
}

impl Residual {
    /// The residual of `pair` at `X_RV`.
    ///
    ///   e = [ −Tᵀ R_RVᵀ n_R ;  d − (n_R · p_RV + h) ]
    ///   J = [ Tᵀ R_RVᵀ [n_R]×   0 ;   0   n_Rᵀ ]
    ///   Σ = S + A P Aᵀ,   A = [ Tᵀ R_RVᵀ U   0 ;   p_RVᵀ U   1 ]
    ///
    /// T, U: the tangents of n_V and n_R; S, P: the covariances of the sensor's and the robot's
    /// plane.
    pub fn of(pair: &PlanePair, X_RV: &Isometry3<f64>) -> Self {
        let n_R = pair.robot.normal.into_inner();
        let p_RV = X_RV.translation.vector;
        let T_t = pair.sensor.tangents().transpose();
        let U = pair.robot.tangents();
        let R_VR = X_RV.rotation.inverse().to_rotation_matrix().into_inner();
        let turn = T_t * R_VR;

        let mut value = Vector3::zeros();
        value.fixed_rows_mut::<2>(0).copy_from(&-(turn * n_R));
        value.z = pair.sensor.distance_m - (n_R.dot(&p_RV) + pair.robot.distance_m);

        let mut jacobian = Matrix3x6::zeros();
        let turned = turn * n_R.cross_matrix();
        jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(&turned);
        jacobian.fixed_view_mut::<1, 3>(2, 3).tr_copy_from(&n_R);

        let mut A = Matrix3::zeros();
        let lever = p_RV.transpose() * U;
        A.fixed_view_mut::<2, 2>(0, 0).copy_from(&(turn * U));
        A.fixed_view_mut::<1, 2>(2, 0).copy_from(&lever);
        A[(2, 2)] = 1.0;
        Self {
            value,
            jacobian,
            covariance: pair.sensor.covariance + A * pair.robot.covariance * A.transpose(),
        }
    }
}

/// The mount after the step (δθ, δp), both in R:  R ← exp(δθ) R,  p ← p + δp.
pub(super) fn step(X_RV: &Isometry3<f64>, delta: &nalgebra::Vector6<f64>) -> Isometry3<f64> {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(delta.fixed_rows::<3>(0).into_owned());
    let moved = X_RV.translation.vector + delta.fixed_rows::<3>(3);
    Isometry3::from_parts(moved.into(), turn * X_RV.rotation)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::GroundPlane;
    use crate::camera::paper::PaperParameters;
    use nalgebra::{UnitQuaternion, Vector6};

    pub fn mount() -> Isometry3<f64> {
        PaperParameters {
            angles_rad: [-0.0077, -0.6529, -0.0532],
            position_m: [0.5279, 0.3648, -0.0334],
        }
        .X_RV()
    }

    pub fn stance(roll: f64, pitch: f64, height: f64) -> Isometry3<f64> {
        Isometry3::from_parts(
            Vector3::new(0.0, 0.0, height).into(),
            UnitQuaternion::from_euler_angles(roll, pitch, 0.3),
        )
    }

    #[test]
    fn the_jacobian_is_the_difference_quotient() {
        let X_RV = mount();
        let robot = GroundPlane::ground(&stance(0.2, -0.1, 0.7), Matrix3::identity());
        // Not the plane that the mount predicts: the residual must not vanish.
        let sensor = GroundPlane::ground(&stance(0.1, 0.9, 1.1), Matrix3::identity());
        let pair = PlanePair::new(robot, sensor);
        let at = Residual::of(&pair, &X_RV);
        for k in 0..6 {
            let h = 1e-6;
            let moved = |sign: f64| {
                let mut delta = Vector6::zeros();
                delta[k] = sign * h;
                Residual::of(&pair, &step(&X_RV, &delta)).value
            };
            let quotient = -(moved(1.0) - moved(-1.0)) / (2.0 * h);
            let error = (quotient - at.jacobian.column(k)).norm();
            // Rounding of a central difference: 1e-16 / 1e-6.
            assert!(error < 1e-8, "column {k}: {error}");
        }
    }

    #[test]
    fn the_robots_noise_moves_the_residual_as_its_covariance_says() {
        let X_RV = mount();
        let X_GR = stance(0.2, -0.1, 0.7);
        let exact = GroundPlane::ground(&X_GR, Matrix3::zeros());
        let sensor = exact.seen_from(&X_RV);
        let U = exact.tangents();
        for k in 0..3 {
            let mut P = Matrix3::zeros();
            P[(k, k)] = 1.0;
            let robot = GroundPlane {
                covariance: P,
                ..exact
            };
            let predicted = Residual::of(&PlanePair::new(robot, sensor), &X_RV).covariance;
            // The same error, made.
            let h = 1e-6;
            let mut moved = exact;
            if k < 2 {
                let turned = exact.normal.into_inner() + U.column(k) * h;
                moved.normal = nalgebra::Unit::new_normalize(turned);
            } else {
                moved.distance_m += h;
            }
            let made = Residual::of(&PlanePair::new(moved, sensor), &X_RV).value / h;
            let error = (made * made.transpose() - predicted).norm();
            assert!(error < 1e-5, "component {k}: {error}");
        }
    }
}
