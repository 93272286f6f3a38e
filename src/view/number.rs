//! Numbers as the page carries them: no finer than they can be seen.

use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::{Value, json};

/// A length rounded to 0.1 mm.
pub(super) fn metres(x: f64) -> f64 {
    rounded(x, 1e4)
}

/// A time rounded to 1 ms.
pub(super) fn seconds(x: f64) -> f64 {
    rounded(x, 1e3)
}

/// A force rounded to 0.01 N.
pub(super) fn newtons(x: f64) -> f64 {
    rounded(x, 1e2)
}

/// Part of a unit vector, or of a unit quaternion: 1e-5 of 2 m of robot is 0.02 mm.
pub(super) fn unit(x: f64) -> f64 {
    rounded(x, 1e5)
}

fn rounded(x: f64, per_unit: f64) -> f64 {
    // The sum turns −0 into 0.
    (x * per_unit).round() / per_unit + 0.0
}

/// `[x, y, z]`, m.
pub(super) fn point(p: &Point3<f64>) -> [f64; 3] {
    [p.x, p.y, p.z].map(metres)
}

/// `[x, y, z]`, m.
pub(super) fn position(p: &Vector3<f64>) -> [f64; 3] {
    [p.x, p.y, p.z].map(metres)
}

/// `[x, y, z, qx, qy, qz, qw]`; lengths in m.
pub(super) fn pose(X_AB: &Isometry3<f64>) -> [f64; 7] {
    let [x, y, z] = position(&X_AB.translation.vector);
    let [i, j, k, w] = <[f64; 4]>::from(X_AB.rotation.coords).map(unit);
    [x, y, z, i, j, k, w]
}

/// Points of a plane.
pub(super) fn plane_points<'a>(
    points: impl IntoIterator<Item = &'a nalgebra::Point2<f64>>,
) -> Value {
    points
        .into_iter()
        .map(|p| json!([metres(p.x), metres(p.y)]))
        .collect()
}
