//! When which patch is to touch.

use nalgebra::Vector3;

use crate::reference::{Reference, ReferenceContact, ReferenceState};

/// The times at which a patch is to touch without a break.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closure {
    /// Index of the robot's patch.
    pub patch: usize,
    /// Where its frame C is to be, in W, m.
    pub place_W: Vector3<f64>,
    /// From when, s.
    pub start_s: f64,
    /// Until when, s; infinite where it stays closed to the end.
    pub end_s: f64,
    /// From when it is to bear more than a given force, s; `None` where it never is.
    pub loaded_from_s: Option<f64>,
}

impl Closure {
    /// A contact that closes at a time, to bear nothing and to the end for all that is known yet.
    pub fn new(contact: &ReferenceContact, start_s: f64) -> Self {
        Self {
            patch: contact.patch,
            place_W: contact.X_WC.translation.vector,
            start_s,
            end_s: f64::INFINITY,
            loaded_from_s: None,
        }
    }
}

/// Time between two looks at a reference, s.
const STEP_S: f64 = 0.005;

/// Every closure of a reference in the order of its start; loaded is what bears `load_n`.
pub fn closures(reference: &impl Reference, start: &ReferenceState, load_n: f64) -> Vec<Closure> {
    let mut wanted = start.clone();
    let mut all: Vec<Closure> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let steps = (reference.duration_s() / STEP_S).ceil() as usize;
    for k in 0..=steps {
        let t = (k as f64 * STEP_S).min(reference.duration_s());
        reference.at(t, &mut wanted);
        open.retain(|&index| {
            let closure = &mut all[index];
            let stays = wanted.contacts.iter().any(|c| c.patch == closure.patch);
            if !stays {
                closure.end_s = t;
            }
            stays
        });
        for contact in &wanted.contacts {
            let known = open.iter().find(|&&i| all[i].patch == contact.patch);
            let index = known.copied().unwrap_or_else(|| {
                all.push(Closure::new(contact, t));
                open.push(all.len() - 1);
                all.len() - 1
            });
            if all[index].loaded_from_s.is_none() && contact.normal_n() > load_n {
                all[index].loaded_from_s = Some(t);
            }
        }
    }
    all
}
