//! The worst value of each check, of many that are not worth a row each.

use crate::Check;
use crate::findings::Findings;

/// For each check the worst margin, with its value, its bound and of what it is.
#[derive(Default)]
pub(crate) struct Extremes {
    of: Vec<(Check, f64, f64, f64, String)>,
}

impl Extremes {
    /// Takes a value against its bound in, if none so far is worse.
    pub fn add(&mut self, check: Check, value: f64, bound: f64, subject: impl FnOnce() -> String) {
        let margin = check.margin(value, bound);
        let worst = self.of.iter_mut().find(|worst| worst.0 == check);
        match worst {
            // What is not a number is the worst of all.
            Some(worst) if margin < worst.1 || (margin.is_nan() && !worst.1.is_nan()) => {
                *worst = (check, margin, value, bound, subject());
            }
            Some(_) => {}
            None => self.of.push((check, margin, value, bound, subject())),
        }
    }

    fn worst(&self, check: Check) -> [f64; 2] {
        let mut all = self.of.iter();
        let worst = all.find(|worst| worst.0 == check);
        worst.map_or([f64::INFINITY; 2], |worst| [worst.1, worst.2])
    }

    /// The worst margin so far; infinite before any.
    pub fn margin(&self, check: Check) -> f64 {
        self.worst(check)[0]
    }

    /// The worst value so far; infinite before any.
    pub fn value(&self, check: Check) -> f64 {
        self.worst(check)[1]
    }

    /// A row a check.
    pub fn report(mut self, stance: Option<usize>, findings: &mut Findings) {
        self.of.sort_by_key(|worst| worst.0);
        for (check, _, value, bound, subject) in self.of {
            findings.value(stance, check, subject, value, bound);
        }
    }
}
