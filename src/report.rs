//! What a run took: the stages' times, the search's size, memory.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use plan::Unsolved;
use planner::Stage;
use schemars::JsonSchema;
use serde::Serialize;

use crate::unseen::{Around, Unseen};

/// The content of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Report {
    /// `verified`, or as [`Unsolved::status`].
    pub status: String,
    /// What blocks the way and what to try, where there is no verified plan.
    pub unsolved: Option<Unsolved>,
    /// Wall-clock time of each stage, ms.
    pub stages_ms: BTreeMap<String, f64>,
    /// Surfaces that the search could use, the ground under the start included.
    pub surfaces: usize,
    /// Contact sets with a posture, the start included.
    pub nodes_generated: usize,
    /// Contact sets of which at least one child was tried.
    pub nodes_expanded: usize,
    /// Contact sets on the path, the start included; 0 without a plan.
    pub path_stances: usize,
    /// How long the motion of the plan takes, s; 0 without one.
    pub motion_s: f64,
    /// Where the robot moves through space that no view looked through; of a plan from scans.
    pub unseen: Option<Unseen>,
    /// Of a plan that was planned again to keep off walls which the border of a view cuts.
    pub around: Option<Around>,
    /// Threads that the search used.
    pub threads: usize,
    /// Largest resident memory of the process so far, MB (10⁶ bytes), where the system tells.
    pub peak_memory_mb: Option<f64>,
}

/// Wall-clock times by stage.
#[derive(Clone, Debug, Default)]
pub struct Stages {
    /// Times so far, ms.
    pub ms: BTreeMap<String, f64>,
}

impl Stages {
    /// Runs `work` and adds its time to the stage.
    pub fn measure<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        tracing::info!("{stage}: {ms:.1} ms");
        *self.ms.entry(stage.to_owned()).or_default() += ms;
        result
    }

    /// The times in words.
    pub fn text(&self) -> String {
        let times = self.ms.iter();
        let times: Vec<String> = times
            .map(|(stage, ms)| format!("{stage} {ms:.1} ms"))
            .collect();
        times.join(", ")
    }

    /// Takes a part of a stage's time out of it and gives it to another.
    pub fn split(&mut self, whole: &str, part: &str, ms: f64) {
        *self.ms.entry(whole.to_owned()).or_default() -= ms;
        *self.ms.entry(part.to_owned()).or_default() += ms;
    }
}

/// What the planner's time goes to, from its own progress.
#[derive(Debug, Default)]
pub struct Clock {
    /// Time spent on motions so far, and since when it looks for one.
    state: Mutex<(Duration, Option<Instant>)>,
}

impl Clock {
    /// Notes what the planner does from now on.
    pub fn note(&self, stage: Stage) {
        let mut state = self.lock();
        match (stage, state.1) {
            (Stage::Motion { .. }, None) => state.1 = Some(Instant::now()),
            (Stage::Search, Some(since)) => {
                state.0 += since.elapsed();
                state.1 = None;
            }
            _ => {}
        }
    }

    /// Time spent on motions, ms.
    pub fn motion_ms(&self) -> f64 {
        self.lock().0.as_secs_f64() * 1e3
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, (Duration, Option<Instant>)> {
        // A poisoned lock only means that another thread panicked while it noted.
        let state = self.state.lock();
        state.unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Largest resident memory of this process so far, MB (10⁶ bytes); `None` where only an unsafe
/// system call would tell.
pub fn peak_memory_mb() -> Option<f64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    peak_in_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The `VmHWM` line of Linux's `/proc/PID/status`, MB.
fn peak_in_status(status: &str) -> Option<f64> {
    let mut lines = status.lines();
    let line = lines.find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024.0 / 1e6)
}

/// The value below which the part `q` of the values lies: the nearest rank; 0 of no values.
pub fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let rank = (q * values.len() as f64).ceil() as usize;
    let value = values.get(rank.saturating_sub(1).min(last));
    value.copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_read_from_linuxs_status() {
        let status = "Name:\tscandent\nVmPeak:\t  900000 kB\nVmHWM:\t   31250 kB\n";
        assert_eq!(peak_in_status(status), Some(32.0));
        assert_eq!(peak_in_status("Name:\tx\n"), None);
        assert_eq!(peak_memory_mb().is_some(), cfg!(target_os = "linux"));
    }

    #[test]
    fn a_stage_that_runs_twice_adds_up() {
        let mut stages = Stages::default();
        let pause = std::time::Duration::from_millis(2);
        for _ in 0..2 {
            stages.measure("perception", || std::thread::sleep(pause));
        }
        assert!(stages.ms["perception"] >= 4.0, "{:?}", stages.ms);
    }

    #[test]
    fn quantiles_are_nearest_ranks() {
        let mut values: Vec<f64> = (1..=20).rev().map(f64::from).collect();
        assert_eq!(quantile(&mut values, 0.5), 10.0);
        assert_eq!(quantile(&mut values, 0.95), 19.0);
        assert_eq!(quantile(&mut values, 1.0), 20.0);
        assert_eq!(quantile(&mut [3.0], 0.5), 3.0);
        assert_eq!(quantile(&mut [], 0.5), 0.0);
    }
}
