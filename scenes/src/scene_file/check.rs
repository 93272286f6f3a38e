//! What of a scene makes no sense.

use surfaces::{WORLD_M, beyond_world};

use super::{Friction, Goal, ScanSource, SceneFile, Start};
use crate::error::Error;

/// Largest deviation of a quaternion's length from 1.
const QUATERNION_TOLERANCE: f64 = 1e-6;

impl SceneFile {
    /// All that is wrong.
    pub(super) fn mistakes(&self) -> Vec<Error> {
        let wrong = &mut Vec::new();
        if self.name.is_empty() {
            wrong.push(Error::field("name", "is empty"));
        }
        let files = [&self.surfaces_file, &self.mesh_file];
        let inputs = usize::from(!self.scan.is_empty()) + files.into_iter().flatten().count();
        if inputs != 1 {
            let reason = format!("{inputs} of scan, surfaces_file and mesh_file; one is needed");
            wrong.push(Error::field("scan", reason));
        }
        for (i, scan) in self.scan.iter().enumerate() {
            scan.check(&format!("scan[{i}]"), wrong);
        }
        self.start.check(wrong);
        self.goal.check(wrong);
        if let Some(guide) = &self.guide {
            for (i, posture) in guide.key_postures.iter().enumerate() {
                within(&format!("guide.key_postures[{i}]"), posture, wrong);
            }
        }
        self.friction.check(wrong);
        std::mem::take(wrong)
    }
}

impl Start {
    fn check(&self, wrong: &mut Vec<Error>) {
        for (i, contact) in self.contact.iter().enumerate() {
            let field = format!("start.contact[{i}]");
            within(&format!("{field}.position_m"), &contact.position_m, wrong);
            within(&format!("{field}.rpy_rad"), &contact.rpy_rad, wrong);
        }
        for (joint, value) in &self.joints_rad {
            within(&format!("start.joints_rad.{joint}"), &[*value], wrong);
        }
        if !self.joints_rad.is_empty() && !self.contact.is_empty() {
            let reason = "does not go with contact: a posture is sought for these";
            wrong.push(Error::field("start.joints_rad", reason));
        }
        within("start.base_rpy_rad", &self.base_rpy_rad, wrong);
        within("start.yaw_rad", &[self.yaw_rad], wrong);
        let placed = self.base_position_m.is_some() || self.over_m.is_some();
        if self.before_floor && (placed || !self.contact.is_empty()) {
            let reason = "is in the place of base_position_m, over_m and contact";
            wrong.push(Error::field("start.before_floor", reason));
        }
        if let Some(over_m) = &self.over_m {
            if self.base_position_m.is_some() || !self.contact.is_empty() {
                let reason = "goes with posture, joints_rad, yaw_rad and contacts only";
                wrong.push(Error::field("start.over_m", reason));
            }
            return within("start.over_m", over_m, wrong);
        }
        let has_posture = self.posture.is_some() || !self.joints_rad.is_empty();
        match (has_posture, &self.base_position_m) {
            (true, Some(position)) if self.contact.is_empty() => {
                within("start.base_position_m", position, wrong);
                if self.contacts.is_empty() {
                    wrong.push(Error::field("start.contacts", "is empty"));
                }
            }
            (false, None) if self.contact.is_empty() || self.contacts.is_empty() => {}
            _ => wrong.push(Error::field(
                "start",
                "needs posture or joints_rad, base_position_m and contacts, or `over_m` or `contact` in their place",
            )),
        }
    }
}

