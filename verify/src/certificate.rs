//! What was found: a row a check, the worst of each, and whether all of them pass.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Check, Options, Sense};

/// The value of [`Certificate::format`] that this version writes.
pub const CERTIFICATE_FORMAT: &str = "scandent-certificate/2";

/// The result of [`verify`](crate::verify): every check with its value, its bound and its verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// Always [`CERTIFICATE_FORMAT`].
    pub format: String,
    /// Version of the program that verified.
    pub version: String,
    /// The plan's scene.
    pub scene: String,
    /// The robot it was verified with.
    pub robot: String,
    /// Number of stances.
    pub stances: usize,
    /// Whether every row passes.
    pub pass: bool,
    /// What is taken from the plan as it says, or was seen by no view: it passes if these are so.
    pub conditions: Vec<String>,
    /// What to know beside the checks: where the robot moves through space that no view looked through.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The tolerances.
    pub options: Options,
    /// The worst row of every check that was made.
    pub summary: Vec<Summary>,
    /// Every row.
    pub rows: Vec<Row>,
}

/// One check of one thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// The stance; `None` for what concerns the whole plan.
    pub stance: Option<usize>,
    /// What was checked.
    pub check: Check,
    /// Of what: a contact, a joint, a pair of links; empty for the whole stance.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub subject: String,
    /// What was found; `None` where there is no number.
    pub value: Option<f64>,
    /// What is allowed; `None` where there is no number.
    pub bound: Option<f64>,
    /// By how much the value is on the good side of the bound; negative where it is not.
    pub margin: Option<f64>,
    /// Whether it holds.
    pub pass: bool,
    /// What is wrong, where the numbers do not say it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// One check over the whole plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// What was checked.
    pub check: Check,
    /// How often.
    pub rows: usize,
    /// How often it did not hold.
    pub failed: usize,
    /// The row with the smallest margin, failed rows first.
    pub worst: Row,
}

impl Row {
    /// Stance and subject.
    fn place(&self) -> String {
        let mut place = match self.stance {
            Some(stance) => format!("stance {stance}"),
            None => "plan".to_owned(),
        };
        if !self.subject.is_empty() {
            let _ = write!(place, ", {}", self.subject);
        }
        place
    }

    /// How the row fails, in words: stance, subject, check, value, bound and by how much.
    pub fn sentence(&self) -> String {
        let mut text = format!("{}: {}", self.place(), self.check);
        let unit = match self.check.unit() {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        match (self.value, self.bound) {
            (Some(value), Some(bound)) => {
                let relation = match (self.check.sense(), self.pass) {
                    (Sense::AtMost, true) => "≤",
                    (Sense::AtMost, false) => ">",
                    (_, true) => "≥",
                    (_, false) => "<",
                };
                let (value, bound) = (number(value), number(bound));
                let _ = write!(text, " {value}{unit} {relation} {bound}{unit}");
                if let (false, Some(margin)) = (self.pass, self.margin) {
                    let _ = write!(text, " (by {}{unit})", number(-margin));
                }
            }
            _ if self.pass => text.push_str(" holds"),
            _ => text.push_str(" does not hold"),
        }
        if !self.note.is_empty() {
            let _ = write!(text, ": {}", self.note);
        }
        text
    }
}

impl Certificate {
    /// The rows that do not hold.
    pub fn failures(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.pass)
    }

    /// The checks that do not hold, each once, in the order of [`Check::ALL`].
    pub fn failed_checks(&self) -> Vec<Check> {
        let failed = self.summary.iter().filter(|s| s.failed > 0);
        failed.map(|s| s.check).collect()
    }

    /// The certificate as a table: a line a check with its worst row, then every failure.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{:<15} {:>6} {:>6}  {:>11} {:>13} {:>11}  {:<5} worst at\n",
            "check", "rows", "failed", "value", "bound", "margin", "unit"
        );
        for summary in &self.summary {
            let worst = &summary.worst;
            let relation = match summary.check.sense() {
                Sense::AtMost => "≤",
                Sense::AtLeast => "≥",
                Sense::Holds => "",
            };
            let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
            let bound = match worst.bound {
                Some(bound) => format!("{relation} {}", number(bound)),
                None => "–".to_owned(),
            };
            let _ = writeln!(
                text,
                "{:<15} {:>6} {:>6}  {:>11} {:>13} {:>11}  {:<5} {}",
                summary.check,
                summary.rows,
                summary.failed,
                cell(worst.value),
                bound,
                cell(worst.margin),
                summary.check.unit(),
                worst.place()
            );
        }
        for row in self.failures() {
            let _ = writeln!(text, "FAIL {}", row.sentence());
        }
        let (rows, stances, failed) = (self.rows.len(), self.stances, self.failures().count());
        let sum = format!("{rows} checks over {stances} stances, {failed} failed");
        let _ = writeln!(text, "{}: {sum}", self.verdict());
        for line in self.conditions.iter().chain(&self.notes) {
            let _ = writeln!(text, "  {line}");
        }
        text
    }

    /// Whether it passes, and on which terms, in a word or two.
    pub fn verdict(&self) -> &'static str {
        match (self.pass, self.conditions.is_empty()) {
            (false, _) => "FAIL",
            (true, true) => "PASS",
            (true, false) => "PASS, CONDITIONALLY",
        }
    }

    /// The certificate as it is written to `certificate.json`.
    ///
    /// # Errors  none that a certificate can cause; those of the serializer.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}

/// Four significant digits, in exponents where zeros would be long.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (0.9995e-3..1e5).contains(&size) {
        let decimals = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}
