//! What a run has shown so far: contacts and largest values.

use nalgebra::{Isometry3, Vector3};

use crate::criteria::{Criterion, Unit};

/// What was seen of one closure.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClosureObserved {
    pub anchor: Option<Isometry3<f64>>,
    /// How far a ball has slid since then, m.
    pub slid_W: Vector3<f64>,
    /// Largest distance from where it first bore load, m.
    pub slip_m: f64,
    /// Steps from when it was to bear load to when it first did.
    pub late_steps: usize,
    /// Sum and count of the normal forces.
    pub force_sum_n: f64,
    pub steps: usize,
}

/// Largest values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Peaks {
    pub com_error_m: Peak,
    pub tilt_rad: Peak,
    pub swing_error_m: Peak,
    pub torque_use: Peak,
    pub penetration_m: Peak,
    pub vertical_sum_n: f64,
    pub steps: usize,
}

/// A largest value and where it was.
#[derive(Clone, Debug, Default)]
pub(crate) struct Peak {
    pub value: f64,
    pub detail: Option<String>,
}

impl Peak {
    /// Takes in a value; one that is no number stays.
    pub fn see(&mut self, value: f64, detail: impl FnOnce() -> String) {
        if value > self.value || !value.is_finite() {
            self.value = value;
            self.detail = Some(detail());
        }
    }

    /// The criterion that it must not exceed `bound`.
    pub fn at_most(&self, name: &str, bound: f64, unit: Unit) -> Criterion {
        Criterion::at_most(name, self.value, bound, unit).on(self.detail.clone())
    }
}

/// A contact that nothing asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unplanned {
    pub first_s: f64,
    pub steps: usize,
    pub peak_n: f64,
}
