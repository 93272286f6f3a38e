//! A pose as files hold it.

use nalgebra::Isometry3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A pose, written with its quaternion order in its name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Position, m.
    pub p: [f64; 3],
    /// Orientation as a unit quaternion, x y z w.
    pub quat_xyzw: [f64; 4],
}

impl From<&Isometry3<f64>> for Pose {
    fn from(pose: &Isometry3<f64>) -> Self {
        Self {
            p: pose.translation.vector.into(),
            quat_xyzw: pose.rotation.coords.into(),
        }
    }
}
