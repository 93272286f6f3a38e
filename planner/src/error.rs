//! What can be wrong with a planning request itself.

/// A request that cannot be planned on. That no plan exists is not an error but a
/// [`Status`](crate::Status).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A setting has a value that makes no sense.
    #[error("planner.{field} = {value} is not allowed: give a value {allowed}")]
    Config {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The robot cannot stand where it starts.
    #[error("the start is no stance: {reason}")]
    Start {
        /// Which constraint fails, by how much.
        reason: String,
    },
    /// The guide path has less than two points, or one that is not finite.
    #[error("the guide path: {reason}")]
    Guide {
        /// Why.
        reason: String,
    },
    /// A name in `exclude` that is neither a patch nor a role.
    #[error("planner.exclude: the robot has no patch or role {name:?}; it has {known}")]
    Exclude {
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// A posture problem could not be posed.
    #[error(transparent)]
    Posture(#[from] posture::Error),
    /// A motion could not be asked for.
    #[error(transparent)]
    Motion(#[from] motion::Error),
}
