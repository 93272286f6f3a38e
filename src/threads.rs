//! The threads of a command.

use std::num::NonZeroUsize;

use anyhow::{Context, Result};

/// Most threads of a command.
const THREADS_MAX: usize = 512;

/// A number of threads on the command line.
///
/// # Errors
/// What is none, or more than any machine makes use of.
pub fn count(text: &str) -> Result<NonZeroUsize, String> {
    let count = text
        .parse()
        .map_err(|_| "not a number of threads".to_owned())?;
    match NonZeroUsize::get(count) <= THREADS_MAX {
        true => Ok(count),
        false => Err(format!("at most {THREADS_MAX} threads are started")),
    }
}

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
