//! How far the search is: one moving line on a terminal, an occasional plain line elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use planner::{Progress, Stage};

/// Time between two plain lines.
const PLAIN_EVERY: Duration = Duration::from_secs(5);
/// Time between two turns of the spinner.
const TICK: Duration = Duration::from_millis(100);

/// Shows the progress of one search on stderr until it is dropped.
pub struct ProgressLine {
    bar: ProgressBar,
    plain: bool,
    begin: Instant,
    said: Mutex<Instant>,
}

impl Default for ProgressLine {
    /// Begins a line.
    fn default() -> Self {
        // A browser's worker has no thread to turn a spinner.
        let plain = cfg!(target_os = "wasi") || !std::io::stderr().is_terminal();
        let bar = if plain {
            ProgressBar::hidden()
        } else {
            ProgressBar::new_spinner()
        };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
            bar.set_style(style);
        }
        if !plain {
            bar.enable_steady_tick(TICK);
        }
        let now = Instant::now();
        Self {
            bar,
            plain,
            begin: now,
            said: Mutex::new(now),
        }
    }
}

impl ProgressLine {
    /// Shows what is done next.
    pub fn stage(&self, stage: &str) {
        tracing::info!("{stage}");
        self.bar.set_message(stage.to_owned());
    }

    /// Shows where the search is.
    pub fn show(&self, progress: &Progress) {
        self.say(|| self.text(progress));
    }

    /// Shows how many of one stage's pieces are done.
    pub fn count(&self, stage: &str, done: usize, of: usize) {
        self.say(|| format!("{stage}: {done} of {of}"));
    }

    fn say(&self, text: impl Fn() -> String) {
        if !self.plain {
            self.bar.set_message(text());
            return;
        }
        // A poisoned lock only means that another thread panicked while it printed.
        let said = self.said.lock();
        let mut said = said.unwrap_or_else(std::sync::PoisonError::into_inner);
        if said.elapsed() >= PLAIN_EVERY {
            *said = Instant::now();
            eprintln!("{}", text());
        }
    }

    fn text(&self, progress: &Progress) -> String {
        let rate = progress.solved as f64 / self.begin.elapsed().as_secs_f64().max(1e-3);
        let Progress {
            nodes,
            nodes_max,
            stances,
            stances_about,
            best_distance_m,
            ..
        } = progress;
        let doing = match progress.stage {
            Stage::Search => String::new(),
            Stage::Motion { known, of } => format!(", motion {} of {of}", known + 1),
        };
        format!(
            "{stances} of about {stances_about} stances, {best_distance_m:.2} m to go, {nodes} nodes of at \
             most {nodes_max}, {rate:.0} postures/s{doing}"
        )
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
