//! Where a floating-base robot is: base pose and joint values.

use nalgebra::{DVector, Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::Error;

/// A point of SE(3) × ℝⁿʲ.
///
///   q = [p_WB, quat_xyzw, joints…]        v = [v_B, ω_B, joint rates…]
///
/// v_B is the velocity of B's origin and ω_B the angular velocity, both **in W**.
/// Units: m, rad (joints of a prismatic joint: m).
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// Position of the floating base B.
    pub p_WB: Vector3<f64>,
    /// Orientation of the floating base B.
    pub R_WB: UnitQuaternion<f64>,
    /// Joint values, joint j moving body j + 1.
    pub joints: DVector<f64>,
}

impl Configuration {
    /// The base at W's origin and every joint at zero.
    pub fn zero(nj: usize) -> Self {
        Configuration {
            p_WB: Vector3::zeros(),
            R_WB: UnitQuaternion::identity(),
            joints: DVector::zeros(nj),
        }
    }

    /// Pose of the floating base.
    pub fn X_WB(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.p_WB), self.R_WB)
    }

    /// The same joints with the base at `X_WB`.
    pub fn with_base(mut self, X_WB: &Isometry3<f64>) -> Self {
        self.p_WB = X_WB.translation.vector;
        self.R_WB = X_WB.rotation;
        self
    }

    /// q = [p_WB, quat_xyzw, joints…].
    pub fn to_q(&self) -> Vec<f64> {
        let mut q = Vec::with_capacity(7 + self.joints.len());
        q.extend(self.p_WB.iter());
        q.extend(self.R_WB.coords.iter());
        q.extend(self.joints.iter());
        q
    }

    /// The configuration of q = [p_WB, quat_xyzw, joints…].
    ///
    /// # Errors
    /// [`Error::Value`] when q is shorter than 7, holds a value that is not finite, or its
    /// quaternion is further than 1e-3 from unit length (a nearer one is normalised).
    pub fn from_q(q: &[f64]) -> Result<Self, Error> {
        let refuse = |cause: String| Error::value("configuration q", cause);
        let &[x, y, z, i, j, k, w, ref joints @ ..] = q else {
            return Err(refuse(format!("{} values, at least 7 wanted", q.len())));
        };
        if let Some(at) = q.iter().position(|value| !value.is_finite()) {
            return Err(refuse(format!("value {at} is not finite")));
        }
        let quaternion = Quaternion::new(w, i, j, k);
        // 1e-3: a quaternion written with three decimals is a rounded one, one further off is wrong.
        if (quaternion.norm() - 1.0).abs() > 1e-3 {
            let length = quaternion.norm();
            return Err(refuse(format!("quaternion of length {length}")));
        }
        // A quaternion that is already unit to the last bits stays as it was written.
        let R_WB = if (quaternion.norm_squared() - 1.0).abs() < 4.0 * f64::EPSILON {
            UnitQuaternion::new_unchecked(quaternion)
        } else {
            UnitQuaternion::new_normalize(quaternion)
        };
        Ok(Configuration {
            p_WB: Vector3::new(x, y, z),
            R_WB,
            joints: DVector::from_column_slice(joints),
        })
    }

    /// The configuration after the step δ = [δp, δθ, δjoints…], δp and δθ in W.
    ///
    ///   p ← p + δp      R ← exp(δθ) R      joints ← joints + δjoints
    ///
    /// Shapes: δ 6 + nj.
    pub fn integrate(&self, delta: &DVector<f64>) -> Self {
        let mut next = self.clone();
        next.integrate_in_place(delta.as_slice());
        next
    }

    /// [`Self::integrate`] without allocating.
    pub fn integrate_in_place(&mut self, delta: &[f64]) {
        assert_eq!(
            delta.len(),
            6 + self.joints.len(),
            "a step has 6 + nj entries"
        );
        self.p_WB += Vector3::new(delta[0], delta[1], delta[2]);
        let turn = UnitQuaternion::new(Vector3::new(delta[3], delta[4], delta[5]));
        // Products of unit quaternions drift by rounding only; renormalising keeps it bounded.
        self.R_WB = UnitQuaternion::new_normalize((turn * self.R_WB).into_inner());
        for (joint, step) in self.joints.iter_mut().zip(&delta[6..]) {
            *joint += step;
        }
    }

    /// The step δ that leads from `self` to `to`: the inverse of [`Self::integrate`].
    pub fn difference(&self, to: &Self) -> DVector<f64> {
        let mut delta = DVector::zeros(6 + self.joints.len());
        delta
            .fixed_rows_mut::<3>(0)
            .copy_from(&(to.p_WB - self.p_WB));
        let turn = (to.R_WB * self.R_WB.inverse()).scaled_axis();
        delta.fixed_rows_mut::<3>(3).copy_from(&turn);
        delta
            .rows_mut(6, self.joints.len())
            .copy_from(&(&to.joints - &self.joints));
        delta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn q_goes_there_and_back() {
        let q = [0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5, 1.0, -2.0];
        let configuration = Configuration::from_q(&q).unwrap();
        assert_eq!(configuration.to_q(), q);
    }

    #[test]
    fn bad_q_is_refused() {
        assert!(Configuration::from_q(&[0.0; 6]).is_err());
        assert!(Configuration::from_q(&[0.0; 7]).is_err());
        let mut q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, f64::NAN];
        assert!(Configuration::from_q(&q).is_err());
        q[7] = 0.0;
        assert!(Configuration::from_q(&q).is_ok());
    }

    #[test]
    fn difference_undoes_integrate() {
        let from = Configuration::from_q(&[1.0, 2.0, 3.0, 0.0, 0.6, 0.0, 0.8, 0.4]).unwrap();
        let delta = DVector::from_vec(vec![0.1, -0.2, 0.3, 0.4, -0.5, 0.6, 0.7]);
        let back = from.difference(&from.integrate(&delta));
        assert!((back - delta).norm() < 1e-14);
    }
}
