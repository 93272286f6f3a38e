//! Inliers projected onto their plane, in its frame.

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::plane_extraction::PlaneFit;
use crate::scan::tangent_frame;

/// Points on a plane.
pub(super) struct Projection {
    /// Pose of S in V: origin at the barycentre, z_S toward the sensor.
    pub X_VS: Isometry3<f64>,
    /// The points in S, m.
    pub points: Vec<Point2<f64>>,
}

/// The inliers of a plane, projected onto it; `forward` and `up` (in V) choose the tangents.
///
/// Source: [brossette2013] III-E: tangent, bitangent, normal, origin at the barycentre.
pub(super) fn projection(
    points: &[Point3<f64>],
    plane: &PlaneFit,
    eye_V: &Vector3<f64>,
    forward: &Vector3<f64>,
    up: &Vector3<f64>,
) -> Projection {
    let away = plane.normal.dot(&(eye_V - plane.centroid.coords)) < 0.0;
    let normal = if away { -plane.normal } else { plane.normal };
    let R_VS = Rotation3::from_matrix_unchecked(tangent_frame(&normal, forward, up));
    let X_VS = Isometry3::from_parts(
        Translation3::from(plane.centroid),
        UnitQuaternion::from_rotation_matrix(&R_VS),
    );
    let onto = |i: &usize| X_VS.inverse_transform_point(&points[*i]).xy();
    Projection {
        points: plane.inliers.iter().map(onto).collect(),
        X_VS,
    }
}
