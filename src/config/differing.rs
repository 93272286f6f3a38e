//! In which settings two results differ.

use serde_json::Value;

/// The settings of which the values differ, with those that are stated; `path` leads to the tables.
pub fn differing(stated: &Value, own: &Value, path: &str, found: &mut Vec<String>) {
    match (stated, own) {
        (Value::Object(stated), Value::Object(own)) => {
            for (key, value) in stated {
                let own = own.get(key).unwrap_or(&Value::Null);
                let path = [path, key].join(if path.is_empty() { "" } else { "." });
                differing(value, own, &path, found);
            }
        }
        _ if stated != own => found.push(format!("{path} = {stated} instead of {own}")),
        _ => {}
    }
}
