//! How a command ends, and the exit code that says so.

/// What a command came to; an error is none of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The command did what it is there for: exit code 0.
    Done,
    /// The command ran, and what it checked did not hold: exit code 1.
    Failed,
    /// There is no plan, and that is proved: exit code 3.
    NoPlan,
    /// A stance or motion misses a criterion in the simulation: exit code 3.
    NotExecuted,
    /// The search ended before it found a plan, and none is excluded: its budget is spent, everything
    /// was tried, or it was interrupted. Exit code 4.
    Undecided,
}

/// Exit code of an error: a file that is not there, a scan that is broken.
pub const ERROR: u8 = 1;
/// Exit code of a command line that is wrong; clap uses the same.
pub const USAGE: u8 = 2;

impl Status {
    /// Its exit code.
    pub fn code(self) -> u8 {
        match self {
            Status::Done => 0,
            Status::Failed => ERROR,
            Status::NoPlan | Status::NotExecuted => 3,
            Status::Undecided => 4,
        }
    }

    /// Its name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Status::Done => "done",
            Status::Failed => "failed",
            Status::NoPlan => "no_plan",
            Status::NotExecuted => "not_executed",
            Status::Undecided => "undecided",
        }
    }
}

/// A mistake on the command line that is only seen after parsing; ends with [`USAGE`].
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);
