//! Long work beside the interpreter.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use planner::Progress;
use pyo3::prelude::*;

use crate::error::Error;

/// How long signals wait.
const SIGNALS_EVERY: Duration = Duration::from_millis(20);
/// Stack of the thread that works: what the main thread of a program has.
const STACK_BYTES: usize = 8 << 20;

/// A way from the work to the interpreter: how far it is, and whether it is to go on.
pub struct Reporter {
    events: Mutex<Sender<Progress>>,
    go_on: Mutex<Receiver<()>>,
}

impl Reporter {
    /// Tells how far the work is and waits until that was heard.
    pub fn tell(&self, progress: &Progress) {
        let events = self.events.lock();
        if events.is_ok_and(|events| events.send(*progress).is_ok())
            && let Ok(go_on) = self.go_on.lock()
        {
            let _ = go_on.recv();
        }
    }
}

/// Does short work without the interpreter's lock.
///
/// # Errors
/// A panic.
pub fn briefly<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(panicked)
}

/// Does long work on a thread of its own; Ctrl-C, or `progress` that raises or returns `False`, raise
/// `cancel`, and the work ends when it sees it.
///
/// # Errors
/// What a signal or `progress` raised; a panic.
pub fn long<T: Send>(
    py: Python<'_>,
    cancel: &AtomicBool,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Reporter) -> T + Send,
) -> PyResult<T> {
    let (events, heard) = channel();
    let (answer, go_on) = channel();
    let reporter = Reporter {
        events: Mutex::new(events),
        go_on: Mutex::new(go_on),
    };
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        // The reporter goes with the work: its end hangs up.
        let thread = thread.spawn_scoped(scope, move || work(&reporter));
        let thread = thread.map_err(|e| Error::new_err(format!("cannot start a thread: {e}")))?;
        let mut raised = None;
        let heard = Mutex::new(heard);
        loop {
            let next = py.detach(|| match heard.lock() {
                Ok(heard) => heard.recv_timeout(SIGNALS_EVERY),
                Err(_) => Err(RecvTimeoutError::Disconnected),
            });
            let said = match (&next, progress) {
                (Ok(event), Some(progress)) if raised.is_none() => tell(progress, event),
                _ => Ok(true),
            };
            match said.and_then(|go_on| py.check_signals().map(|()| go_on)) {
                Ok(true) => {}
                Ok(false) => cancel.store(true, Ordering::Relaxed),
                Err(error) => {
                    cancel.store(true, Ordering::Relaxed);
                    raised.get_or_insert(error);
                }
            }
            match next {
                Ok(_) => drop(answer.send(())),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let done = py.detach(|| thread.join()).map_err(panicked)?;
        raised.map_or(Ok(done), Err)
    })
}

/// Calls `progress(nodes, solved, best_distance_m, stage)`; anything but `False` goes on.
fn tell(progress: &Bound<'_, PyAny>, event: &Progress) -> PyResult<bool> {
    let stage = match event.stage {
        planner::Stage::Search => "search",
        planner::Stage::Motion { .. } => "motion",
    };
    let said = (event.nodes, event.solved, event.best_distance_m, stage);
    let said = progress.call1(said)?;
    Ok(!said.extract::<bool>().is_ok_and(|go_on| !go_on))
}

fn panicked(panic: Box<dyn Any + Send>) -> PyErr {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    let words = words.or(panic.downcast_ref::<&str>().copied());
    let words = words.unwrap_or("no words");
    Error::new_err(format!("a mistake in scandent, please report it: {words}"))
}
