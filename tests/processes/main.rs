//! A cell as processes of the operating system: the same demands to the bit, and a clean end whatever is killed.
//!
//! This executable is the tests and the task program that they start: it has a main function of its own.

mod allocations;
mod launch;
mod operator;
mod program;
mod records;
mod rows;
mod tests;

use std::process::ExitCode;

fn main() -> ExitCode {
    if std::env::var_os("MRROC_TEST_PROGRAM").is_some() { program::main() } else { tests::main() }
}
