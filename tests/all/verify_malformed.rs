//! Whatever stands in a plan file, the verifier answers; and what is moved, it notices.
use plan::Plan;
use proptest::prelude::*;
use robot_model::Robot;
use serde_json::Value;
use verify::{Certificate, verify};

use crate::support::biped;

/// A place in a JSON document and what is put there.
#[derive(Clone, Debug)]
struct Edit {
    /// At each level the member to descend to, modulo their number.
    path: Vec<usize>,
    change: Change,
}

#[derive(Clone, Debug)]
enum Change {
    Put(Value),
    Remove,
    Double,
    /// Multiplies a number.
    Scale(f64),
}

fn edits() -> impl Strategy<Value = Edit> {
    let number = prop_oneof![
        any::<f64>().prop_filter("JSON has no other numbers", |x| x.is_finite()),
        Just(0.0),
        Just(-1.0),
        Just(1e300),
        Just(1e-300),
        Just(9.9e3),
    ];
    let change = prop_oneof![
        number.clone().prop_map(|x| Change::Put(x.into())),
        any::<u64>().prop_map(|n| Change::Put(n.into())),
        Just(Change::Put(Value::Null)),
        Just(Change::Put(Value::Array(Vec::new()))),
        Just(Change::Put(Value::Bool(true))),
        "[a-z_]{0,8}".prop_map(|text| Change::Put(text.into())),
        Just(Change::Remove),
        Just(Change::Double),
        number.prop_map(Change::Scale),
    ];
    (prop::collection::vec(0..40_usize, 1..8), change)
        .prop_map(|(path, change)| Edit { path, change })
}

/// Applies the edit where its path ends, or at the leaf that it runs into.
fn apply(value: &mut Value, path: &[usize], change: &Change) {
    let Some((&step, rest)) = path.split_first() else {
        return;
    };
    let children = match value {
        Value::Array(items) => items.len(),
        Value::Object(members) => members.len(),
        _ => 0,
    };
    if children == 0 {
        return;
    }
    let index = step % children;
    let child = match &mut *value {
        Value::Array(items) => items.get_mut(index),
        Value::Object(members) => members.values_mut().nth(index),
        _ => None,
    };
    let child = child.expect("there are that many");
    if !rest.is_empty() && (child.is_array() || child.is_object()) {
        return apply(child, rest, change);
    }
    match change {
        Change::Put(new) => *child = new.clone(),
        Change::Scale(factor) => {
            let scaled = child.as_f64().map(|number| number * factor);
            if let Some(scaled) = scaled.filter(|x| x.is_finite()) {
                *child = scaled.into();
            }
        }
        Change::Remove | Change::Double => match value {
            Value::Array(items) if matches!(change, Change::Remove) => drop(items.remove(index)),
            Value::Array(items) => items.insert(index, items[index].clone()),
            Value::Object(members) => {
                let key = members.keys().nth(index).cloned();
                key.and_then(|key| members.remove(&key));
            }
            _ => {}
        },
    }
}

fn certify(plan: &Plan, robot: &Robot) -> Certificate {
    let certificate = verify(plan, None, robot);
    // What was found can always be shown and written.
    assert!(!certificate.table().is_empty());
    let written = certificate.to_json().unwrap();
    assert_eq!(
        serde_json::from_str::<Certificate>(&written).unwrap(),
        certificate
    );
    certificate
}

#[test]
fn a_plan_written_and_read_again_passes() {
    let text = serde_json::to_string(&biped::plan()).unwrap();
    let plan: Plan = serde_json::from_str(&text).unwrap();
    assert!(certify(&plan, &biped::robot()).pass);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

    /// Files that still read as plans are answered, whatever was done to them.
    #[test]
    fn no_edited_file_makes_it_panic(edits in prop::collection::vec(edits(), 1..4)) {
        let mut value = serde_json::to_value(biped::plan()).unwrap();
        for edit in &edits {
            apply(&mut value, &edit.path, &edit.change);
        }
        if let Ok(plan) = serde_json::from_value::<Plan>(value) {
            certify(&plan, &biped::robot());
        }
    }

    /// Numbers that JSON cannot hold, in plans that were never written.
    #[test]
    fn no_number_makes_it_panic(
        stance in 0..6_usize,
        place in 0..10_usize,
        entry in 0..17_usize,
        number in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-f64::INFINITY), any::<f64>()],
    ) {
        let mut plan = biped::plan();
        let stance = &mut plan.stances[stance];
        let contact = &mut stance.contacts[entry % 2];
        match place {
            0 => stance.q[entry] = number,
            1 => stance.com_W[entry % 3] = number,
            2 => contact.X_WC.p[entry % 3] = number,
            3 => contact.X_WC.quat_xyzw[entry % 4] = number,
            4 => contact.friction = number,
            5 => contact.vertices_W[entry % 4][entry % 3] = number,
            6 => plan.faces[entry % 2].X_WF.translation.vector[entry % 3] = number,
            7 => plan.faces[entry % 2].depth_m = number,
            8 => plan.faces[entry % 2].region.edges_mut().flatten().for_each(|e| e.further_m = number),
            _ => plan.thin_body_m = number,
        }
        let certificate = certify(&plan, &biped::robot());
        prop_assert!(number.is_finite() || !certificate.pass);
    }

    /// No joint of no stance can be elsewhere by a degree, and the base by no five millimetres.
    #[test]
    fn a_posture_that_is_not_the_planned_one_fails(
        stance in 0..6_usize,
        entry in 0..17_usize,
        by in prop_oneof![0.0175..0.3, -0.3..-0.0175],
    ) {
        let mut plan = biped::plan();
        plan.stances[stance].q[entry] += by;
        prop_assert!(!certify(&plan, &biped::robot()).pass);
    }

    /// No force can be another by 5 N without the balance noticing.
    #[test]
    fn a_force_that_is_not_the_planned_one_fails(
        stance in 0..6_usize,
        contact in 0..2_usize,
        corner in 0..4_usize,
        axis in 0..3_usize,
        by in prop_oneof![5.0..200.0, -200.0..-5.0],
    ) {
        let mut plan = biped::plan();
        let contact = &mut plan.stances[stance].contacts[contact];
        if let Some(force) = contact.forces_W.get_mut(corner) {
            force[axis] += by;
            prop_assert!(!certify(&plan, &biped::robot()).pass);
        }
    }
}
