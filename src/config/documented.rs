//! The settings as TOML in which every key stands below its meaning, from the docstrings.

use anyhow::Result;
use serde_json::Value;

use super::schema::{find, property, resolve};
use super::{Config, ranges};

/// Every setting with its value, below its description as a comment; a setting without a value
/// stands in a comment itself. The text can be read back.
pub fn documented(config: &Config) -> Result<String> {
    let schema = schemars::schema_for!(Config).to_value();
    let mut text = String::new();
    let mut table: Vec<&str> = Vec::new();
    let plain = toml::to_string_pretty(config)?;
    for line in plain.lines() {
        if let Some(header) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            table = header.split('.').collect();
            comment(&mut text, &schema, &table);
            text.push_str(line);
            text.push('\n');
            unset(&mut text, &schema, &table);
            continue;
        }
        if let Some((key, _)) = line.split_once(" = ")
            && !line.starts_with(' ')
        {
            comment(&mut text, &schema, &[&table[..], &[key]].concat());
        }
        text.push_str(line);
        text.push('\n');
    }
    Ok(text)
}

/// The keys of a table that may have no value, which TOML cannot show.
fn unset(text: &mut String, schema: &Value, table: &[&str]) {
    let properties = find(schema, table).and_then(|s| s.get("properties"));
    let Some(properties) = properties.and_then(Value::as_object) else {
        return;
    };
    for (key, property) in properties {
        let types = property.get("type").and_then(Value::as_array);
        if types.is_some_and(|types| types.iter().any(|t| t == "null")) {
            comment(text, schema, &[table, &[key]].concat());
            text.push_str(&format!("# {key} = …\n"));
        }
    }
}

/// Writes the description of the setting or table at a path.
fn comment(text: &mut String, schema: &Value, path: &[&str]) {
    let Some(description) = description(schema, path) else {
        return;
    };
    for line in description.lines() {
        text.push_str(if line.is_empty() { "#" } else { "# " });
        text.push_str(line);
        text.push('\n');
    }
}

/// What the docstrings say of the setting or table at a path, with the values of an enumeration.
fn description(schema: &Value, path: &[&str]) -> Option<String> {
    let property = property(schema, path)?;
    let mut text = property.get("description")?.as_str()?.to_owned();
    let variants = resolve(schema, property).get("oneOf");
    for variant in variants.and_then(Value::as_array).into_iter().flatten() {
        if let (Some(name), Some(meaning)) = (
            variant.get("const").and_then(Value::as_str),
            variant.get("description").and_then(Value::as_str),
        ) {
            text.push_str(&format!("\n\"{name}\": {meaning}"));
        }
    }
    if let Some(range) = ranges::of(property) {
        text.push_str(&format!("\nFrom {} to {}.", range.low, range.high));
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths of the settings below a table that have no description.
    fn undescribed(schema: &Value, table: &Value, path: &str, found: &mut Vec<String>) {
        let properties = table.get("properties").and_then(Value::as_object);
        for (key, property) in properties.into_iter().flatten() {
            let path = format!("{path}.{key}");
            let text = property.get("description").and_then(Value::as_str);
            if text.is_none_or(str::is_empty) {
                found.push(path.clone());
            }
            undescribed(schema, resolve(schema, property), &path, found);
        }
        if let Some(any) = table.get("additionalProperties") {
            undescribed(schema, resolve(schema, any), &format!("{path}.*"), found);
        }
    }

    #[test]
    fn every_setting_has_a_description() {
        let schema = schemars::schema_for!(Config).to_value();
        let mut found = Vec::new();
        undescribed(&schema, &schema, "", &mut found);
        assert_eq!(found, Vec::<String>::new());
    }

    /// Paths of the numbers below a table that have no range, or of which the default is beyond it.
    fn unbounded(schema: &Value, table: &Value, path: &str, found: &mut Vec<String>) {
        let properties = table.get("properties").and_then(Value::as_object);
        for (key, property) in properties.into_iter().flatten() {
            let path = format!("{path}.{key}");
            let words = property.to_string();
            let is_number = words.contains("\"number\"") || words.contains("\"integer\"");
            if is_number && ranges::of(property).is_none_or(|range| range.low >= range.high) {
                found.push(path.clone());
            }
            unbounded(schema, resolve(schema, property), &path, found);
        }
        if let Some(any) = table.get("additionalProperties") {
            unbounded(schema, resolve(schema, any), &format!("{path}.*"), found);
        }
    }

    #[test]
    fn every_number_has_a_range() {
        let schema = schemars::schema_for!(Config).to_value();
        let mut found = Vec::new();
        unbounded(&schema, &schema, "", &mut found);
        assert_eq!(found, Vec::<String>::new());
        let defaults = toml::Table::try_from(Config::default()).unwrap();
        assert!(ranges::mistakes(&defaults).is_empty());
    }

    #[test]
    fn what_is_printed_can_be_read_back_and_says_what_it_means() {
        let config = Config::default();
        let text = documented(&config).unwrap();
        let read: Config = toml::from_str(&text).unwrap();
        assert_eq!(read, config);
        let lines: Vec<&str> = text.lines().collect();
        let key = |key: &str| lines.iter().position(|l| l.starts_with(key)).unwrap();
        let says = |setting: &str, words: &str| {
            let comment = lines[..key(setting)].iter().rev();
            let mut comment = comment.take_while(|l| l.starts_with('#'));
            comment.any(|l| l.contains(words))
        };
        assert!(says("torque_use = ", "torque limits"));
        assert!(says("controller = ", "# \"servo\": "));
        assert!(lines[key("# robot = ") - 1].contains("Name of the robot"));
        for (number, line) in lines.iter().enumerate().skip(1) {
            if line.contains(" = ") && !line.starts_with([' ', '#']) {
                assert!(lines[number - 1].starts_with('#'), "{line}");
            }
        }
    }
}
