//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, FromArgMatches as _, Parser};

use crate::camera::settings::Settings as Recognising;
use crate::generators::Uneven;
use crate::run::Settings;
use crate::scopes::{Mode, SensorKind, is_given, without_effect};

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "sorting",
    about = "Parts on a moving belt are sensed, acquired and sorted by a simulated arm: prints what was measured, and draws it",
    after_help = "Exit status:\n  0  parts were sorted, none wrongly; some may have been missed\n  1  a part came into a wrong tray, a finger came down on one, none was sorted,\n     or a fault ended a run; --examine: something was taken for what it is not,\n     or no part was recognised\n  2  the command line was refused: nothing has moved\n\nExamples:\n  sorting --belt 0.1 --parts 20\n  sorting --first-edge          led by the first edge alone: misses most parts\n  sorting --sweep 1000          so many seeds over all speeds, beside open loop\n  sorting --sensor camera --belt 0.1 --parts 200\n  sorting --sensor camera --belt 0.1 --parts 200 --arms 2\n  sorting --sensor camera --examine 2000\n  sorting --sensor ultrasonic --belt 0.1 --parts 200\n  sorting --sensor camera --strangers 8 --touching 9 --profile 60:0,63:1",
    args_override_self = true,
    max_term_width = 80
)]
pub struct Options {
    /// What parts are seen by.
    #[arg(long, value_enum, default_value = "infrared")]
    pub sensor: SensorKind,
    /// Nominal speed of the belt [m/s], 0.02 to 0.15; its true one is up to 20 % off, and wanders.
    #[arg(long, value_name = "M_PER_S", default_value = "0.1", value_parser = speed)]
    pub belt: f64,
    /// How many parts come.
    #[arg(long, value_name = "N", default_value = "200", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub parts: u32,
    /// Of parts, noise and belt.
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u32,
    /// Camera, ultrasonic: how many arms share the belt, 1 or 2.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=2))]
    pub arms: u32,
    /// Infrared: the arm is led by the first edge of each part alone.
    #[arg(long)]
    pub first_edge: bool,
    /// Infrared: one part for each of so many seeds, over all speeds. Camera, ultrasonic: so many parts at each of several speeds and
    /// three arrival rates: 40, 60 and 80 % of the cycle-time bound, which is measured first.
    #[arg(long, value_name = "N", group = "mode", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub sweep: Option<u32>,
    /// Camera, ultrasonic: the speeds of a sweep [m/s].
    #[arg(long, value_name = "M_PER_S,..", default_value = "0.05,0.1,0.15", value_delimiter = ',', value_parser = speed)]
    pub speeds: Vec<f64>,
    /// Camera, ultrasonic: mean time between two parts in seconds; by default the arm has to work for 60 % of the time.
    #[arg(long, value_name = "SECONDS", value_parser = interval)]
    pub every: Option<f64>,
    /// Camera, ultrasonic: parts come quite at random, as Poisson's law says; else at least 70 % of the mean time after another.
    #[arg(long)]
    pub poisson: bool,
    /// How the belt's speed changes: from each TIME in seconds on it goes at SHARE of its speed, such as `30:0,32:1` for a stop of two seconds, or
    /// `20:0.5,40:1.2`.
    #[arg(long, value_name = "TIME:SHARE,..", value_delimiter = ',', value_parser = change)]
    pub profile: Vec<(f64, f64)>,
    /// Camera, ultrasonic: one part in so many is a stranger, which is to pass.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub strangers: Option<u32>,
    /// Camera, ultrasonic: one part in so many touches the part before it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub touching: Option<u32>,
    /// Camera, ultrasonic: recognise so many parts, one in ten a stranger, without a cell.
    #[arg(long, value_name = "N", group = "mode", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub examine: Option<u32>,
    /// Camera, which needs no --sensor here: say what is on each image of a folder, and where. The images are PNG files of 768 x 576 grey
    /// pixels; one of them, `empty.png`, shows the belt without parts. `--sensor camera --examine 10` writes such a folder to try. Each image
    /// is drawn anew with what was found on it, as `image-NAME.png` in the folder of --out.
    #[arg(long, value_name = "DIR", group = "mode")]
    pub images: Option<PathBuf>,
    /// Camera (without --sensor, too), ultrasonic: write the features of --parts parts, to train a network by.
    #[arg(long, value_name = "FILE", group = "mode")]
    pub data_set: Option<PathBuf>,
    /// Where the pictures go. Those of an earlier run are replaced; one that this run does not draw stays, and is named at the end.
    #[arg(long, value_name = "DIR", default_value = "sorting")]
    pub out: PathBuf,
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
}

