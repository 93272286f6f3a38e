//! The threads of a command.

use std::num::NonZeroUsize;
use std::sync::{Arc, OnceLock};

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

/// A pool of `threads` workers; of one a processor where none is given, and the one there is
/// in a browser's worker.
///
/// # Errors
/// When the system does not give that many threads.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<Arc<rayon::ThreadPool>> {
    let count = threads.map_or(0, NonZeroUsize::get);
    let build = |builder: rayon::ThreadPoolBuilder| {
        let pool = builder.build().map(Arc::new);
        pool.with_context(|| format!("cannot start {count} threads"))
    };
    let builder = rayon::ThreadPoolBuilder::new();
    if !cfg!(target_os = "wasi") {
        return build(builder.num_threads(count));
    }
    // There is one thread, and it can be in one pool.
    static ONLY: OnceLock<Arc<rayon::ThreadPool>> = OnceLock::new();
    if let Some(pool) = ONLY.get() {
        return Ok(Arc::clone(pool));
    }
    let pool = build(builder.num_threads(1).use_current_thread())?;
    Ok(Arc::clone(ONLY.get_or_init(|| pool)))
}
