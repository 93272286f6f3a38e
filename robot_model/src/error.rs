//! What can go wrong between a robot's files and a [`Robot`](crate::Robot).

use std::path::PathBuf;

/// Every way in which loading or asking a robot fails; file errors name the file and the cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be read.
    #[error("{path}: {source}", path = .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not well-formed, not what its format asks for, or makes no robot.
    #[error("{file}: {cause}")]
    File {
        /// The file (or the name of an embedded text).
        file: String,
        /// The cause, with the line where it is known.
        cause: String,
    },
    /// A link, joint or patch cannot be as the file has it.
    #[error("{file}: {part}: {cause}")]
    Part {
        /// The file.
        file: String,
        /// The kind and name of the part, and the shape of a link where that is wrong.
        part: String,
        /// The cause, with every place looked at for a missing mesh.
        cause: String,
    },
    /// Several at once, each with its file.
    #[error("{} mistakes:{}", .0.len(), crate::error::listed(.0))]
    Several(Vec<Error>),
    /// What is read on from where that is wanted.
    #[error("{0} (robot_model.lenient = true reads on)")]
    Strict(Box<Error>),
    /// A name that nothing bears.
    #[error(
        "{where_}unknown {kind} \"{name}\"; {}",
        crate::error::describe_candidates(.candidates)
    )]
    Unknown {
        /// Where the name was used: "file: " or empty.
        where_: String,
        /// What was asked for: joint, link, frame, patch, posture.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The nearest names that exist.
        candidates: Vec<String>,
    },
    /// A vector of the wrong length or with values that are not numbers.
    #[error("{what}: {cause}")]
    Value {
        /// What was being set.
        what: &'static str,
        /// Why it was refused.
        cause: String,
    },
}

impl Error {
    /// All that is wrong as one error, if anything is.
    pub(crate) fn all(mut errors: Vec<Error>) -> Result<(), Error> {
        match errors.pop() {
            None => Ok(()),
            Some(last) => Err(last.after(errors)),
        }
    }

    /// This error and those before it as one.
    pub(crate) fn after(self, before: Vec<Error>) -> Self {
        if before.is_empty() {
            return self;
        }
        let all = before.into_iter().chain([self]);
        let flat = all.flat_map(|error| match error {
            Error::Several(errors) => errors,
            one => vec![one],
        });
        Error::Several(flat.collect())
    }

    /// An [`Error::File`].
    pub(crate) fn file(file: impl std::fmt::Display, cause: impl Into<String>) -> Self {
        Error::File {
            file: file.to_string(),
            cause: cause.into(),
        }
    }

    /// An [`Error::Part`] of that kind and name.
    pub(crate) fn part(file: &str, kind: &str, name: &str, cause: impl Into<String>) -> Self {
        Error::Part {
            file: file.to_owned(),
            part: format!("{kind} \"{name}\""),
            cause: cause.into(),
        }
    }

    /// An [`Error::Value`].
    pub(crate) fn value(what: &'static str, cause: impl Into<String>) -> Self {
        Error::Value {
            what,
            cause: cause.into(),
        }
    }

    /// An [`Error::Unknown`] that lists the names nearest to `name`.
    pub(crate) fn unknown<'a>(
        file: Option<&str>,
        kind: &'static str,
        name: &str,
        existing: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Error::Unknown {
            where_: file.map(|f| format!("{f}: ")).unwrap_or_default(),
            kind,
            name: name.to_owned(),
            candidates: nearest(name, existing),
        }
    }
}

/// A line for each.
pub(crate) fn listed(errors: &[Error]) -> String {
    errors
        .iter()
        .map(|error| format!("\n  - {error}"))
        .collect()
}

/// "candidates: a, b" or the statement that there are none.
pub(crate) fn describe_candidates(candidates: &[String]) -> String {
    if candidates.is_empty() {
        "there is none to choose from".to_owned()
    } else {
        format!("candidates: {}", candidates.join(", "))
    }
}

/// How many names an unknown-name error lists.
const CANDIDATES: usize = 8;

/// The existing names nearest to `name` in edit distance (letter case ignored), ties in alphabetical
/// order.
fn nearest<'a>(name: &str, existing: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let asked = name.to_lowercase();
    let scored = existing.into_iter();
    let scored = scored.map(|n| (strsim::levenshtein(&asked, &n.to_lowercase()), n));
    let mut scored: Vec<(usize, &str)> = scored.collect();
    scored.sort_unstable();
    scored.dedup();
    let nearest = scored.into_iter().take(CANDIDATES);
    nearest.map(|(_, name)| name.to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_lists_the_nearest_first() {
        let names = ["RARM", "LLEG_JOINT5", "HEAD"];
        let error = Error::unknown(None, "joint", "LLEG_JOINT8", names);
        let text = error.to_string();
        assert!(text.contains("unknown joint \"LLEG_JOINT8\""), "{text}");
        assert!(text.contains("candidates: LLEG_JOINT5"), "{text}");
    }
}
