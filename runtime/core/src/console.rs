//! What a task program says on its standard output and error: `launch`'s, and a program's own.

use core::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;

/// Prints a text. A reader that has had enough and closed the pipe is no failure.
#[must_use = "the exit status tells whether it could be written"]
pub fn say(text: &str) -> ExitCode {
    match io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            complain(&format!("error: the standard output cannot be written: {error}"));
            ExitCode::FAILURE
        }
        Ok(()) | Err(_) => ExitCode::SUCCESS,
    }
}

/// Prints a line on the standard error: without one the exit status alone must tell.
pub fn complain(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Tells of an error before anything has moved: exit status 2.
#[must_use = "the exit status tells that nothing has moved"]
pub fn refused(error: &dyn Display) -> ExitCode {
    complain(&format!("error: {error}"));
    ExitCode::from(2)
}
