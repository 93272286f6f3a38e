//! The settings' schema, by the paths of its tables and keys.

use serde_json::Value;

/// The schema of the setting or table at a path, with what is said of it there.
pub fn property<'a>(schema: &'a Value, path: &[&str]) -> Option<&'a Value> {
    let (key, table) = path.split_last()?;
    find(schema, table)?.get("properties")?.get(key)
}

/// The schema of the table at a path.
pub fn find<'a>(schema: &'a Value, path: &[&str]) -> Option<&'a Value> {
    path.iter().try_fold(schema, |at, key| {
        let named = at.get("properties").and_then(|p| p.get(key));
        let property = named.or(at.get("additionalProperties"))?;
        Some(resolve(schema, property))
    })
}

/// The definition that a schema refers to, or the schema itself.
pub fn resolve<'a>(schema: &'a Value, property: &'a Value) -> &'a Value {
    let name = property.get("$ref").and_then(Value::as_str);
    let definition = name.and_then(|name| schema.pointer(name.trim_start_matches('#')));
    definition.unwrap_or(property)
}
