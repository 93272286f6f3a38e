//! How a command ends, and the exit code that says so.

use std::process::ExitCode;

/// What a command came to; an error is none of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The command did what it is there for: exit code 0.
    Done,
    /// The command ran, and what it checked did not hold: exit code 1.
    Failed,
    /// The search ended without a plan: exit code 3.
    NoPlan,
    /// A stance or motion misses a criterion in the simulation: exit code 3.
    NotExecuted,
    /// The search used up its budget, or was interrupted, before it found a plan: exit code 4.
    BudgetSpent,
}

/// Exit code of an error: a file that is not there, a scan that is broken.
pub const ERROR: u8 = 1;
/// Exit code of a command line that is wrong; clap uses the same.
pub const USAGE: u8 = 2;

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        ExitCode::from(match status {
            Status::Done => 0,
            Status::Failed => ERROR,
            Status::NoPlan | Status::NotExecuted => 3,
            Status::BudgetSpent => 4,
        })
    }
}

/// A mistake on the command line that is only seen after parsing; ends with [`USAGE`].
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);
