//! What can be wrong with a motion or with what is asked for.

/// A motion that makes no sense, or a request that cannot be posed. That no motion exists between
/// two stances is not an error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting has a value that makes no sense.
    #[error("motion.{field} = {value} is not allowed: give a value {allowed}")]
    Config {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Two stances that do not follow on each other by one contact.
    #[error("the stances do not follow on each other: {cause}")]
    Pair {
        /// Which contact, and why.
        cause: String,
    },
    /// A posture problem on the path could not be posed.
    #[error(transparent)]
    Posture(#[from] posture::Error),
}
