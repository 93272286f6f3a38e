//! What can be wrong with a posture problem itself.

/// A problem that cannot be posed. That no posture exists is not an error but an
/// [`Outcome`](crate::Outcome).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting has a value that makes no sense.
    #[error("posture.{field} = {value} is not allowed: give a value {allowed}")]
    Config {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The environment has no face of a name.
    #[error("there is no face {face:?}; there are: {}", known.join(", "))]
    UnknownFace {
        /// The name.
        face: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// A face vanishes under its insets.
    #[error("face {face}: nothing is left of it after its insets")]
    EmptyFace {
        /// Its name.
        face: String,
    },
    /// A number of the problem is not finite, or has no meaning.
    #[error("{what}: {value} is not allowed")]
    Value {
        /// The quantity.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A body of the environment has no volume.
    #[error("body {body} of the environment: {cause}")]
    Body {
        /// Its name.
        body: String,
        /// What is wrong with it.
        cause: String,
    },
    /// No contact may carry load.
    #[error("the problem has no loaded contact: nothing holds the robot")]
    Unsupported,
}
