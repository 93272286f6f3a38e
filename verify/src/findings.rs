//! Collects the rows while a plan is gone through.

use crate::certificate::{CERTIFICATE_FORMAT, Certificate, Row, Summary};
use crate::{Check, TOLERANCES};

/// Whether the value is above the bound, or no number at all.
pub(crate) fn exceeds(value: f64, bound: f64) -> bool {
    value.is_nan() || value > bound
}

/// A row without numbers.
fn row(stance: Option<usize>, check: Check, subject: String, pass: bool, note: String) -> Row {
    Row {
        stance,
        check,
        subject,
        value: None,
        bound: None,
        margin: None,
        pass,
        note,
    }
}

/// Rows found so far.
#[derive(Default)]
pub(crate) struct Findings {
    rows: Vec<Row>,
    conditions: Vec<String>,
    notes: Vec<String>,
}

impl Findings {
    /// Rows that were found elsewhere.
    pub fn append(&mut self, mut other: Findings) {
        self.rows.append(&mut other.rows);
        other
            .conditions
            .into_iter()
            .for_each(|what| self.condition(what));
        self.notes.append(&mut other.notes);
    }

    /// A value against its bound; what is not a number fails.
    pub fn value(
        &mut self,
        stance: Option<usize>,
        check: Check,
        subject: impl Into<String>,
        value: f64,
        bound: f64,
    ) {
        let margin = check.margin(value, bound);
        // An infinite distance from everything is no flaw; a NaN is.
        let pass = margin >= 0.0;
        let finite = |x: f64| x.is_finite().then_some(x);
        let note = match pass || value.is_finite() {
            true => String::new(),
            false => format!("the value is {value}"),
        };
        self.rows.push(Row {
            value: finite(value),
            bound: finite(bound),
            margin: finite(margin),
            ..row(stance, check, subject.into(), pass, note)
        });
    }

    /// Something that is taken from the plan as it says, in words.
    pub fn condition(&mut self, what: String) {
        if !self.conditions.contains(&what) {
            self.conditions.push(what);
        }
    }

    /// What to know beside the checks, in words.
    pub fn note(&mut self, notes: &[String]) {
        self.notes.extend_from_slice(notes);
    }

    /// Something that does not hold, in words.
    pub fn flaw(
        &mut self,
        stance: Option<usize>,
        check: Check,
        subject: impl Into<String>,
        note: impl Into<String>,
    ) {
        let flaw = row(stance, check, subject.into(), false, note.into());
        self.rows.push(flaw);
    }

    /// The check holds unless a flaw of it was noted for the stance before.
    pub fn holds_unless_flawed(&mut self, stance: Option<usize>, check: Check) {
        if !self.flawed(stance, check) {
            let (nothing, no_note) = (String::new(), String::new());
            self.rows.push(row(stance, check, nothing, true, no_note));
        }
    }

    /// Whether the check failed in the stance.
    pub fn flawed(&self, stance: Option<usize>, check: Check) -> bool {
        let mut rows = self.rows.iter();
        rows.any(|row| row.stance == stance && row.check == check && !row.pass)
    }

    /// The certificate of what was found.
    pub fn certify(self, scene: &str, robot: &str, stances: usize) -> Certificate {
        let checks = Check::ALL.iter();
        let summary = checks.filter_map(|&check| self.summarise(check)).collect();
        Certificate {
            format: CERTIFICATE_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.to_owned(),
            robot: robot.to_owned(),
            stances,
            pass: self.rows.iter().all(|row| row.pass),
            conditions: self.conditions,
            notes: self.notes,
            options: TOLERANCES,
            summary,
            rows: self.rows,
        }
    }

    fn summarise(&self, check: Check) -> Option<Summary> {
        let rows: Vec<&Row> = self.rows.iter().filter(|row| row.check == check).collect();
        // Failures before passes, then by margin; the first of equals. A row without a margin
        // has an infinite one when it passes and none at all when it fails.
        let badness = |row: &Row| {
            let without = [f64::NEG_INFINITY, f64::INFINITY][usize::from(row.pass)];
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
