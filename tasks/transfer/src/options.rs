//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use lexopt::prelude::*;
use mrroc::Clock;

use crate::variant::{Bases, Sensors};

/// What `--help` prints.
pub const HELP: &str = "\
Two simulated arms carry a bar together: prints what was measured, and draws
one of the runs.

Options:
  --no-sensor            draw the run without force sensors
  --no-error             draw the run with bases where they are believed to be
  --cell FILE            the cell [default: the task's own cell.toml]
  --processes            run every process of the cell as one of the operating
                         system, in real time (Linux); draws arms.svg alone, and
                         measures nothing
  --virtual              the same in lock-step under the virtual clock
  status, suspend, resume, speed 50%, abort, stop, console
                         from another terminal, to the arms that carry the bar
                         by --processes
  doctor                 say what this machine can do for --processes
  --out DIR              where the pictures go [default: transfer]
  -q, --quiet            print errors only
  -h, --help             print this text

Exit status: 0 if all runs ended well and kept their bounds, 1 if not, 2 if
the cell or the command line was refused; then nothing has moved.
";

/// How much is said on the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Talk {
    /// The table.
    Normal,
    /// Errors only.
    Quiet,
}

/// What may be chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Of the run that is drawn.
    pub bases: Bases,
    /// Of the run that is drawn.
    pub sensors: Sensors,
    /// The cell's file; its own if none.
    pub cell: Option<PathBuf>,
    /// Where the pictures go.
    pub out: PathBuf,
    /// Whether the cell of the run that is drawn runs as processes of the operating system instead, and in whose time.
    pub processes: Option<Clock>,
    /// What is said.
    pub talk: Talk,
}

impl Default for Options {
    fn default() -> Self {
        let (bases, sensors, talk) = (Bases::Off, Sensors::Used, Talk::Normal);
        Options { bases, sensors, cell: None, out: PathBuf::from("transfer"), processes: None, talk }
    }
}

/// A command line that cannot be followed.
#[derive(Debug, thiserror::Error)]
#[error("{0}\n help: see --help")]
pub struct BadOption(#[from] lexopt::Error);

/// Reads the arguments; nothing when the help is asked for.
///
/// # Errors
/// An option that there is not, or one without its value.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Options>, BadOption> {
    let mut parser = lexopt::Parser::from_args(arguments);
    let mut options = Options::default();
    while let Some(argument) = parser.next()? {
        match argument {
            Long("no-sensor") => options.sensors = Sensors::Unused,
            Long("no-error") => options.bases = Bases::Calibrated,
            Long("processes") => options.processes = options.processes.or(Some(Clock::Real)),
            Long("virtual") => options.processes = Some(Clock::Virtual),
            Long("cell") => options.cell = Some(parser.value()?.into()),
            Long("out") => options.out = parser.value()?.into(),
            Short('q') | Long("quiet") => options.talk = Talk::Quiet,
            Short('h') | Long("help") => return Ok(None),
            other => return Err(other.unexpected().into()),
        }
    }
    Ok(Some(options))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["--no-sensor", "--out=x", "-q"]).expect("right").expect("no help");
        assert_eq!((options.sensors, options.bases), (Sensors::Unused, Bases::Off));
        assert_eq!((options.out, options.talk), (PathBuf::from("x"), Talk::Quiet));
        assert_eq!(options.processes, None);
        for (arguments, clock) in
            [(&["--processes"][..], Clock::Real), (&["--virtual", "--processes"], Clock::Virtual)]
        {
            assert_eq!(read(arguments).expect("right").expect("no help").processes, Some(clock));
        }
        assert_eq!(read(&["-h"]).expect("right"), None);
        assert!(read(&["--sensors"]).expect_err("none").to_string().contains("--sensors"));
        assert!(read(&["--out"]).is_err());
    }
}
