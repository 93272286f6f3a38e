//! Exported plans as the controller of mc_rtc reads and plays them.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use plan::{Change, Plan};
use serde_json::Value;

use super::program::{list, number};

/// Files are written to a micrometre and a microradian; turned about, some of them add up.
pub const ROUNDED: f64 = 3e-6;

/// The commands of the steps.
pub fn steps(document: &Value) -> &[Value] {
    list(&document["states"]["MCC::ConfigMotion_"]["configs"]["stepCommandList"])
}

pub fn triple(value: &Value) -> Vector3<f64> {
    assert_eq!(list(value).len(), 3);
    Vector3::from_iterator(list(value).iter().map(number))
}

#[track_caller]
pub fn assert_same_place(a: &Isometry3<f64>, b: &Isometry3<f64>) {
    let off = a.inverse() * b;
    let (shift, turn) = (off.translation.vector.norm(), off.rotation.angle());
    assert!(shift < ROUNDED && turn < ROUNDED, "{shift} m, {turn} rad");
}

/// A pose as mc_rtc reads it: three angles give the transpose E = RotX(r) RotY(p) RotZ(y) of
/// passive rotations, and the pose's rotation in the world is Eᵀ.
pub fn pose(value: &Value) -> Isometry3<f64> {
    let [r, p, y] = triple(&value["rotation"]).into();
    let rot_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, r.cos(), r.sin(), 0.0, -r.sin(), r.cos());
    let rot_y = Matrix3::new(p.cos(), 0.0, -p.sin(), 0.0, 1.0, 0.0, p.sin(), 0.0, p.cos());
    let rot_z = Matrix3::new(y.cos(), y.sin(), 0.0, -y.sin(), y.cos(), 0.0, 0.0, 0.0, 1.0);
    let R = Rotation3::from_matrix_unchecked((rot_x * rot_y * rot_z).transpose());
    let turn = UnitQuaternion::from_rotation_matrix(&R);
    Isometry3::from_parts(triple(&value["translation"]).into(), turn)
}

/// Limbs in contact and where, as the controller keeps them.
pub type Touching = BTreeMap<String, Isometry3<f64>>;

/// Plays the step commands: at which times which limbs touch.
pub fn play(document: &Value, start: Touching) -> Vec<(f64, Touching)> {
    // (time, limb, the new place or none), as the controller expands its simple form.
    let mut events: Vec<(f64, String, Option<Isometry3<f64>>)> = Vec::new();
    let mut busy: BTreeMap<String, f64> = BTreeMap::new();
    for step in steps(document) {
        let limb = step["limb"].as_str().unwrap().to_owned();
        let [from, to] = ["startTime", "endTime"].map(|key| number(&step[key]));
        assert!(from < to, "{step}");
        // The controller drops a command that begins before the limb's last one ended.
        assert!(*busy.get(&limb).unwrap_or(&0.0) < from, "{step}");
        busy.insert(limb.clone(), to);
        events.push((from, limb.clone(), None));
        match step["type"].as_str().unwrap() {
            "Add" => {
                assert_eq!(step["constraint"]["type"], "Surface");
                events.push((to, limb, Some(pose(&step["pose"]))));
            }
            "Remove" => assert!(step.get("pose").is_none() && step.get("constraint").is_none()),
            other => panic!("{other}"),
        }
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut touching = start;
    let mut history = vec![(0.0, touching.clone())];
    for (time, limb, place) in events {
        match place {
            Some(place) => drop(touching.insert(limb, place)),
            None => drop(touching.remove(&limb)),
        }
        history.push((time, touching.clone()));
    }
    history
}

pub fn limb(patch: &str) -> String {
    match patch {
        "left_foot" => "LeftFoot".to_owned(),
        "right_foot" => "RightFoot".to_owned(),
        other => panic!("{other}"),
    }
}

/// The contact sets of the plan, in order.
pub fn planned(plan: &Plan) -> Vec<Touching> {
    let mut touching = Touching::new();
    let mut sets = Vec::new();
    for stance in &plan.stances {
        let place = |patch: &str| {
            let contact = stance.contacts.iter().find(|c| c.patch == patch).unwrap();
            let turn = UnitQuaternion::new_normalize(contact.X_WC.quat_xyzw.into());
            Isometry3::from_parts(contact.X_WC.p.into(), turn)
        };
        match &stance.change {
            Change::Start => {
                for contact in &stance.contacts {
                    touching.insert(limb(&contact.patch), place(&contact.patch));
                }
            }
            Change::Add { patch, .. } => drop(touching.insert(limb(patch), place(patch))),
            Change::Remove { patch, .. } => drop(touching.remove(&limb(patch))),
            Change::Goal => continue,
        }
        sets.push(touching.clone());
    }
    sets
}
