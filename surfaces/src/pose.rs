//! Poses as they stand in files: `{"p": [x, y, z], "quat_xyzw": [x, y, z, w]}`.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Error, beyond_world};

/// Largest distance of a quaternion's norm from 1 that counts as rounding: six decimals.
const UNIT_TOLERANCE: f64 = 2e-6;

/// Up to this the quaternion is taken as it stands, so that what was written is what is read.
const EXACT_TOLERANCE: f64 = 1e-12;

/// A pose in a file, not yet checked; an [`Isometry3`] of it is.
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

impl TryFrom<Pose> for Isometry3<f64> {
    type Error = Error;

    fn try_from(record: Pose) -> Result<Self, Error> {
        for (field, values) in [("p", &record.p[..]), ("quat_xyzw", &record.quat_xyzw[..])] {
            if let Some(value) = beyond_world(values) {
                return Err(Error::bad(field, value, "within 10 km of the origin"));
            }
        }
        let quaternion = Quaternion::from_vector(record.quat_xyzw.into());
        let norm = quaternion.norm();
        let rotation = if (norm - 1.0).abs() <= EXACT_TOLERANCE {
            UnitQuaternion::new_unchecked(quaternion)
        } else if (norm - 1.0).abs() <= UNIT_TOLERANCE {
            UnitQuaternion::new_normalize(quaternion)
        } else {
            let wrong = format!("quat_xyzw has the norm {norm}, which is not 1");
            return Err(Error::Value(wrong));
        };
        let [x, y, z] = record.p;
        Ok(Self::from_parts(Translation3::new(x, y, z), rotation))
    }
}