/// A speed that the task is made for.
fn speed(text: &str) -> Result<f64, String> {
    let speed: f64 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    let fits = (0.02..=0.15).contains(&speed);
    if fits { Ok(speed) } else { Err(format!("{speed} m/s: the belt runs at 0.02 to 0.15 m/s")) }
}

/// From when on a belt goes at which share of its speed.
fn change(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("`{text}`: write a time [s] and a share of -1 to 1.2, such as 30:0.5");
    let (time, share) = text.split_once(':').ok_or_else(wrong)?;
    let (time, share) = (time.parse().map_err(|_| wrong())?, share.parse().map_err(|_| wrong())?);
    let fits = (0.0..=1e6).contains(&time) && (-1.0..=1.2).contains(&share);
    if fits { Ok((time, share)) } else { Err(wrong()) }
}

/// A time between two parts.
fn interval(text: &str) -> Result<f64, String> {
    let every: f64 = text.parse().map_err(|_| format!("`{text}` is no number"))?;
    let fits = (1.0..=1000.0).contains(&every);
    if fits { Ok(every) } else { Err(format!("{every} s: parts come every 1 to 1000 s")) }
}

impl Options {
    /// The mean time between two parts below a camera or matrix \[s\].
    #[must_use]
    pub fn mean_time(&self) -> f64 {
        self.every.unwrap_or(Recognising::CYCLE / (0.6 * f64::from(self.arms)))
    }

    /// The belt's [`profile`](Self::profile) in the order of time, for as long as the program runs.
    #[must_use]
    pub fn lasting_profile(&self) -> &'static [(f64, f64)] {
        let mut profile = self.profile.clone();
        profile.sort_by(|a, b| a.0.total_cmp(&b.0));
        Vec::leak(profile)
    }
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead: the help, or what is wrong.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    let mut command = Options::command();
    let matches = command.try_get_matches_from_mut(iter::once(OsString::from("sorting")).chain(arguments))?;
    let mut options = Options::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    let mode = Mode::of(&matches);
    if matches!(mode, Mode::Images | Mode::DataSet) && !is_given(&matches, "sensor") {
        options.sensor = SensorKind::Camera;
    }
    if let Some(wrong) = without_effect(&matches, options.sensor, mode) {
        return Err(command.error(ErrorKind::ArgumentConflict, wrong));
    }
    match too_long(&options, mode) {
        Some(wrong) => Err(command.error(ErrorKind::ValueValidation, wrong)),
        None => Ok(options),
    }
}

/// So far a belt may run \[m\]: its joint has an end, far away.
const LONGEST: f64 = 950.0;

