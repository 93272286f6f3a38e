//! Where a ball is that rolls on a face.

use nalgebra::{Matrix4, Rotation3, UnitQuaternion, Vector3};
use plan::Contact;
use robot_model::ContactPatch;
use surfaces::Face;

use crate::posture::{column, pose};

/// Where the centre of a contact's ball is if it has rolled without sliding from where it stood, its link being at a pose,
/// in W, m; nothing of what does not roll:
///
///   p = p₀ + r θ × n,   θ = log(R R₀ᵀ)
pub(crate) fn centre_W(
    contact: &Contact,
    patch: &ContactPatch,
    face: &Face,
    X_WB: &Matrix4<f64>,
) -> Option<Vector3<f64>> {
    let (from, radius) = (contact.rolls_from?, patch.point_radius_m()?);
    let stood = pose(&from.p, &from.quat_xyzw);
    let turn = X_WB.fixed_view::<3, 3>(0, 0) * stood.fixed_view::<3, 3>(0, 0).transpose();
    // By way of a quaternion: a small angle has no cosine that tells it.
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    let turn = turn.scaled_axis();
    Some(column(&stood, 3) + radius * turn.cross(&normal_W(face)))
}

/// Where a contact's ball touched when it came to stand, in W, m; nothing of what does not roll.
pub(crate) fn stood_W(
    contact: &Contact,
    patch: &ContactPatch,
    face: &Face,
) -> Option<Vector3<f64>> {
    let (from, radius) = (contact.rolls_from?, patch.point_radius_m()?);
    Some(Vector3::from(from.p) - radius * normal_W(face))
}

fn normal_W(face: &Face) -> Vector3<f64> {
    column(&face.X_WF.to_homogeneous(), 2)
}
