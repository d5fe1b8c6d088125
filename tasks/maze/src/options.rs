//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum};

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "maze",
    about = "A simulated arm with a touch probe finds its way out of a maze: prints what was measured, and draws the map as it grows",
    after_help = "Exit status: 0 if the exit was found without a fault, 1 if not,\n2 if the command line or a file was refused; then nothing has moved.\n\nExamples:\n  maze                       the maze that is shipped as islands.txt\n  maze my.txt --out my/      a maze in the text format of micromouse contests\n  maze --sensor force        the same by a force sensor: the ball slides along walls\n  maze --controller reactive without a map\n  maze --sweep tasks/maze/mazes\n  maze --random 100          so many mazes by chance, of 16 by 16 cells",
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
    /// Who decides where to go.
    #[arg(long, value_enum, default_value = "map")]
    pub controller: ControllerKind,
    /// Of where the maze stands, and of the probe: that of every maze of a folder, and of the first one by chance.
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u32,
    /// All mazes of a folder.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "random"])]
    pub sweep: Option<PathBuf>,
    /// So many mazes by chance, each by a seed of its own, from --seed on.
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
    /// The same ball, and a force sensor at the wrist: it slides along walls.
    Force,
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

/// Who decides where to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ControllerKind {
    /// The coordinator, by a map.
    Map,
    /// The arm itself, by what it touches, without a map.
    Reactive,
}

/// By what means walls are felt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Means {
    /// An arm with a touch probe, and a map.
    Probe,
    /// An arm with a force sensor, and a map.
    Force,
    /// An arm with a touch probe, without a map.
    Reactive,
    /// A base with wheels, which sees walls, and a map.
    Wheels,
}

impl From<EffectorKind> for Means {
    fn from(effector: EffectorKind) -> Self {
        match effector {
            EffectorKind::Arm => Self::Probe,
            EffectorKind::Wheels => Self::Wheels,
        }
    }
}

impl Options {
    /// By what means walls are felt; `None` by a camera, which feels none.
    #[must_use]
    pub fn means(&self) -> Option<Means> {
        match (self.controller, self.effector, self.sensor) {
            (_, _, SensorKind::Camera) => None,
            (ControllerKind::Reactive, _, _) => Some(Means::Reactive),
            (ControllerKind::Map, EffectorKind::Wheels, _) => Some(Means::Wheels),
            (ControllerKind::Map, EffectorKind::Arm, SensorKind::Force) => Some(Means::Force),
            (ControllerKind::Map, EffectorKind::Arm, SensorKind::Probe) => Some(Means::Probe),
        }
    }

    /// What cannot be used together, if anything.
    const fn conflict(&self) -> Option<&'static str> {
        match (self.controller, self.effector, self.sensor) {
            (ControllerKind::Reactive, EffectorKind::Wheels, _)
            | (ControllerKind::Reactive, _, SensorKind::Force | SensorKind::Camera) => Some(
                "--controller reactive is an arm's with a touch probe: leave out --effector and --sensor",
            ),
            (ControllerKind::Map, EffectorKind::Wheels, SensorKind::Force | SensorKind::Camera) => {
                Some("--effector wheels sees walls by infrared: leave out --sensor")
            }
            (ControllerKind::Map, EffectorKind::Wheels, SensorKind::Probe) | (_, EffectorKind::Arm, _) => {
                None
            }
        }
    }
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead: the help, or what is wrong.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    let options = Options::try_parse_from(iter::once(OsString::from("maze")).chain(arguments))?;
    match options.conflict() {
        Some(text) => Err(Options::command().error(ErrorKind::ArgumentConflict, text)),
        None => Ok(options),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["my.txt", "--seed", "3"]).expect("right");
        assert_eq!((options.file, options.seed, options.random), (Some(PathBuf::from("my.txt")), 3, None));
        for (arguments, said) in [
            (vec!["--sensor", "radar"], "probe"),
            (vec!["--effector", "legs"], "arm"),
            (vec!["my.txt", "--random", "5"], "cannot be used"),
            (vec!["--controller", "reactive", "--sensor", "force"], "touch probe"),
            (vec!["--controller", "reactive", "--effector", "wheels"], "touch probe"),
            (vec!["--effector", "wheels", "--sensor", "force"], "infrared"),
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
