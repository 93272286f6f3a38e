//! What is known of a mounted LiDAR: its pose, its rings' constant range errors.

use nalgebra::{Isometry3, Matrix4, Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::plane::Plane;
use crate::Error;

/// The value of the field `format`.
pub const CALIBRATION_FORMAT: &str = "scandent-lidar-calibration/1";
/// Largest deviation of a quaternion's length from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

/// The external calibration and the rings' range errors, as they stand in a file.
///
/// W has its origin on the ground below the sensor, z up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LidarCalibration {
    /// [`CALIBRATION_FORMAT`].
    pub format: String,
    /// Position of V in W, m.
    pub position_m: [f64; 3],
    /// Orientation of V in W.
    pub quat_xyzw: [f64; 4],
    /// Whether poles gave the heading; without them V's x looks along W's.
    pub heading_known: bool,
    /// Covariance of roll and pitch (rotations about W's x and y), drift (about z) and height: rad,
    /// rad, rad, m.
    pub covariance: [[f64; 4]; 4],
    /// Constant range error of every ring from the lowest, measured less true, m; empty where it was
    /// not determined.
    #[serde(default)]
    pub ring_bias_m: Vec<f64>,
    /// Standard deviation of each of these, m.
    #[serde(default)]
    pub ring_bias_sigma_m: Vec<f64>,
}

impl LidarCalibration {
    /// A pose without anything else known.
    pub fn from_pose(X_WV: &Isometry3<f64>, covariance: &Matrix4<f64>) -> Self {
        Self {
            format: CALIBRATION_FORMAT.to_owned(),
            position_m: X_WV.translation.vector.into(),
            quat_xyzw: X_WV.rotation.coords.into(),
            heading_known: false,
            covariance: [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| covariance[(i, j)])),
            ring_bias_m: Vec::new(),
            ring_bias_sigma_m: Vec::new(),
        }
    }

    /// Pose of V in W.
    pub fn X_WV(&self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_quaternion(self.quat_xyzw.into());
        Isometry3::from_parts(self.position_m.into(), rotation)
    }

    /// The same sensor in another world U in which this one stands at `X_UW`.
    pub fn placed(&self, X_UW: &Isometry3<f64>) -> Self {
        let X_UV = X_UW * self.X_WV();
        let mut turn = Matrix4::identity();
        let rotation = X_UW.rotation.to_rotation_matrix().into_inner();
        turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
        let covariance = turn * Matrix4::from_fn(|i, j| self.covariance[i][j]) * turn.transpose();
        Self {
            heading_known: self.heading_known,
            ring_bias_m: self.ring_bias_m.clone(),
            ring_bias_sigma_m: self.ring_bias_sigma_m.clone(),
            ..Self::from_pose(&X_UV, &covariance)
        }
    }

    /// The ground z = 0 in V.
    pub fn ground_V(&self) -> Plane {
        let X_WV = self.X_WV();
        Plane {
            normal: X_WV.rotation.inverse() * Vector3::z(),
            offset_m: X_WV.translation.z,
        }
    }

    /// Checks what a file may hold.
    ///
    /// # Errors
    /// [`Error::Calibration`] with the field and what is wrong with it.
    pub fn check(&self) -> Result<(), Error> {
        let fail = |field: &'static str, cause: String| Err(Error::Calibration { field, cause });
        if self.format != CALIBRATION_FORMAT {
            let cause = format!("is {:?}, not {CALIBRATION_FORMAT:?}", self.format);
            return fail("format", cause);
        }
        for (field, values) in [
            ("position_m", &self.position_m[..]),
            ("quat_xyzw", &self.quat_xyzw),
            ("ring_bias_m", &self.ring_bias_m),
            ("ring_bias_sigma_m", &self.ring_bias_sigma_m),
            ("covariance", self.covariance.as_flattened()),
        ] {
            if let Some(value) = values.iter().find(|v| !v.is_finite()) {
                return fail(field, format!("contains {value}"));
            }
        }
        let norm = Quaternion::from_vector(self.quat_xyzw.into()).norm();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return fail("quat_xyzw", format!("has length {norm}, not 1"));
        }
        if self.position_m[2] <= 0.0 {
            let cause = format!(
                "puts the sensor at {} m, not above the ground",
                self.position_m[2]
            );
            return fail("position_m", cause);
        }
        if self.ring_bias_m.len() != self.ring_bias_sigma_m.len() {
            let cause = format!(
                "{} values, ring_bias_m has {}",
                self.ring_bias_sigma_m.len(),
                self.ring_bias_m.len()
            );
            return fail("ring_bias_sigma_m", cause);
        }
        match self.ring_bias_sigma_m.iter().find(|s| **s <= 0.0) {
            Some(sigma) => fail("ring_bias_sigma_m", format!("contains {sigma}")),
            None => Ok(()),
        }
    }
}
