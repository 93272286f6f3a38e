//! Reads TOML and tells everything that is wrong with it at once.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

/// What a text holds, or its mistakes, each with its line.
///
/// After each mistake the text is read again without the entry that has it.
///
/// # Errors
/// Text that is no TOML; keys that are unknown, values of the wrong type, keys that are missing.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Vec<String>> {
    let (mut document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        // One slip makes several errors of its line.
        let mut told: Vec<(usize, String)> = errors.iter().map(|e| in_words(e, text)).collect();
        told.dedup_by_key(|(line, _)| *line);
        return Err(told.into_iter().map(|(_, words)| words).collect());
    }
    let (mut mistakes, mut removed) = (Vec::new(), Vec::<String>::new());
    loop {
        let error = match T::deserialize(Deserializer::from(document.clone())) {
            Ok(read) if mistakes.is_empty() => return Ok(read),
            Ok(_) => break,
            Err(error) => error,
        };
        // What was taken out is not missing.
        let of = |key: &String| error.message() == format!("missing field `{key}`");
        if !removed.iter().any(of) {
            mistakes.push(in_words(&error, text).1);
        }
        let entry = error
            .span()
            .and_then(|span| take(document.get_mut(), &span));
        match entry {
            Some(key) => removed.push(key),
            None => break,
        }
    }
    Err(mistakes)
}

/// The line, and what is wrong there.
fn in_words(error: &Error, text: &str) -> (usize, String) {
    let before = error
        .span()
        .map_or("", |span| text.get(..span.start).unwrap_or(text));
    let (line, message) = (before.matches('\n').count() + 1, error.message().trim());
    (
        line,
        format!("line {line}: {}", message.replace('\n', ", ")),
    )
}

/// Takes the innermost entry out of which the key or the value is at `span`: a list of tables has the span of its first.
/// Its key, empty for an item of a list.
fn take(table: &mut DeTable, span: &Range<usize>) -> Option<String> {
    let mut values = table.iter_mut().map(|(_, value)| value);
    if let Some(key) = values.find_map(|value| take_from(value, span)) {
        return Some(key);
    }
    let mut keys = table.iter();
    let found = keys.find(|(key, value)| key.span() == *span || value.span() == *span);
    let key = found?.0.clone();
    table.remove(&key);
    Some(key.into_inner().into_owned())
}

fn take_from(value: &mut Spanned<DeValue>, span: &Range<usize>) -> Option<String> {
    match value.get_mut() {
        DeValue::Table(table) => take(table, span),
        DeValue::Array(items) => {
            let inner = items.iter_mut().find_map(|item| take_from(item, span));
            if inner.is_none() && items.iter().any(|item| item.span() == *span) {
                *items = items
                    .iter()
                    .filter(|item| item.span() != *span)
                    .cloned()
                    .collect();
                return Some(String::new());
            }
            inner
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct File {
        name: String,
        #[serde(default)]
        item: Vec<Item>,
        size: Option<f64>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Item {
        weight: f64,
        #[serde(default)]
        at: [f64; 2],
    }

    #[test]
    fn all_mistakes_are_told_and_none_that_is_not_there() {
        for (text, told) in [
            ("name = 'a'\n[[item]]\nweight = 1\nat = [0, 1]", &[][..]),
            ("name = = 3", &["line 1: "]),
            ("size = 2", &["line 1: missing field `name`"]),
            (
                "name = 3\nsize = 'x'",
                &["line 1: invalid type", "line 2: invalid type"],
            ),
            (
                "name = 'a'\nsise = 1\n[[item]]\nwait = 2\n[[item]]\nweight = 1\nat = [1]\n[[item]]\nweight = 'x'",
                &[
                    "line 2: unknown field `sise`",
                    "line 4: unknown field `wait`",
                    "line 3: missing field `weight`",
                    "line 7: invalid length 1",
                    "line 9: invalid type",
                ],
            ),
        ] {
            let read = parse::<File>(text);
            let mut mistakes = read.err().unwrap_or_default();
            for part in told {
                let at = mistakes.iter().position(|mistake| mistake.contains(part));
                mistakes
                    .remove(at.unwrap_or_else(|| panic!("{text}: no {part:?} in {mistakes:?}")));
            }
            assert!(mistakes.is_empty(), "{text}: {mistakes:?}");
        }
    }
}
