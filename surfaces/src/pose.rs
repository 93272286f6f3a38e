//! Poses as they stand in files: `{"p": [x, y, z], "quat_xyzw": [x, y, z, w]}`.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::{Error, beyond_world};

/// Largest distance of a quaternion's norm from 1 that counts as rounding: six decimals.
const UNIT_TOLERANCE: f64 = 2e-6;

/// Up to this the quaternion is taken as it stands, so that what was written is what is read.
const EXACT_TOLERANCE: f64 = 1e-12;

/// A pose in a file, not yet checked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseRecord {
    /// Position, m.
    p: [f64; 3],
    /// Orientation as a unit quaternion, x y z w.
    quat_xyzw: [f64; 4],
}

impl From<&Isometry3<f64>> for PoseRecord {
    fn from(pose: &Isometry3<f64>) -> Self {
        Self {
            p: pose.translation.vector.into(),
            quat_xyzw: pose.rotation.coords.into(),
        }
    }
}

impl TryFrom<PoseRecord> for Isometry3<f64> {
    type Error = Error;

    fn try_from(record: PoseRecord) -> Result<Self, Error> {
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
            return Err(Error::NonUnitQuaternion { norm });
        };
        let [x, y, z] = record.p;
        Ok(Self::from_parts(Translation3::new(x, y, z), rotation))
    }
}

/// Writes a pose; for `#[serde(with = "surfaces::pose")]`.
///
/// # Errors  those of the serializer.
pub fn serialize<S: Serializer>(pose: &Isometry3<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    PoseRecord::from(pose).serialize(serializer)
}

/// Reads a pose; for `#[serde(with = "surfaces::pose")]`.
///
/// # Errors  when a number is not finite or the quaternion is not a unit one.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Isometry3<f64>, D::Error> {
    PoseRecord::deserialize(deserializer)?
        .try_into()
        .map_err(serde::de::Error::custom)
}
