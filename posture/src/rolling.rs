//! A ball that rolls on what it touches.
//!
//! The point of a ball that touches does not slide, so that its centre goes where the link turns: by r θ × n, with θ the
//! rotation (vector) of the link since the ball came to where it stands, r its radius and n the normal of what it touches.
//! That is exact where the link turns about one axis; about several it differs by what is of second order in θ.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// How a ball's centre moves as its link turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// The link's orientation in W where the centre is at its place.
    pub from_WB: UnitQuaternion<f64>,
    /// The normal of what is touched, in W.
    pub normal_W: Vector3<f64>,
    /// The ball's radius, m.
    pub radius_m: f64,
}

impl Rolling {
    /// How far the centre is from its place where the link has an orientation, in W, m.
    pub fn shift_W(&self, R_WB: &UnitQuaternion<f64>) -> Vector3<f64> {
        self.radius_m * self.turn(R_WB).cross(&self.normal_W)
    }

    /// Its derivative by a rotation of the link in W: ∂(r θ × n)/∂φ = −r n× J⁻¹(θ).
    pub fn gradient(&self, R_WB: &UnitQuaternion<f64>) -> Matrix3<f64> {
        let turn = self.turn(R_WB);
        -self.radius_m * self.normal_W.cross_matrix() * left_jacobian_inverse(&turn)
    }

    fn turn(&self, R_WB: &UnitQuaternion<f64>) -> Vector3<f64> {
        (R_WB * self.from_WB.inverse()).scaled_axis()
    }
}

/// Inverse of the left Jacobian of SO(3): d log(exp(δ)·exp(w)) = J⁻¹(w) δ.
pub(crate) fn left_jacobian_inverse(w: &Vector3<f64>) -> Matrix3<f64> {
    let angle = w.norm();
    let hat = w.cross_matrix();
    let factor = if angle < 1e-4 {
        1.0 / 12.0
    } else {
        let half = 0.5 * angle;
        (1.0 - half * half.cos() / half.sin()) / (angle * angle)
    };
    Matrix3::identity() - 0.5 * hat + factor * hat * hat
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rolling() -> Rolling {
        Rolling {
            from_WB: UnitQuaternion::from_euler_angles(0.2, -0.4, 1.0),
            normal_W: Vector3::new(0.1, -0.2, 1.0).normalize(),
            radius_m: 0.03,
        }
    }

    #[test]
    fn a_ball_rolls_as_far_as_its_rim_is_long() {
        let rolling = rolling();
        let ahead = Vector3::y().cross(&rolling.normal_W).normalize();
        let axis = nalgebra::Unit::new_normalize(rolling.normal_W.cross(&ahead));
        let turned = UnitQuaternion::from_axis_angle(&axis, 0.7) * rolling.from_WB;
        let off = rolling.shift_W(&turned) - ahead * 0.7 * rolling.radius_m;
        assert!(off.norm() < 1e-12, "{off}");
        let spun = UnitQuaternion::new(rolling.normal_W * 0.5) * rolling.from_WB;
        assert!(rolling.shift_W(&spun).norm() < 1e-12);
    }

    #[test]
    fn its_gradient_is_that_of_differences() {
        let rolling = rolling();
        let at = UnitQuaternion::new(Vector3::new(0.5, -0.3, 0.4)) * rolling.from_WB;
        let gradient = rolling.gradient(&at);
        for k in 0..3 {
            let by = |h: f64| rolling.shift_W(&(UnitQuaternion::new(Vector3::ith(k, h)) * at));
            let difference = (by(1e-6) - by(-1e-6)) / 2e-6;
            let off = (difference - gradient.column(k)).norm();
            assert!(off < 1e-8, "{off}");
        }
    }
}
