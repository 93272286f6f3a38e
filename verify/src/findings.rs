//! Collects the rows while a plan is gone through.

use crate::certificate::{CERTIFICATE_FORMAT, Certificate, Row, Summary};
use crate::{Check, Options, Sense};

/// Whether the value is above the bound, or no number at all.
pub(crate) fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}

/// Rows found so far.
#[derive(Default)]
pub(crate) struct Findings {
    rows: Vec<Row>,
}

impl Findings {
    /// A value against its bound; what is not a number fails.
    pub fn value(
        &mut self,
        stance: Option<usize>,
        check: Check,
        subject: impl Into<String>,
        value: f64,
        bound: f64,
    ) {
        let margin = match check.sense() {
            Sense::AtMost => bound - value,
            _ => value - bound,
        };
        let finite = |x: f64| x.is_finite().then_some(x);
        // An infinite distance from everything is no flaw; a NaN is.
        let pass = margin >= 0.0;
        let note = if pass || finite(value).is_some() {
            String::new()
        } else {
            format!("the value is {value}")
        };
        self.rows.push(Row {
            stance,
            check,
            subject: subject.into(),
            value: finite(value),
            bound: finite(bound),
            margin: finite(margin),
            pass,
            note,
        });
    }

    /// Something that does not hold, in words.
    pub fn flaw(
        &mut self,
        stance: Option<usize>,
        check: Check,
        subject: impl Into<String>,
        note: impl Into<String>,
    ) {
        self.rows.push(Row {
            stance,
            check,
            subject: subject.into(),
            value: None,
            bound: None,
            margin: None,
            pass: false,
            note: note.into(),
        });
    }

    /// The check holds unless a flaw of it was noted for the stance before.
    pub fn holds_unless_flawed(&mut self, stance: Option<usize>, check: Check) {
        if !self.flawed(stance, check) {
            self.rows.push(Row {
                stance,
                check,
                subject: String::new(),
                value: None,
                bound: None,
                margin: None,
                pass: true,
                note: String::new(),
            });
        }
    }

    /// Whether the check failed in the stance.
    pub fn flawed(&self, stance: Option<usize>, check: Check) -> bool {
        self.rows
            .iter()
            .any(|row| row.stance == stance && row.check == check && !row.pass)
    }

    /// The certificate of what was found.
    pub fn certify(
        self,
        scene: &str,
        robot: &str,
        stances: usize,
        options: &Options,
    ) -> Certificate {
        let summary = Check::ALL
            .into_iter()
            .filter_map(|check| self.summarise(check))
            .collect();
        Certificate {
            format: CERTIFICATE_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.to_owned(),
            robot: robot.to_owned(),
            stances,
            pass: self.rows.iter().all(|row| row.pass),
            options: options.clone(),
            summary,
            rows: self.rows,
        }
    }

    fn summarise(&self, check: Check) -> Option<Summary> {
        let rows: Vec<&Row> = self.rows.iter().filter(|row| row.check == check).collect();
        // Failures before passes, then by margin; the first of equals. A row without a margin
        // has an infinite one when it passes and none at all when it fails.
        let badness = |row: &Row| {
            let without = if row.pass {
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            };
            (row.pass, row.margin.unwrap_or(without))
        };
        let worst = rows.iter().min_by(|a, b| {
            let (a, b) = (badness(a), badness(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })?;
        Some(Summary {
            check,
            rows: rows.len(),
            failed: rows.iter().filter(|row| !row.pass).count(),
            worst: (*worst).clone(),
        })
    }
}
