//! The program's errors as Python's.

use pyo3::PyErr;
use scandent::status::UsageError;

pyo3::import_exception!(scandent._errors, Error);
pyo3::import_exception!(scandent._errors, InputError);

/// An input that cannot be used; `argument` is its name in Python, where one alone is to blame.
pub fn input(error: impl Into<anyhow::Error>, argument: Option<&str>) -> PyErr {
    let error: anyhow::Error = error.into();
    InputError::new_err((said(&error), argument.map(str::to_owned)))
}

/// As [`input`], where the blame is not on one argument.
pub fn of(error: impl Into<anyhow::Error>) -> PyErr {
    input(error, None)
}

/// An error in words. The command line's parser shows its own in colours and with its usage, which nobody
/// typed here: its first lines say what is wrong.
fn said(error: &anyhow::Error) -> String {
    let text = format!("{error:#}");
    if error.is::<UsageError>() || !text.starts_with("error: ") {
        return text;
    }
    let lines = text.trim_start_matches("error: ").lines();
    let lines: Vec<&str> = lines
        .take_while(|line| !line.starts_with("Usage:"))
        .collect();
    lines.join("\n").trim().to_owned()
}
