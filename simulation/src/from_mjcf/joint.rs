//! Joints between bodies, and the links without mass between several.

use mujoco_rs::prelude::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use serde_json::{Value, json};

use super::drive::{self, Drive};
use super::{Writer, body_name, isometry, numbers, origin};

/// What stands for a limit that is not stated: more than any reader takes for one.
const ENDLESS: f64 = 1e9;

impl Writer<'_> {
    /// The joints between a body and its parent, a link without mass after each but the last.
    ///
    ///   X_PB(q) = X_PB ∏ T(p) exp(a (q − q₀)) T(−p),  anchors p, axes a, values q₀ of the model's pose
    pub(super) fn chain(&mut self, body: usize, name: &str) {
        let model = self.model;
        let mut parent = body_name(model, model.body_parentid()[body] as usize);
        let mut X_PB = isometry(&model.body_pos()[body], &model.body_quat()[body]);
        let joints = self.joints_of(body);
        for joint in joints.clone() {
            let (kind, axis) = (
                model.jnt_type()[joint],
                Vector3::from(model.jnt_axis()[joint]),
            );
            let hinge = kind == MjtJoint::mjJNT_HINGE;
            let at = self.joint_name(joint);
            if !hinge && kind != MjtJoint::mjJNT_SLIDE {
                self.note("ball joints are locked", at);
                continue;
            }
            let anchor = Vector3::from(model.jnt_pos()[joint]) * f64::from(u8::from(hinge));
            let moved = |by: f64| -> Isometry3<f64> {
                match hinge {
                    true => nalgebra::convert(UnitQuaternion::from_axis_angle(
                        &UnitVector3::new_normalize(axis),
                        by,
                    )),
                    false => Translation3::from(axis * by).into(),
                }
            };
            let rest = model.qpos0()[model.jnt_qposadr()[joint] as usize];
            let out: Isometry3<f64> = Translation3::from(anchor).into();
            if self.drives[joint] == Drive::None {
                let [lower, upper] = model.jnt_range()[joint];
                let value = match model.jnt_limited()[joint] {
                    true => rest.clamp(lower, upper),
                    false => rest,
                };
                self.note(
                    "joints without an actuator are locked",
                    format!("{at} at {value}"),
                );
                X_PB *= out * moved(value - rest) * out.inverse();
                continue;
            }
            let centred = anchor.norm() < 1e-9;
            let link = match centred && joint + 1 == joints.end {
                true => name.to_owned(),
                false => format!("{name}/{at}"),
            };
            let X_PC = X_PB * out * moved(-rest);
            self.joints
                .push(self.moving(joint, hinge, &parent, &link, &X_PC));
            if link == name {
                return;
            }
            self.links.push(json!({ "name": link }));
            (parent, X_PB) = (link, out.inverse());
        }
        self.joints.push(fixed(&parent, name, &X_PB));
    }

    fn moving(
        &self,
        joint: usize,
        hinge: bool,
        parent: &str,
        link: &str,
        X_PC: &Isometry3<f64>,
    ) -> Value {
        let model = self.model;
        let limited = model.jnt_limited()[joint];
        let kind = match (hinge, limited) {
            (true, true) => "revolute",
            (true, false) => "continuous",
            (false, _) => "prismatic",
        };
        let [lower, upper] = match limited {
            true => model.jnt_range()[joint],
            false => [-ENDLESS, ENDLESS],
        };
        let effort = match self.drives[joint] {
            Drive::Within(effort) if effort.is_finite() => Some(effort.to_string()),
            _ => None,
        };
        let mimic = drive::leader(model, joint).map(|(leader, multiplier, offset)| {
            json!({ "joint": self.joint_name(leader), "multiplier": multiplier.to_string(), "offset": offset.to_string() })
        });
        json!({
            "name": self.joint_name(joint),
            "kind": kind,
            "parent": parent,
            "child": link,
            "origin": origin(X_PC),
            "axis": numbers(&model.jnt_axis()[joint]),
            "lower": lower.to_string(),
            "upper": upper.to_string(),
            "effort": effort,
            "mimic": mimic,
        })
    }
}

/// A joint that does not move.
pub(super) fn fixed(parent: &str, child: &str, X_PC: &Isometry3<f64>) -> Value {
    json!({ "name": format!("{child} (fixed)"), "kind": "fixed", "parent": parent, "child": child, "origin": origin(X_PC) })
}
