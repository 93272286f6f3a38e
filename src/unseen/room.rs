//! A room of which a camera sees what is ahead: for tests.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use scenes::simulator::{DepthNoise, Scan, XTION, scan};
use scenes::truth::{OrientedBox, Truth};

/// What a camera over the origin, turned by `yaw_rad` from x, sees of a floor and of a wall along its left side, whose
/// plane is at y = `wall_m`; and its pose in W.
pub(crate) fn half_a_room(wall_m: f64, yaw_rad: f64) -> (Scan, Isometry3<f64>) {
    let cuboid = |name: &str, middle: [f64; 3], size| {
        OrientedBox::new(name, middle.into(), size, Rotation3::identity())
    };
    let truth = Truth {
        scene: "room".into(),
        boxes: vec![
            cuboid("wall", [0.0, wall_m + 0.1, 1.0], [10.0, 0.2, 2.0]),
            cuboid("floor", [0.0, 0.0, -0.1], [20.0, 8.0, 0.2]),
        ],
    };
    let level = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw_rad)
        * Rotation3::from_matrix_unchecked(level)
        * Rotation3::from_axis_angle(&Vector3::x_axis(), -0.6);
    let X_WV = Isometry3::from_parts(
        Translation3::new(0.08, 0.0, 1.3),
        UnitQuaternion::from_rotation_matrix(&turn),
    );
    let image = scan(&truth.world(), &XTION, &X_WV, &DepthNoise::default(), 7);
    (image, X_WV)
}
