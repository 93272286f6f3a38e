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
    /// The problem refers to something that is not there.
    #[error("contact {contact}: {what} {index} does not exist (there are {count})")]
    Missing {
        /// Index of the contact in the problem.
        contact: usize,
        /// `patch` or `surface`.
        what: &'static str,
        /// The index that was given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A surface vanishes under its inset.
    #[error("surface {surface}: nothing is left of its polygon after an inset of {inset_m} m")]
    EmptySurface {
        /// Id of the surface.
        surface: String,
        /// Its inset, m.
        inset_m: f64,
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