/// What is wrong with a run for which the belt, at its fastest, would have to run too far.
fn too_long(options: &Options, mode: Mode) -> Option<String> {
    if mode != Mode::Run {
        return None;
    }
    let (parts, belt) = (f64::from(options.parts), options.belt);
    let every = match options.sensor {
        SensorKind::Infrared => Settings::one(belt, 0).every(),
        SensorKind::Camera | SensorKind::Ultrasonic => options.mean_time(),
    };
    let travel = parts * every * belt * (1.0 + Uneven::OFF);
    (travel > LONGEST).then(|| {
        format!("the belt would run {travel:.0} m, at most {LONGEST} m: let fewer parts come, or sooner\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(arguments: &[&str]) -> Result<Options, clap::Error> {
        parse(arguments.iter().map(OsString::from))
    }

    #[test]
    fn options_are_read_and_others_refused() {
        let options = read(&["--sensor", "infrared", "--belt", "0.15", "--parts", "20"]).expect("right");
        assert_eq!((options.belt, options.parts, options.sweep), (0.15, 20, None));
        let options = read(&["--profile", "30:0,32.5:1"]).expect("right");
        assert_eq!(options.profile, [(30.0, 0.0), (32.5, 1.0)]);
        assert_eq!(read(&[]).expect("right").out, PathBuf::from("sorting"));
        for (arguments, said) in [
            (["--belt", "0.3"], "0.02 to 0.15 m/s"),
            (["--belt", "NaN"], "0.02 to 0.15 m/s"),
            (["--belt", "fast"], "no number"),
            (["--sensor", "radar"], "infrared"),
            (["--parts", "0"], "1..=100000"),
            (["--profile", "30"], "a time"),
            (["--profile", "10:1,20:7"], "share of -1 to 1.2"),
            (["--touching", "1"], "2..=100000"),
        ] {
            let text = read(&arguments).expect_err("wrong").to_string();
            assert!(text.contains(said), "{text}");
        }
    }

    #[test]
    fn options_that_have_no_effect_are_refused_with_what_they_go_with() {
        for (line, wanted) in [
            (
                "--examine 9",
                "--examine has no effect with --sensor infrared: it goes with --sensor camera or ultrasonic\n",
            ),
            ("--poisson", "it goes with --sensor camera or ultrasonic, alone or with --sweep\n"),
            ("--every 9", "it goes with --sensor camera or ultrasonic, alone\n"),
            ("--sensor camera --every 9 --sweep 9", "--every has no effect with --sensor camera and --sweep"),
            ("--arms 2", "--arms has no effect with --sensor infrared"),
            ("--strangers 8", "--strangers has no effect with --sensor infrared"),
            ("--touching 8", "--touching has no effect with --sensor infrared"),
            ("--speeds 0.1", "with --sensor camera or ultrasonic, with --sweep\n"),
            ("--sensor camera --first-edge", "it goes with --sensor infrared, alone\n"),
            ("--first-edge --sweep 9", "--first-edge has no effect with --sensor infrared and --sweep"),
            (
                "--parts 9 --sweep 9",
                "it goes with any --sensor, alone, or with --sensor camera or ultrasonic, with --data-set\n",
            ),
            ("--seed 9 --sweep 9", "--seed has no effect with --sensor infrared and --sweep"),
            ("--profile 9:0 --sweep 9", "--profile has no effect with --sensor infrared and --sweep"),
            ("--sensor camera --belt 0.1 --sweep 9", "--belt has no effect with --sensor camera and --sweep"),
            (
                "--sensor camera --examine 9 --profile 9:0",
                "--profile has no effect with --sensor camera and --examine",
            ),
            (
                "--sensor ultrasonic --images x",
                "--images has no effect with --sensor ultrasonic: it goes with --sensor camera\n",
            ),
            ("--images x --seed 9", "--seed has no effect with --sensor camera and --images"),
            ("--data-set x --out y", "--out has no effect with --sensor camera and --data-set"),
            ("--sensor camera --examine 9 --sweep 9", "cannot be used with"),
        ] {
            let error = read(&line.split(' ').collect::<Vec<_>>()).expect_err(line);
            assert_eq!(error.exit_code(), 2, "{line}");
            assert!(error.to_string().contains(wanted), "{line}: {error}");
        }
        for line in [
            "--sensor camera --belt 0.1 --parts 9 --seed 9 --arms 2 --every 9 --poisson --profile 9:0 --strangers 8 --touching 9 --out x",
            "--sensor ultrasonic --sweep 9 --seed 9 --arms 2 --speeds 0.1 --poisson --profile 9:0 --strangers 8 --touching 9",
            "--belt 0.1 --parts 9 --seed 9 --first-edge --profile 9:0",
            "--sensor ultrasonic --data-set x --parts 9 --seed 9 --quiet",
        ] {
            assert!(read(&line.split(' ').collect::<Vec<_>>()).is_ok(), "{line}");
        }
        for line in ["--images x", "--data-set x"] {
            let options = read(&line.split(' ').collect::<Vec<_>>()).expect("right");
            assert_eq!(options.sensor, SensorKind::Camera, "{line}");
        }
    }

    #[test]
    fn a_run_for_which_the_belt_is_too_short_is_refused() {
        for line in [
            "--sensor camera --belt 0.15 --parts 500 --every 20",
            "--sensor ultrasonic --belt 0.15 --parts 100000",
            "--belt 0.15 --parts 500",
        ] {
            let error = read(&line.split(' ').collect::<Vec<_>>()).expect_err(line);
            assert_eq!(error.exit_code(), 2, "{line}");
            assert!(error.to_string().contains("at most 950 m"), "{line}: {error}");
        }
        // 500 parts every 10 s at 0.15 m/s, 20 % faster: 900 m.
        let line = "--sensor camera --belt 0.15 --parts 500 --every 10";
        assert!(read(&line.split(' ').collect::<Vec<_>>()).is_ok(), "{line}");
    }

    #[test]
    fn the_help_fits_a_terminal() {
        Options::command().debug_assert();
        let help = parse(["-h".into()]).expect_err("help").to_string();
        assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    }
}
