//! Where a limb goes between two places: up from the first, over, down on the second.

use nalgebra::{Isometry3, Vector3};

/// How high over the higher of its two places a limb swings, m.
const HEIGHT_M: f64 = 0.05;
/// How far a limb leaves and approaches a surface along the normal, m.
const APPROACH_M: f64 = 0.03;
/// Surfaces steeper than this (cosine of the tilt) are left and met along their normal only.
const FLOOR_COS: f64 = 0.5;

/// Offsets of three points from their places, each in the frame that it is an offset from, m.
pub(super) struct Swing {
    /// From the first place, in its frame.
    pub withdraw: Vector3<f64>,
    /// From half way between, in the frame half way between.
    pub middle: Vector3<f64>,
    /// From the second place, in its frame.
    pub approach: Vector3<f64>,
}

/// The offset to where a limb comes from or goes to in the air, in the place's frame.
pub(super) fn off_surface() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, APPROACH_M)
}

/// A swing at one height, over the higher of the two places.
pub(super) fn between(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Swing {
    let top = from.translation.z.max(to.translation.z) + HEIGHT_M;
    let normal = |pose: &Isometry3<f64>| pose.rotation * Vector3::z();
    let lifted = |pose: &Isometry3<f64>| {
        let mut offset_W = APPROACH_M * normal(pose);
        if normal(pose).z > FLOOR_COS {
            offset_W.z = offset_W.z.max(top - pose.translation.z);
        }
        pose.rotation.inverse() * offset_W
    };
    let half_way = from.lerp_slerp(to, 0.5);
    let middle_W = if normal(from).z > FLOOR_COS && normal(to).z > FLOOR_COS {
        Vector3::new(0.0, 0.0, top - half_way.translation.z)
    } else {
        // Away from both surfaces.
        let away = normal(from) + normal(to);
        HEIGHT_M * away.try_normalize(1e-6).unwrap_or_else(Vector3::z)
    };
    Swing {
        withdraw: lifted(from),
        middle: half_way.rotation.inverse() * middle_W,
        approach: lifted(to),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    #[test]
    fn a_step_up_goes_over_the_edge() {
        let from = Isometry3::from_parts(
            Vector3::new(0.0, 0.1, 0.0).into(),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7),
        );
        let to = Isometry3::translation(0.3, 0.1, 0.2);
        let swing = between(&from, &to);
        let half_way = from.lerp_slerp(&to, 0.5);
        for (place, offset) in [
            (&from, swing.withdraw),
            (&half_way, swing.middle),
            (&to, swing.approach),
        ] {
            let z = (place * nalgebra::Point3::from(offset)).z;
            assert!((z - 0.25).abs() < 1e-12, "{z}");
        }
    }

    #[test]
    fn a_wall_is_left_along_its_normal() {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -1.5);
        let from = Isometry3::from_parts(Vector3::new(0.0, -0.5, 1.0).into(), turn);
        let to = Isometry3::from_parts(Vector3::new(0.3, -0.5, 1.0).into(), turn);
        let swing = between(&from, &to);
        assert!((swing.withdraw - Vector3::new(0.0, 0.0, APPROACH_M)).norm() < 1e-12);
        assert!((swing.middle - Vector3::new(0.0, 0.0, HEIGHT_M)).norm() < 1e-12);
    }
}
