//! The threads of a command.

use std::num::NonZeroUsize;

use anyhow::{Context, Result};

/// A pool of `threads` workers; of one a processor where none is given.
///
/// # Errors
/// When the system does not give that many threads.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<rayon::ThreadPool> {
    let count = threads.map_or(0, NonZeroUsize::get);
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .with_context(|| format!("cannot start {count} threads"))
}
