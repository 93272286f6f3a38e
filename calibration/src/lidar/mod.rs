//! Where a spinning LiDAR sits over the ground: roll and pitch from the ground's normal, the drift
//! angle from poles, the height, and the rings' range errors from all planes.
//!
//!   p_W = R_d R_r p_V + T,   T = (0, 0, h)
//!
//! Source: \[meng\] II-B (Eqs. 1 to 8) with its formulas corrected: R_r is built from the axes
//! ([`perception::lidar::levelled`]), the drift angle has a sign ([`drift`]).

mod drift;
mod poles;

use nalgebra::{Isometry3, Matrix3, Matrix4, Translation3, UnitQuaternion, Vector3};
use perception::lidar::{
    Adjustment, ExtractedPlanes, LidarCalibration, LidarCloud, LidarConfig, adjust, extract_planes,
    levelled,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::error::within;
pub use drift::{Drift, PoleMatch, drift};
pub use poles::{Pole, poles};

/// Settings of the calibration of a LiDAR.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LidarExtrinsicsConfig {
    /// Diameter of the poles, m.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub pole_diameter_m: f64,
    /// Whether the world's origin is below the sensor; else the poles say where it is.
    pub origin_below_sensor: bool,
}

impl Default for LidarExtrinsicsConfig {
    fn default() -> Self {
        Self {
            pole_diameter_m: 0.08,
            origin_below_sensor: true,
        }
    }
}

impl LidarExtrinsicsConfig {
    /// Checks every setting's range.
    ///
    /// # Errors
    /// [`Error::Config`] naming the setting.
    pub fn check(&self) -> Result<(), Error> {
        let range = [1e-6, 10.0];
        within(
            "pole_diameter_m",
            self.pole_diameter_m,
            range,
            "must be a length up to 10 m",
        )
    }
}

/// A calibration and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// What is kept.
    pub calibration: LidarCalibration,
    /// Ground, rings, residuals.
    pub adjustment: Adjustment,
    /// The poles that were found in the first cloud, in the levelled frame.
    pub poles: Vec<Pole>,
    /// The heading from them; `None` where no poles were given.
    pub drift: Option<Drift>,
}

/// Calibrates a LiDAR from clouds of one mount and, for the heading, the places of poles in the world
/// (x, y, m) that the first cloud shows.
///
/// # Errors
/// [`Error::Lidar`] where no cloud shows the ground, or fewer than two of the poles are found;
/// [`Error::Cloud`] with the number of a cloud that cannot be used.
pub fn calibrate(
    clouds: &[LidarCloud],
    poles_W: &[[f64; 2]],
    config: &LidarExtrinsicsConfig,
    perception: &LidarConfig,
) -> Result<Calibrated, Error> {
    config.check()?;
    // 1. Planes of every cloud; ground and ring errors of all.
    let surveys: Vec<ExtractedPlanes> = clouds
        .iter()
        .enumerate()
        .map(|(number, cloud)| {
            extract_planes(cloud, perception).map_err(|source| Error::Cloud { number, source })
        })
        .collect::<Result<_, _>>()?;
    let adjustment = adjust(&surveys).ok_or_else(|| Error::Lidar {
        cause: "no cloud shows ground that is about level under the sensor".to_owned(),
    })?;

    // 2. Roll, pitch and height from the ground.
    let X_RV = levelled(&adjustment.ground_V);

    // 3. The drift angle from the poles.
    let found = surveys
        .first()
        .map(|survey| poles(survey, &X_RV, &adjustment.ring_bias_m, config))
        .unwrap_or_default();
    let drift = match poles_W {
        [] => None,
        given => Some(drift(&found, given, config)?),
    };
    let (phi, offset) = drift
        .as_ref()
        .map_or((0.0, [0.0; 2]), |d| (d.angle_rad, d.offset_m));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), phi);
    let X_WR = Isometry3::from_parts(Translation3::new(offset[0], offset[1], 0.0), turn);
    let X_WV = X_WR * X_RV;

    // 4. Their covariance: rotations about W's axes, and the height.
    let R_WV: Matrix3<f64> = X_WV.rotation.to_rotation_matrix().into_inner();
    let mut turn = Matrix4::identity();
    turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&R_WV);
    let mut covariance = turn * adjustment.ground_covariance * turn.transpose();
    // Nothing about the vertical comes from the ground.
    for i in 0..4 {
        covariance[(2, i)] = 0.0;
        covariance[(i, 2)] = 0.0;
    }
    covariance[(2, 2)] = drift.as_ref().map_or(0.0, |d| d.sigma_rad.powi(2));
    let covariance = (covariance + covariance.transpose()) * 0.5;

    let mut calibration = LidarCalibration::from_pose(&X_WV, &covariance);
    calibration.heading_known = drift.is_some();
    calibration.ring_bias_m.clone_from(&adjustment.ring_bias_m);
    calibration
        .ring_bias_sigma_m
        .clone_from(&adjustment.ring_bias_sigma_m);
    Ok(Calibrated {
        calibration,
        adjustment,
        poles: found,
        drift,
    })
}