impl ScanSource {
    fn check(&self, field: &str, wrong: &mut Vec<Error>) {
        if self.depth.is_some() == self.cloud.is_some() {
            wrong.push(Error::field(field, "needs either `depth` or `cloud`"));
        }
        let intrinsics = [self.fx, self.fy, self.cx, self.cy, self.depth_scale_m];
        let given = intrinsics.iter().flatten().count();
        if self.depth.is_some() && self.sensor.is_none() && given < intrinsics.len() {
            let reason = "a depth image needs `sensor`, or fx, fy, cx, cy and depth_scale_m";
            wrong.push(Error::field(field, reason));
        }
        // A named sensor may come with its own calibration: all of the four numbers or none.
        let calibrated = intrinsics[..4].iter().flatten().count();
        if self.sensor.is_some() && !matches!(calibrated, 0 | 4) {
            let reason = "needs all of fx, fy, cx, cy or none of them";
            wrong.push(Error::field(field, reason));
        }
        positive(&format!("{field}.fx"), self.fx, wrong);
        positive(&format!("{field}.fy"), self.fy, wrong);
        positive(&format!("{field}.depth_scale_m"), self.depth_scale_m, wrong);
        let middle = [self.cx, self.cy].map(Option::unwrap_or_default);
        within(&format!("{field}.cx, cy"), &middle, wrong);
        within(
            &format!("{field}.eye_m"),
            &self.eye_m.unwrap_or_default(),
            wrong,
        );
        within(&format!("{field}.up"), &self.up.unwrap_or_default(), wrong);
        let (position_m, quat_xyzw) = match (&self.position_m, &self.quat_xyzw, &self.extrinsics) {
            (Some(position_m), Some(quat_xyzw), None) => (position_m, quat_xyzw),
            (None, None, Some(_)) => return,
            (None, None, None) if self.level || self.frame.is_some() => return,
            _ => {
                let reason = "needs position_m and quat_xyzw, or `extrinsics` in their place";
                return wrong.push(Error::field(field, reason));
            }
        };
        within(&format!("{field}.position_m"), position_m, wrong);
        within(&format!("{field}.quat_xyzw"), quat_xyzw, wrong);
        let norm = quat_xyzw.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > QUATERNION_TOLERANCE {
            let reason = format!("has length {norm}, not 1");
            wrong.push(Error::field(format!("{field}.quat_xyzw"), reason));
        }
    }
}

impl Goal {
    fn check(&self, wrong: &mut Vec<Error>) {
        let has_posture = self.posture.is_some() || !self.joints_rad.is_empty();
        if self.base_position_m.is_none() && self.contact.is_empty() && !has_posture {
            let reason = "has neither base_position_m nor a contact nor a posture";
            wrong.push(Error::field("goal", reason));
        }
        if let Some(position) = &self.base_position_m {
            if !(2..=3).contains(&position.len()) {
                let reason = format!("has {} coordinates; x, y or x, y, z", position.len());
                wrong.push(Error::field("goal.base_position_m", reason));
            }
            within("goal.base_position_m", position, wrong);
        }
        positive("goal.tolerance_m", [self.tolerance_m], wrong);
        within("goal.yaw_rad", self.yaw_rad.as_slice(), wrong);
        for (joint, value) in &self.joints_rad {
            within(&format!("goal.joints_rad.{joint}"), &[*value], wrong);
        }
        positive(
            "goal.joint_tolerance_rad",
            [self.joint_tolerance_rad],
            wrong,
        );
        for (i, contact) in self.contact.iter().enumerate() {
            if contact.surface.is_some() == contact.point_m.is_some() {
                let reason = "needs either `surface` or `point_m`";
                wrong.push(Error::field(format!("goal.contact[{i}]"), reason));
            }
            if let Some(point) = &contact.point_m {
                within(&format!("goal.contact[{i}].point_m"), point, wrong);
            }
        }
    }
}

impl Friction {
    fn check(&self, wrong: &mut Vec<Error>) {
        positive("friction: default", self.default, wrong);
        for (name, value) in &self.patch {
            positive(&format!("friction: {name}"), [*value], wrong);
        }
    }
}

fn positive(field: &str, value: impl IntoIterator<Item = f64>, wrong: &mut Vec<Error>) {
    if !value.into_iter().all(|v| v > 0.0 && v <= WORLD_M) {
        let reason = format!("is not a positive number up to {WORLD_M}");
        wrong.push(Error::field(field, reason));
    }
}

/// Refuses what is no coordinate; angles have the same bound.
fn within(field: &str, values: &[f64], wrong: &mut Vec<Error>) {
    if let Some(value) = beyond_world(values) {
        let reason = format!("contains {value}, which is not within {WORLD_M}");
        wrong.push(Error::field(field, reason));
    }
}
