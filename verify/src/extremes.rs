//! The worst value of each check, of many that are not worth a row each.

use std::collections::BTreeMap;

use crate::Check;
use crate::findings::Findings;

/// For each check the worst margin, with its value, its bound and of what it is.
#[derive(Default)]
pub(crate) struct Extremes {
    of: BTreeMap<Check, (f64, f64, f64, String)>,
}

impl Extremes {
    /// Takes a value against its bound in, if none so far is worse.
    pub fn add(&mut self, check: Check, value: f64, bound: f64, subject: impl FnOnce() -> String) {
        let (margin, worst) = (check.margin(value, bound), self.margin(check));
        // What is not a number is the worst of all.
        let worse = margin < worst || (margin.is_nan() && !worst.is_nan());
        if worse || !self.of.contains_key(&check) {
            self.of.insert(check, (margin, value, bound, subject()));
        }
    }

    /// The worst margin so far; infinite before any.
    pub fn margin(&self, check: Check) -> f64 {
        self.of.get(&check).map_or(f64::INFINITY, |worst| worst.0)
    }

    /// The worst value so far; infinite before any.
    pub fn value(&self, check: Check) -> f64 {
        self.of.get(&check).map_or(f64::INFINITY, |worst| worst.1)
    }

    /// A row a check.
    pub fn report(self, stance: Option<usize>, findings: &mut Findings) {
        for (check, (_, value, bound, subject)) in self.of {
            findings.value(stance, check, subject, value, bound);
        }
    }
}
