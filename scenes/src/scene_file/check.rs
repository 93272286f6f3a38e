//! What of a scene makes no sense.

use surfaces::{WORLD_M, beyond_world};

use super::{Friction, Goal, ScanSource, SceneFile, Start};
use crate::error::Error;

/// Largest deviation of a quaternion's length from 1.
const QUATERNION_TOLERANCE: f64 = 1e-6;

impl SceneFile {
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.name.is_empty() {
            return Err(Error::field("name", "is empty"));
        }
        let files = [&self.surfaces_file, &self.mesh_file];
        let inputs = usize::from(!self.scan.is_empty()) + files.into_iter().flatten().count();
        if inputs != 1 {
            let reason = format!("{inputs} of scan, surfaces_file and mesh_file; one is needed");
            return Err(Error::field("scan", reason));
        }
        for (i, scan) in self.scan.iter().enumerate() {
            scan.check(&format!("scan[{i}]"))?;
        }
        self.start.check()?;
        self.goal.check()?;
        if let Some(guide) = &self.guide {
            for (i, posture) in guide.key_postures.iter().enumerate() {
                within(&format!("guide.key_postures[{i}]"), posture)?;
            }
        }
        self.friction.check()
    }
}

impl Start {
    fn check(&self) -> Result<(), Error> {
        for (i, contact) in self.contact.iter().enumerate() {
            let field = format!("start.contact[{i}]");
            within(&format!("{field}.position_m"), &contact.position_m)?;
            within(&format!("{field}.rpy_rad"), &contact.rpy_rad)?;
        }
        within("start.base_rpy_rad", &self.base_rpy_rad)?;
        within("start.yaw_rad", &[self.yaw_rad])?;
        if let Some(over_m) = &self.over_m {
            if self.base_position_m.is_some() || !self.contact.is_empty() {
                let reason = "goes with posture, yaw_rad and contacts only";
                return Err(Error::field("start.over_m", reason));
            }
            return within("start.over_m", over_m);
        }
        match (&self.posture, &self.base_position_m) {
            (Some(_), Some(position)) if self.contact.is_empty() => {
                within("start.base_position_m", position)?;
                if self.contacts.is_empty() {
                    return Err(Error::field("start.contacts", "is empty"));
                }
                Ok(())
            }
            (None, None) if self.contact.is_empty() || self.contacts.is_empty() => Ok(()),
            _ => Err(Error::field(
                "start",
                "needs posture, base_position_m and contacts, or `over_m` or `contact` in their place",
            )),
        }
    }
}

impl ScanSource {
    fn check(&self, field: &str) -> Result<(), Error> {
        if self.depth.is_some() == self.cloud.is_some() {
            return Err(Error::field(field, "needs either `depth` or `cloud`"));
        }
        let intrinsics = [self.fx, self.fy, self.cx, self.cy, self.depth_scale_m];
        let given = intrinsics.iter().flatten().count();
        if self.depth.is_some() && self.sensor.is_none() && given < intrinsics.len() {
            let reason = "a depth image needs `sensor`, or fx, fy, cx, cy and depth_scale_m";
            return Err(Error::field(field, reason));
        }
        // A named sensor may come with its own calibration: all of the four numbers or none.
        let calibrated = intrinsics[..4].iter().flatten().count();
        if self.sensor.is_some() && !matches!(calibrated, 0 | 4) {
            let reason = "needs all of fx, fy, cx, cy or none of them";
            return Err(Error::field(field, reason));
        }
        positive(&format!("{field}.fx"), self.fx)?;
        positive(&format!("{field}.fy"), self.fy)?;
        positive(&format!("{field}.depth_scale_m"), self.depth_scale_m)?;
        within(
            &format!("{field}.cx, cy"),
            &[self.cx, self.cy].map(Option::unwrap_or_default),
        )?;
        within(&format!("{field}.eye_m"), &self.eye_m.unwrap_or_default())?;
        within(&format!("{field}.up"), &self.up.unwrap_or_default())?;
        let (position_m, quat_xyzw) = match (&self.position_m, &self.quat_xyzw, &self.extrinsics) {
            (Some(position_m), Some(quat_xyzw), None) => (position_m, quat_xyzw),
            (None, None, Some(_)) => return Ok(()),
            (None, None, None) if self.level || self.frame.is_some() => return Ok(()),
            _ => {
                let reason = "needs position_m and quat_xyzw, or `extrinsics` in their place";
                return Err(Error::field(field, reason));
            }
        };
        within(&format!("{field}.position_m"), position_m)?;
        within(&format!("{field}.quat_xyzw"), quat_xyzw)?;
        let norm = quat_xyzw.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > QUATERNION_TOLERANCE {
            let reason = format!("has length {norm}, not 1");
            return Err(Error::field(format!("{field}.quat_xyzw"), reason));
        }
        Ok(())
    }
}

impl Goal {
    fn check(&self) -> Result<(), Error> {
        if self.base_position_m.is_none() && self.contact.is_empty() {
            let reason = "has neither base_position_m nor a contact";
            return Err(Error::field("goal", reason));
        }
        if let Some(position) = &self.base_position_m {
            if !(2..=3).contains(&position.len()) {
                let reason = format!("has {} coordinates; x, y or x, y, z", position.len());
                return Err(Error::field("goal.base_position_m", reason));
            }
            within("goal.base_position_m", position)?;
        }
        positive("goal.tolerance_m", [self.tolerance_m])?;
        within("goal.yaw_rad", self.yaw_rad.as_slice())?;
        for (i, contact) in self.contact.iter().enumerate() {
            if contact.surface.is_some() == contact.point_m.is_some() {
                let reason = "needs either `surface` or `point_m`";
                return Err(Error::field(format!("goal.contact[{i}]"), reason));
            }
            if let Some(point) = &contact.point_m {
                within(&format!("goal.contact[{i}].point_m"), point)?;
            }
        }
        Ok(())
    }
}

impl Friction {
    fn check(&self) -> Result<(), Error> {
        positive("friction: default", self.default)?;
        let mut patches = self.patch.iter();
        patches.try_for_each(|(name, value)| positive(&format!("friction: {name}"), [*value]))
    }
}

fn positive(field: &str, value: impl IntoIterator<Item = f64>) -> Result<(), Error> {
    match value.into_iter().all(|v| v > 0.0 && v <= WORLD_M) {
        true => Ok(()),
        false => Err(Error::field(
            field,
            format!("is not a positive number up to {WORLD_M}"),
        )),
    }
}

/// Refuses what is no coordinate; angles have the same bound.
fn within(field: &str, values: &[f64]) -> Result<(), Error> {
    match beyond_world(values) {
        Some(value) => {
            let reason = format!("contains {value}, which is not within {WORLD_M}");
            Err(Error::field(field, reason))
        }
        None => Ok(()),
    }
}
