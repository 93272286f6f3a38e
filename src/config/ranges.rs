//! The range of every number among the settings, as their types state it beside its meaning.

use anyhow::{Result, bail};
use serde_json::Value as Schema;
use toml::{Table, Value};

use super::Config;
use super::schema::property;

/// Refuses numbers that are none or beyond their range.
///
/// # Errors
/// The setting, its value and its range.
pub fn check(settings: &Table) -> Result<()> {
    let schema = schemars::schema_for!(Config).to_value();
    settings
        .iter()
        .try_for_each(|(key, value)| inside(&schema, &mut vec![key], value))
}

fn inside<'a>(schema: &Schema, path: &mut Vec<&'a str>, value: &'a Value) -> Result<()> {
    let numbers = match value {
        Value::Table(table) => {
            for (key, value) in table {
                path.push(key);
                inside(schema, path, value)?;
                path.pop();
            }
            return Ok(());
        }
        Value::Array(values) => values.as_slice(),
        single => std::slice::from_ref(single),
    };
    let Some(Range { low, high }) = property(schema, path).and_then(of) else {
        return Ok(());
    };
    for number in numbers {
        let value = match number {
            Value::Integer(value) => *value as f64,
            Value::Float(value) => *value,
            _ => continue,
        };
        if !(low..=high).contains(&value) {
            let key = path.join(".");
            bail!("{key} is {number}; it goes from {low} to {high}");
        }
    }
    Ok(())
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
