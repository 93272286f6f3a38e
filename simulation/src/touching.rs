//! What the controller takes to touch: the forces at the patches, and what was planned.

use robot_model::Robot;

use crate::reference::ReferenceState;
use crate::verdict::contact_n;

/// Which patches touch, as force sensors tell, with some patience against chatter.
pub(crate) struct Touching {
    now: Vec<bool>,
    all: Vec<bool>,
    unloaded_s: Vec<f64>,
    /// Which patches in the air have left what they stood on.
    left: Vec<bool>,
    /// Normal force from which on a patch is taken to touch, N.
    touches_n: f64,
}

/// A contact that bears nothing for this long is lost, s.
const LOST_AFTER_S: f64 = 0.05;

impl Touching {
    /// At the start what is to touch does.
    pub fn new(robot: &Robot, start: &ReferenceState) -> Self {
        let mut now = vec![false; robot.patches.len()];
        for contact in &start.contacts {
            now[contact.patch] = true;
        }
        Self {
            all: vec![true; now.len()],
            unloaded_s: vec![0.0; now.len()],
            left: vec![false; now.len()],
            touches_n: contact_n(robot),
            now,
        }
    }

    /// Which patches touch.
    pub fn now(&self) -> &[bool] {
        &self.now
    }

    /// As if every patch touched.
    pub fn all(&self) -> &[bool] {
        &self.all
    }

    /// `lands` says whether the patch in the air would land early if it touched now.
    pub fn update(&mut self, normal_n: &[f64], wanted: &ReferenceState, lands: bool, dt_s: f64) {
        for (patch, &force) in normal_n.iter().enumerate() {
            let planned = wanted.contacts.iter().any(|c| c.patch == patch);
            self.unloaded_s[patch] = if force > 0.0 {
                0.0
            } else {
                self.unloaded_s[patch] + dt_s
            };
            let lost = self.unloaded_s[patch] > LOST_AFTER_S;
            self.left[patch] = !planned && (self.left[patch] || lost);
            // Once down, it stays down.
            let swings = self.left[patch] && wanted.swing == Some(patch);
            let early = swings && (lands || self.now[patch]);
            if lost || !(planned || early) {
                self.now[patch] = false;
            } else if force >= self.touches_n {
                self.now[patch] = true;
            }
        }
    }
}
