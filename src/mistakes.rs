//! Several mistakes told at once, so that they can be mended at once.

use std::fmt;

use anyhow::{Error, Result};

/// Several errors as one, a line each.
#[derive(Debug)]
pub struct Mistakes(Vec<Error>);

impl fmt::Display for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mistakes:", self.0.len())?;
        self.0
            .iter()
            .try_for_each(|error| write!(f, "\n  - {error:#}"))
    }
}

impl std::error::Error for Mistakes {}

/// Errors as one, none of it itself several.
pub fn several(errors: Vec<Error>) -> Error {
    let flat = errors.into_iter().flat_map(|error| match error.downcast() {
        Ok(Mistakes(errors)) => errors,
        Err(one) => vec![one],
    });
    let mut errors: Vec<Error> = flat.collect();
    match errors.len() {
        1 => errors.remove(0),
        _ => Mistakes(errors).into(),
    }
}

/// All of the values.
///
/// # Errors
/// All of the errors.
pub fn all<T>(results: impl IntoIterator<Item = Result<T>>) -> Result<Vec<T>> {
    let (mut values, mut errors) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(error) => errors.push(error),
        }
    }
    match errors.is_empty() {
        true => Ok(values),
        false => Err(several(errors)),
    }
}

/// Both values.
///
/// # Errors
/// Both errors.
pub fn both<A, B>(a: Result<A>, b: Result<B>) -> Result<(A, B)> {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(a), Err(b)) => Err(several(vec![a, b])),
        (Err(error), Ok(_)) | (Ok(_), Err(error)) => Err(error),
    }
}

/// The mistakes that an error tells of, each in words.
pub fn of(error: &Error) -> Vec<String> {
    let several = error.chain().find_map(|cause| {
        if let Some(Mistakes(errors)) = cause.downcast_ref() {
            return Some(errors.iter().map(|e| format!("{e:#}")).collect());
        }
        if let Some(robot_model::Error::Several(errors)) = cause.downcast_ref() {
            return Some(errors.iter().map(ToString::to_string).collect());
        }
        match cause.downcast_ref() {
            Some(scenes::Error::Several(errors)) => {
                Some(errors.iter().map(ToString::to_string).collect())
            }
            _ => None,
        }
    });
    several.unwrap_or_else(|| vec![format!("{error:#}")])
}
