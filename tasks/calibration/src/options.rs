//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::Parser;

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "calibration",
    about = "Two simulated arms are calibrated by two simulated theodolites: prints what\nwas found, and writes a calibration of each arm, and pictures",
    after_help = "It takes about half a minute, and says on the standard error how far it is.\n\nExit status: 0 if both arms were calibrated, 1 if not,\n2 if the command line was refused; then nothing was computed.\n\nExamples:\n  calibration                       120 postures\n  calibration --seed 7              other arms, and other noise\n  calibration --visits 40           so many postures: sooner, and less sure\n\nArms of your own are calibrated by `calibrate`: see the book, Calibration.",
    args_override_self = true,
    max_term_width = 80
)]
pub struct Options {
    /// Of the arms' true dimensions, the instruments' errors and the noise.
    #[arg(long, value_name = "N", default_value = "1")]
    pub seed: u32,
    /// Postures that are measured.
    #[arg(long, value_name = "N", default_value = "120", value_parser = clap::value_parser!(u32).range(20..=400))]
    pub visits: u32,
    /// Where calibrations and pictures go.
    #[arg(long, value_name = "DIR", default_value = "calibration")]
    pub out: PathBuf,
    /// Print errors only.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What there is to say instead: the help, or what is wrong.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    Options::try_parse_from(iter::once(OsString::from("calibration")).chain(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["--seed", "3", "--out", "there"]).expect("right");
        assert_eq!((options.seed, options.visits, options.out), (3, 120, PathBuf::from("there")));
        for (arguments, said) in [
            (vec!["--visits", "3"], "20..=400"),
            (vec!["--seed", "-1"], "unexpected"),
            (vec!["folder"], "unexpected"),
            (vec!["--sed", "3"], "--seed"),
        ] {
            let text = read(&arguments).expect_err("wrong").to_string();
            assert!(text.contains(said), "{text}");
        }
    }

    #[test]
    fn the_help_fits_a_terminal() {
        Options::command().debug_assert();
        let help = parse(["--help".into()]).expect_err("help");
        assert_eq!(help.kind(), clap::error::ErrorKind::DisplayHelp);
        assert!(help.to_string().lines().all(|line| line.len() <= 80), "{help}");
    }
}
