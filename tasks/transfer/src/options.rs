//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::Parser;
use mrroc::launch::{Clock, Launch};

use crate::variant::{Bases, Sensors};

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
    /// Where to write what the arms' controllers say where both touch the same points, instead of all else.
    pub touches: Option<PathBuf>,
    /// What is said.
    pub talk: Talk,
}

/// The command line as it is written.
#[derive(Debug, Parser)]
#[command(
    about = "Two simulated arms carry a bar together: prints what was measured, and draws one of the runs",
    override_usage = "transfer [OPTIONS]\n       transfer COMMAND",
    after_help = after_help(),
    args_override_self = true,
    max_term_width = 80
)]
struct Arguments {
    /// Draw the run without force sensors.
    #[arg(long)]
    no_sensor: bool,
    /// Draw the run with bases where they are believed to be.
    #[arg(long)]
    no_error: bool,
    /// The cell [default: the task's own cell.toml].
    #[arg(long, value_name = "FILE")]
    cell: Option<PathBuf>,
    /// Only write what the arms' controllers say where both touch the same
    /// points, for `calibrate bases`.
    #[arg(long, value_name = "FILE")]
    touches: Option<PathBuf>,
    /// Where the pictures go.
    #[arg(long, value_name = "DIR", default_value = "transfer")]
    out: PathBuf,
    /// Print errors only.
    #[arg(short, long)]
    quiet: bool,
    /// Run every process of the cell as one of the operating system, in real time (Linux); draws arms.svg alone, and
    /// measures nothing.
    #[arg(long, help_heading = "Processes")]
    processes: bool,
    /// The same in lock-step under the virtual clock.
    #[arg(long = "virtual", help_heading = "Processes")]
    lock_step: bool,
}

fn after_help() -> String {
    let launch = Launch::help();
    format!(
        "{launch}

Exit status: 0 if all runs ended well and kept their bounds, 1 if not, 2 if
the cell or the command line was refused; then nothing has moved.

Examples:
  transfer --out pictures/           all runs; draws the one with force sensors
  transfer --no-sensor               draws the one without
  transfer --processes               in real time; meanwhile, elsewhere:
  transfer suspend"
    )
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead ([`Launch::answer`]): the help, or what is wrong.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    let read = Arguments::try_parse_from(iter::once(OsString::from("transfer")).chain(arguments))?;
    Ok(Options {
        bases: if read.no_error { Bases::Calibrated } else { Bases::Off },
        sensors: if read.no_sensor { Sensors::Unused } else { Sensors::Used },
        cell: read.cell,
        out: read.out,
        touches: read.touches,
        processes: match (read.processes, read.lock_step) {
            (_, true) => Some(Clock::Virtual),
            (true, false) => Some(Clock::Real),
            (false, false) => None,
        },
        talk: if read.quiet { Talk::Quiet } else { Talk::Normal },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["--no-sensor", "--out=x", "-q"]).expect("right");
        assert_eq!((options.sensors, options.bases), (Sensors::Unused, Bases::Off));
        assert_eq!((options.out, options.talk), (PathBuf::from("x"), Talk::Quiet));
        assert_eq!(options.processes, None);
        assert_eq!(read(&[]).expect("right").out, PathBuf::from("transfer"));
        for (arguments, clock) in
            [(&["--processes"][..], Clock::Real), (&["--virtual", "--processes"], Clock::Virtual)]
        {
            assert_eq!(read(arguments).expect("right").processes, Some(clock));
        }
        assert!(read(&["--sensors"]).expect_err("none").to_string().contains("'--no-sensor'"));
        assert!(read(&["--out"]).expect_err("no folder").to_string().contains("'--out <DIR>'"));
    }

    #[test]
    fn the_help_fits_a_terminal() {
        Arguments::command().debug_assert();
        let help = parse(["-h".into()]).expect_err("help").to_string();
        assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    }
}
