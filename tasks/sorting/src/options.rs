//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::{Parser, ValueEnum};

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "sorting",
    about = "Parts on a moving belt are sensed, acquired and sorted by a simulated arm: prints what was measured, and draws it",
    after_help = "Exit status: 0 if every part was sorted or passed, none wrongly, 1 if not,\n2 if the command line was refused; then nothing has moved.\n\nExamples:\n  sorting --belt 0.1 --parts 20\n  sorting --first-edge          led by the first edge alone: misses most parts\n  sorting --sweep 1000          so many seeds over all speeds, beside open loop\n  sorting --sensor camera --belt 0.1 --parts 200\n  sorting --sensor camera --belt 0.1 --parts 200 --arms 2\n  sorting --sensor camera --examine 2000\n  sorting --sensor ultrasonic --belt 0.1 --parts 200\n  sorting --sensor camera --strangers 8 --touching 9 --profile 60:0,63:1",
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
    /// The arm is led by the first edge of each part alone.
    #[arg(long)]
    pub first_edge: bool,
    /// Infrared: one part for each of so many seeds, over all speeds. Camera, ultrasonic: so many parts at each of several speeds and
    /// three arrival rates: 40, 60 and 80 % of the cycle-time bound, which is measured first.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
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
    #[arg(long, value_name = "TIME:SHARE,..", value_delimiter = ',', value_parser = change, conflicts_with_all = ["examine", "images", "data_set"])]
    pub profile: Vec<(f64, f64)>,
    /// Camera, ultrasonic: one part in so many is a stranger, which is to pass.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000), conflicts_with_all = ["examine", "images", "data_set"])]
    pub strangers: Option<u32>,
    /// Camera, ultrasonic: one part in so many touches the part before it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000), conflicts_with_all = ["examine", "images", "data_set"])]
    pub touching: Option<u32>,
    /// Camera, ultrasonic: recognise so many parts, one in ten a stranger, without a cell.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub examine: Option<u32>,
    /// Camera: evaluate the images of a folder, PNG files of 768 x 576 grey pixels; `empty.png` is that of the empty belt.
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,
    /// Camera, ultrasonic: write the features of --parts parts, to train a network by.
    #[arg(long, value_name = "FILE")]
    pub data_set: Option<PathBuf>,
    /// Where the pictures go.
    #[arg(long, value_name = "DIR", default_value = "sorting")]
    pub out: PathBuf,
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
}

/// What parts are seen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SensorKind {
    /// Light barriers, a range finder, and a barrier between the fingers.
    Infrared,
    /// A camera over the belt, and the belt's encoder: eight kinds of parts, a queue.
    Camera,
    /// An ultrasonic matrix in place of the camera.
    Ultrasonic,
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
    Options::try_parse_from(iter::once(OsString::from("sorting")).chain(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

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
    fn the_help_fits_a_terminal() {
        Options::command().debug_assert();
        let help = parse(["-h".into()]).expect_err("help").to_string();
        assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    }
}
