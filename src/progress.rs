//! How far the search is: one moving line on a terminal, an occasional plain line elsewhere.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use planner::Progress;

/// Time between two plain lines.
const PLAIN_EVERY: Duration = Duration::from_secs(5);

/// Shows the progress of one search on stderr until it is dropped.
pub struct ProgressLine {
    bar: ProgressBar,
    plain: bool,
    begin: Instant,
    said: Mutex<Instant>,
}

impl ProgressLine {
    /// Begins a line; `nodes_max` is the search's budget.
    pub fn new(nodes_max: usize) -> Self {
        let plain = !std::io::stderr().is_terminal();
        let bar = if plain {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(nodes_max as u64)
        };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {pos}/{len} nodes, {msg}") {
            bar.set_style(style);
        }
        let now = Instant::now();
        Self {
            bar,
            plain,
            begin: now,
            said: Mutex::new(now),
        }
    }

    /// Shows where the search is.
    pub fn show(&self, progress: &Progress) {
        if !self.plain {
            self.bar.set_position(progress.nodes as u64);
            self.bar.set_message(self.text(progress));
            return;
        }
        // A poisoned lock only means that another thread panicked while it printed.
        let said = self.said.lock();
        let mut said = said.unwrap_or_else(std::sync::PoisonError::into_inner);
        if said.elapsed() >= PLAIN_EVERY {
            *said = Instant::now();
            eprintln!("{} nodes, {}", progress.nodes, self.text(progress));
        }
    }

    fn text(&self, progress: &Progress) -> String {
        let rate = progress.solved as f64 / self.begin.elapsed().as_secs_f64().max(1e-3);
        let distance = progress.best_distance_m;
        format!("{distance:.2} m to go, {rate:.0} postures/s")
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
