//! The `scandent` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    scandent::cli::main()
}
