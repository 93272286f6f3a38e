//! The motion of a scan that is sought, about a point, and what is known of it beforehand.

use nalgebra::{Isometry3, Matrix3x6, Matrix6, Point3, Vector6};

use super::RegistrationConfig;

/// A motion and what is known of it beforehand.
pub(super) struct Pose {
    /// The motion so far.
    pub X_W: Isometry3<f64>,
    /// The point that turns are about.
    pub about_W: Point3<f64>,
    /// Covariance of (turn, shift) of the pose that was given.
    pub given: Matrix6<f64>,
}

impl Pose {
    /// The pose as it was given: a turn about the sensor moves what it saw.
    pub fn given(eye_W: &Point3<f64>, about_W: Point3<f64>, config: &RegistrationConfig) -> Self {
        let [turn, shift] = [config.direction_sigma_rad, config.position_sigma_m].map(|s| s * s);
        let own = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
        let mut moved = Matrix6::identity();
        let lever = (eye_W - about_W).cross_matrix();
        moved.fixed_view_mut::<3, 3>(3, 0).copy_from(&lever);
        Self {
            X_W: Isometry3::identity(),
            about_W,
            given: moved * own * moved.transpose(),
        }
    }

    /// The turn about the point and the shift of the motion so far.
    pub fn off(&self) -> Vector6<f64> {
        self.coordinates(&self.X_W)
    }

    /// How (turn, shift) changes (θ_x, θ_y, z) of a plane in a frame C on it.
    pub fn jacobian(&self, X_WC: &Isometry3<f64>) -> Matrix3x6<f64> {
        let axes = X_WC.rotation.to_rotation_matrix();
        let [x, y, z] = [0, 1, 2].map(|i| axes.matrix().column(i).into_owned());
        let arm = X_WC.translation.vector - self.about_W.coords;
        // z · (ω × arm) = ω · (arm × z)
        let lever = arm.cross(&z);
        Matrix3x6::new(
            x.x, x.y, x.z, 0.0, 0.0, 0.0, //
            y.x, y.y, y.z, 0.0, 0.0, 0.0, //
            lever.x, lever.y, lever.z, z.x, z.y, z.z,
        )
    }

    /// The turn about the point and the shift of a motion.
    pub fn coordinates(&self, X_W: &Isometry3<f64>) -> Vector6<f64> {
        let (turn, shift) = (
            X_W.rotation.scaled_axis(),
            X_W * self.about_W - self.about_W,
        );
        Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
    }
}
