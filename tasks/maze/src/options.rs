//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::{Parser, ValueEnum};

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "maze",
    about = "A simulated arm with a touch probe finds its way out of a maze: prints what was measured, and draws the map as it grows",
    after_help = "Exit status: 0 if the exit was found without a fault, 1 if not,\n2 if the command line or a file was refused; then nothing has moved.\n\nExamples:\n  maze                       the maze that is shipped as islands.txt\n  maze my.txt --out my/      a maze in the text format of micromouse contests\n  maze --sweep tasks/maze/mazes\n  maze --random 100          so many mazes by chance, of 16 by 16 cells",
    args_override_self = true,
    max_term_width = 80
)]
pub struct Options {
    /// The maze.
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// What walls are felt by.
    #[arg(long, value_enum, default_value = "probe")]
    pub sensor: SensorKind,
    /// What carries the sensor.
    #[arg(long, value_enum, default_value = "arm")]
    pub effector: EffectorKind,
    /// Of where the maze stands, and of the probe.
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u32,
    /// All mazes of a folder.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "random"])]
    pub sweep: Option<PathBuf>,
    /// So many mazes by chance, seeds from 0.
    #[arg(long, value_name = "N", conflicts_with = "file", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub random: Option<u32>,
    /// Where the picture goes.
    #[arg(long, value_name = "DIR", default_value = "maze")]
    pub out: PathBuf,
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
}

/// What walls are felt by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SensorKind {
    /// A ball on a spring with a switch.
    Probe,
    /// None is felt: a camera sees them all from above.
    Camera,
}

/// What carries the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EffectorKind {
    /// An IRp-6.
    Arm,
    /// A base with two driven wheels, which sees walls by infrared.
    Wheels,
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead: the help, or what is wrong.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    Options::try_parse_from(iter::once(OsString::from("maze")).chain(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["my.txt", "--seed", "3"]).expect("right");
        assert_eq!((options.file, options.seed, options.random), (Some(PathBuf::from("my.txt")), 3, None));
        for (arguments, said) in [
            (vec!["--sensor", "radar"], "probe"),
            (vec!["--effector", "legs"], "arm"),
            (vec!["my.txt", "--random", "5"], "cannot be used"),
            (vec!["--random", "0"], "1..=100000"),
        ] {
            let text = read(&arguments).expect_err("wrong").to_string();
            assert!(text.contains(said), "{text}");
        }
    }

    #[test]
    fn the_help_fits_a_terminal() {
        Options::command().debug_assert();
        let help = parse(["-h".into()]).expect_err("help").to_string();
        assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    }
}
