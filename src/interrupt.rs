//! Ctrl-C: the first asks the search to stop and keep what it has, the second ends the program.

use std::sync::atomic::AtomicBool;
#[cfg(not(target_os = "wasi"))]
use std::sync::atomic::Ordering;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Exit code after a second Ctrl-C, as shells report it.
#[cfg(not(target_os = "wasi"))]
const KILLED_BY_SIGINT: i32 = 130;

/// Starts listening for Ctrl-C; returns the flag that it raises.
///
/// A system that does not let us listen is no reason to refuse work: it is logged. A browser's worker hears nothing
/// and is ended from outside.
pub fn listen() -> &'static AtomicBool {
    #[cfg(not(target_os = "wasi"))]
    if let Err(error) = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(KILLED_BY_SIGINT);
        }
    }) && !matches!(error, ctrlc::Error::MultipleHandlers)
    {
        tracing::warn!("Ctrl-C will end the program without saving: {error}");
    }
    &ASKED
}
