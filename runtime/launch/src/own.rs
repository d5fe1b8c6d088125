//! Options of a task program that has no command line of its own: what stands after `--`.
//!
//! In: the arguments of this process, which a launcher gives to every process of the cell. Out: the value of an option.

use std::ffi::{OsStr, OsString};
use std::str::FromStr;

use mrroc_core::fault::Fault;

/// Whether options of the program itself begin here.
pub(crate) fn is_beginning(argument: &OsStr) -> bool {
    argument == "--"
}

/// The value of an option that stands behind `--` on the command line, as in `cargo run -- --processes -- --times 3`: `3` for `times`.
/// `None` where the option is not given; empty where nothing follows it but another option.
///
/// The program's function that makes the cell may ask for it: every process of the cell gets the same command line.
///
/// ```
/// let times = mrroc_launch::own_option("times").map_or(Ok(1), |times| times.parse::<u32>());
/// assert_eq!(times, Ok(1), "it was not given");
/// ```
#[must_use]
pub fn own_option(name: &str) -> Option<String> {
    of(std::env::args_os(), name)
}

/// The number of such an option, or `default` where the option is not given.
///
/// ```
/// # fn program() -> Result<(), mrroc_core::fault::Fault> {
/// let times = mrroc_launch::own_number("times", 1)?;
/// # assert_eq!(times, 1);
/// # Ok(())
/// # }
/// # program().expect("it was not given");
/// ```
///
/// # Errors
/// What is given is no such number.
pub fn own_number<N: FromStr>(name: &str, default: N) -> Result<N, Fault> {
    own_option(name)
        .map_or(Ok(default), |number| number.parse())
        .map_err(|_| Fault::thrown(&format!("--{name} needs a number")))
}

fn of(arguments: impl IntoIterator<Item = OsString>, name: &str) -> Option<String> {
    let mut own = arguments.into_iter().skip_while(|argument| !is_beginning(argument)).skip(1).peekable();
    own.find(|argument| argument.to_str().and_then(|argument| argument.strip_prefix("--")) == Some(name))?;
    let value = own.next_if(|value| !value.as_encoded_bytes().starts_with(b"--"));
    Some(value.unwrap_or_default().to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(line: &str, name: &str) -> Option<String> {
        of(line.split(' ').map(OsString::from), name)
    }

    #[test]
    fn an_option_of_the_program_stands_behind_two_dashes() {
        let line = "program --processes --quiet -- --times 3 --slow --from -0.5";
        assert_eq!(asked(line, "times").as_deref(), Some("3"));
        assert_eq!(asked(line, "slow").as_deref(), Some(""));
        assert_eq!(asked(line, "from").as_deref(), Some("-0.5"));
        // It is one of the launcher.
        assert_eq!(asked(line, "quiet"), None);
        assert_eq!(asked("program --times 3", "times"), None);
    }
}
