//! Ctrl-C: the first asks the search to stop and keep what it has, the second ends the program.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit code after a second Ctrl-C, as shells report it.
const KILLED_BY_SIGINT: i32 = 130;

/// Starts listening for Ctrl-C; returns the flag that it raises.
///
/// A system that does not let us listen is no reason to refuse work: it is logged.
pub fn listen() -> &'static AtomicBool {
    let heard = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(KILLED_BY_SIGINT);
        }
    });
    if let Err(error) = heard
        && !matches!(error, ctrlc::Error::MultipleHandlers)
    {
        tracing::warn!("Ctrl-C will end the program without saving: {error}");
    }
    &ASKED
}
