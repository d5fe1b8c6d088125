//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::Parser;

/// What is chosen.
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(
    name = "legs",
    about = "Four simulated legs carry a trunk over steps of 2 cm: prints what was measured, and draws a film of it",
    after_help = "Exit status: 0 if it walked without a fault, 1 if not,\n2 if the command line or a file was refused; then nothing has moved.\n\nExamples:\n  legs                  one walk over steps by chance\n  legs --seed 7         another one\n  legs --seeds 100      so many walks, without a film",
    args_override_self = true,
    max_term_width = 80
)]
pub struct Options {
    /// Of the ground, its friction and the start.
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u32,
    /// So many walks, from this seed on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub seeds: Option<u32>,
    /// Where the picture goes.
    #[arg(long, value_name = "DIR", default_value = "legs")]
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
    Options::try_parse_from(iter::once(OsString::from("legs")).chain(arguments))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn options_are_read_and_others_refused() {
        let read = |arguments: &[&str]| parse(arguments.iter().map(OsString::from));
        let options = read(&["--seed", "3", "--out", "there"]).expect("right");
        assert_eq!((options.seed, options.seeds, options.out), (3, None, PathBuf::from("there")));
        for (arguments, said) in [(vec!["--seeds", "0"], "1..=100000"), (vec!["trot"], "unexpected")] {
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
