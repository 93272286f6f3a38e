//! The `scandent` program.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    scandent::cli::main()
}
