//! The range of every number among the settings, as their types state it beside its meaning.

use anyhow::{Error, anyhow};
use serde_json::Value as Schema;
use toml::{Table, Value};

use super::Config;
use super::schema::property;

/// The numbers that are none or beyond their range: the setting, its value and its range.
pub fn mistakes(settings: &Table) -> Vec<Error> {
    let schema = schemars::schema_for!(Config).to_value();
    let mut found = Vec::new();
    for (key, value) in settings {
        check(&schema, &mut vec![key], value, &mut found);
    }
    found
}

fn check<'a>(schema: &Schema, path: &mut Vec<&'a str>, value: &'a Value, found: &mut Vec<Error>) {
    let numbers = match value {
        Value::Table(table) => {
            for (key, value) in table {
                path.push(key);
                check(schema, path, value, found);
                path.pop();
            }
            return;
        }
        Value::Array(values) => values.as_slice(),
        single => std::slice::from_ref(single),
    };
    let Some(Range { low, high }) = property(schema, path).and_then(of) else {
        return;
    };
    for number in numbers {
        let value = match number {
            Value::Integer(value) => *value as f64,
            Value::Float(value) => *value,
            _ => continue,
        };
        if !(low..=high).contains(&value) {
            let key = path.join(".");
            let range = format!("it goes from {low} to {high}");
            found.push(anyhow!("{key} is {number}; {range}"));
        }
    }
}

/// Least and greatest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

/// The range of a setting or, of a list, of its numbers.
pub fn of(setting: &Schema) -> Option<Range> {
    let numbers = setting.get("items").unwrap_or(setting);
    let bound = |name: &str| numbers.get(name).and_then(Schema::as_f64);
    let (low, high) = (bound("minimum")?, bound("maximum")?);
    Some(Range { low, high })
}
