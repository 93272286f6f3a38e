//! Reads TOML and tells everything that is wrong with it at once.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeTable, DeValue, Deserializer, Error};

/// The text is read this often at most: of more mistakes the first are told.
const READINGS_MAX: usize = 100;

/// What a text holds, or its mistakes, each with its line.
///
/// After each mistake the text is read again without the entry that has it, or with a stand-in for what is missing.
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
    let mut tried = BTreeMap::new();
    for _ in 0..READINGS_MAX {
        let error = match T::deserialize(Deserializer::from(document.clone())) {
            Ok(read) if mistakes.is_empty() => return Ok(read),
            Ok(_) => break,
            Err(error) => error,
        };
        let span = error.span().unwrap_or_default();
        let missing = error.message().strip_prefix("missing field `");
        let missing = missing.map(|key| key.trim_end_matches('`').to_owned());
        // What was taken out is not missing, and a stand-in is no mistake.
        let is_stand_in = span.start > text.len();
        let tries: &mut usize = tried.entry((span.start, missing.clone())).or_default();
        let is_told = *tries > 0 || missing.as_ref().is_some_and(|key| removed.contains(key));
        if !is_stand_in && !is_told {
            mistakes.push(in_words(&error, text).1);
        }
        *tries += 1;
        let stand_in = stand_ins().nth(*tries - 1).filter(|_| !is_stand_in);
        if let (Some(key), Some(value)) = (missing, stand_in)
            && let Some(table) = table_at(&mut document, &span)
        {
            let nowhere = text.len() + mistakes.len() + 1;
            let at = |value| Spanned::new(nowhere..nowhere, value);
            table.insert(Spanned::new(nowhere..nowhere, key.into()), at(value));
            continue;
        }
        match take(document.get_mut(), &span) {
            Some(_) if is_stand_in => {}
            Some(key) => removed.push(key),
            None => break,
        }
    }
    Err(mistakes)
}

/// What stands for values that are missing: the first that is of the type.
fn stand_ins() -> impl Iterator<Item = DeValue<'static>> {
    let text = DeValue::String("".into());
    let (number, list) = (DeValue::Integer(DeInteger::default()), DeArray::default());
    [
        text,
        number,
        DeValue::Array(list),
        DeValue::Table(DeTable::new()),
    ]
    .into_iter()
}

/// The innermost table at `span`; the document's own has that of nothing else.
fn table_at<'a, 'i>(
    document: &'a mut Spanned<DeTable<'i>>,
    span: &Range<usize>,
) -> Option<&'a mut DeTable<'i>> {
    let is_own = document.span() == *span;
    let table = document.get_mut();
    match is_own {
        true => Some(table),
        false => table.iter_mut().find_map(|(_, value)| inner(value, span)),
    }
}

fn inner<'a, 'i>(
    value: &'a mut Spanned<DeValue<'i>>,
    span: &Range<usize>,
) -> Option<&'a mut DeTable<'i>> {
    let is_own = value.span() == *span;
    match value.get_mut() {
        DeValue::Table(table) => match is_own {
            true => Some(table),
            false => table.iter_mut().find_map(|(_, value)| inner(value, span)),
        },
        DeValue::Array(items) => items.iter_mut().find_map(|item| inner(item, span)),
        _ => None,
    }
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
        kind: Kind,
        #[serde(default)]
        at: [f64; 2],
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[allow(dead_code)]
    enum Kind {
        Big,
    }

    #[test]
    fn all_mistakes_are_told_and_none_that_is_not_there() {
        for (text, told) in [
            (
                "name = 'a'\n[[item]]\nweight = 1\nkind = 'big'\nat = [0, 1]",
                &[][..],
            ),
            ("name = = 3", &["line 1: "]),
            ("size = 2", &["missing field `name`"]),
            (
                "size = 'x'\n[[item]]\nat = [1, 1]\n[[item]]\n",
                &[
                    "line 1: invalid type",
                    "line 2: missing field `weight`",
                    "line 2: missing field `kind`",
                    "line 4: missing field `weight`",
                    "line 4: missing field `kind`",
                    "missing field `name`",
                ],
            ),
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
                    "line 3: missing field `kind`",
                    "line 5: missing field `kind`",
                    "line 8: missing field `kind`",
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
