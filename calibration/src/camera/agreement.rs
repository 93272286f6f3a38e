//! How far the ground that was seen is from the ground that the mount predicts.

use nalgebra::{Isometry3, Vector3};
use serde::Serialize;

use super::PlanePair;
use crate::GroundPlane;

/// The two planes of one posture in V, and their disagreement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// (a, b, c) of the plane that was measured, in V.
    pub measured_normal: [f64; 3],
    /// d of the plane that was measured, m.
    pub measured_distance_m: f64,
    /// (a, b, c) of the plane that robot and mount predict, in V.
    pub predicted_normal: [f64; 3],
    /// d of the plane that robot and mount predict, m.
    pub predicted_distance_m: f64,
    /// θ: angle between the two, rad.
    pub theta_rad: f64,
    /// e_d = |d_predicted − d_measured|, m.
    pub distance_error_m: f64,
    /// Weight that the pose had in the identification: below 1 for outliers.
    pub weight: f64,
}

impl Agreement {
    /// The disagreement of `pair` at the mount `X_RV`.
    ///
    /// Source: \[chai2015\] Section 5.2, Fig. 16.
    pub fn of(pair: &PlanePair, X_RV: &Isometry3<f64>, weight: f64) -> Self {
        let predicted: GroundPlane = pair.robot.seen_from(X_RV);
        let numbers = |normal: &Vector3<f64>| [normal.x, normal.y, normal.z];
        Self {
            measured_normal: numbers(&pair.sensor.normal),
            measured_distance_m: pair.sensor.distance_m,
            predicted_normal: numbers(&predicted.normal),
            predicted_distance_m: predicted.distance_m,
            theta_rad: pair.sensor.angle_to(&predicted),
            distance_error_m: (predicted.distance_m - pair.sensor.distance_m).abs(),
            weight,
        }
    }
}
