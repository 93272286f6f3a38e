//! What can be wrong with a file.

/// A file that contradicts itself.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A motion that contradicts itself.
    #[error("the motion: {cause}")]
    Motion {
        /// Where, and what is wrong.
        cause: String,
    },
}
