//! What was measured against what is allowed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One criterion of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Criterion {
    /// What is measured.
    pub name: String,
    /// What was measured.
    pub value: f64,
    /// What is allowed.
    pub bound: f64,
    /// Whether the value may not exceed the bound, or not fall short of it.
    pub sense: Sense,
    /// Unit of both.
    pub unit: String,
    /// Whether it holds.
    pub pass: bool,
    /// Where or what, for a criterion that concerns one of several things.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
}

/// On which side of the bound a value has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sense {
    /// Not above.
    AtMost,
    /// Not below.
    AtLeast,
}

/// Units that values are shown in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// From m.
    Millimetre,
    /// From rad.
    Degree,
    /// As it is.
    Plain(&'static str),
}

impl Unit {
    fn shown(self, value: f64) -> (f64, &'static str) {
        match self {
            Unit::Millimetre => (value * 1e3, "mm"),
            Unit::Degree => (value.to_degrees(), "deg"),
            Unit::Plain(name) => (value, name),
        }
    }
}

impl Criterion {
    /// `value` must not exceed `bound`; a value that is not a number does not hold.
    pub fn at_most(name: &str, value: f64, bound: f64, unit: Unit) -> Self {
        Self::new(name, value, bound, unit, Sense::AtMost, value <= bound)
    }

    /// `value` must not fall short of `bound`.
    pub fn at_least(name: &str, value: f64, bound: f64, unit: Unit) -> Self {
        Self::new(name, value, bound, unit, Sense::AtLeast, value >= bound)
    }

    /// The same with a word on where.
    pub fn on(mut self, detail: Option<String>) -> Self {
        self.detail = detail;
        self
    }

    fn new(name: &str, value: f64, bound: f64, unit: Unit, sense: Sense, pass: bool) -> Self {
        let ((value, unit), (bound, _)) = (unit.shown(value), unit.shown(bound));
        Self {
            name: name.to_owned(),
            value,
            bound,
            sense,
            unit: unit.to_owned(),
            pass,
            detail: None,
        }
    }
}
