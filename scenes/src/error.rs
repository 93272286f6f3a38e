//! What can be wrong with a scene or a set of problems.

/// A scene file or a set of problems that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not TOML or does not have the fields of a scene; the message carries the line.
    #[error("not a scene file: {0}")]
    Syntax(String),
    /// Several at once.
    #[error("{} mistakes:{}", .0.len(), listed(.0))]
    Several(Vec<Error>),
    /// A field has a value that makes no sense.
    #[error("scene field `{field}`: {reason}")]
    Field {
        /// Path of the field, for example `scan[0].quat_xyzw`.
        field: String,
        /// What is wrong with it.
        reason: String,
    },
    /// No contact sets of the family can be drawn for the robot.
    #[error("no posture problems for {robot}: {reason}")]
    ContactSet {
        /// The robot's name.
        robot: String,
        /// Why not.
        reason: String,
    },
}

/// A line for each.
fn listed(errors: &[Error]) -> String {
    errors
        .iter()
        .map(|error| format!("\n  - {error}"))
        .collect()
}

impl Error {
    /// Errors as one.
    pub(crate) fn several(mut errors: Vec<Error>) -> Self {
        match errors.len() {
            1 => errors.remove(0),
            _ => Self::Several(errors),
        }
    }

    pub(crate) fn field(field: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Field {
            field: field.into(),
            reason: reason.into(),
        }
    }
}
