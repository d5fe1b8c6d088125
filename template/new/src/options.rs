//! The command line.

use std::ffi::OsString;
use std::iter;
use std::path::PathBuf;

use clap::Parser;

use crate::choices::Given;
use crate::error::Error;

/// What the command line asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// A new project.
    Project(Project),
    /// A copy of a generator.
    Generator {
        /// The library's name of it.
        name: String,
        /// The name of the copy.
        as_name: String,
    },
    /// The Python side of this sensor of the project's cell.
    External(String),
    /// The list of generators, to be printed.
    Generators,
    /// The list of choices, to be printed.
    Choices,
    /// The help or the version, to be printed.
    Print(String),
}

/// A new project.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Project {
    /// Its name.
    pub name: String,
    /// The folder in which its folder is made.
    pub into: PathBuf,
    /// What was chosen already.
    pub given: Given,
    /// How the rest is chosen.
    pub rest: Rest,
}

/// How the choices are made that the command line leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Somebody is asked, if somebody is there.
    Asked,
    /// By default.
    Default,
}

const AFTER_HELP: &str = "\
What --define leaves open is asked for when there is a terminal, and otherwise
taken by default.

Exit status: 0 if it was made, 2 if what was asked for was refused, and 1 if
it failed; then nothing was written.

Examples:
  mrroc-new my-task                  asks what it shall be
  mrroc-new my-task --defaults       asks nothing
  mrroc-new my-pair -d robots=two    asks the rest
  mrroc-new generator straight_line  in a project: copies it there
  mrroc-new external --python camera in a project: a program that sends what
                                     its sensor `camera` reads";

/// The command line as it is written.
#[derive(Debug, Parser)]
#[command(
    version,
    about = "Makes a new mrroc project, and copies generators of the library into it",
    override_usage = "mrroc-new [OPTIONS] NAME\n       mrroc-new generator [--as NAME] GENERATOR\n       mrroc-new generator --list\n       mrroc-new external --python SENSOR",
    after_help = AFTER_HELP,
    args_override_self = true,
    max_term_width = 80
)]
struct Arguments {
    #[arg(value_name = "NAME", hide = true)]
    words: Vec<String>,

    /// Choose beforehand; may be repeated.
    #[arg(short, long = "define", value_name = "CHOICE=VALUE", help_heading = PROJECT)]
    defined: Vec<String>,
    /// Ask nothing: take the defaults for the rest.
    #[arg(long, help_heading = PROJECT)]
    defaults: bool,
    /// Where the project's folder is made [default: .].
    #[arg(long, value_name = "FOLDER", help_heading = PROJECT)]
    into: Option<PathBuf>,
    /// Print what can be chosen.
    #[arg(long, help_heading = PROJECT)]
    choices: bool,

    /// Call the copy NAME [default: as in the library].
    #[arg(long = "as", value_name = "NAME", help_heading = GENERATOR)]
    as_name: Option<String>,
    /// Print the library's generators.
    #[arg(long, help_heading = GENERATOR)]
    list: bool,

    /// Make the program in Python.
    #[arg(long, value_name = "SENSOR", help_heading = EXTERNAL)]
    python: Option<String>,
}

const PROJECT: &str = "A new project, in a folder of its own";
const GENERATOR: &str = "A generator of the library, copied into the project in which you are";

const EXTERNAL: &str = "A program that sends what a sensor of the project's cell reads";

/// Reads the arguments after the program's name.
///
/// # Errors
/// [`Error::Refused`] or [`Error::Usage`], with what to write instead.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Request, Error> {
    let program = OsString::from("mrroc-new");
    match Arguments::try_parse_from(iter::once(program).chain(arguments)) {
        Ok(read) if read.words.first().is_some_and(|word| word == "generator") => read.generator(),
        Ok(read) if read.words.first().is_some_and(|word| word == "external") => read.external(),
        Ok(read) => read.project(),
        Err(answer) if answer.use_stderr() => Err(Error::Usage(answer.to_string())),
        Err(answer) => Ok(Request::Print(answer.to_string())),
    }
}

impl Arguments {
    fn external(self) -> Result<Request, Error> {
        let help = "write `mrroc-new external --python SENSOR` in the project's folder";
        if self.is_of_project() || self.list || self.as_name.is_some() {
            return Err(Error::refused("this option is not for the program of a sensor", help));
        }
        no_more(self.words.get(1))?;
        let refused = || Error::refused("no sensor given", help);
        self.python.map(Request::External).ok_or_else(refused)
    }

    /// Whether it has an option for a new project.
    fn is_of_project(&self) -> bool {
        self.into.is_some() || self.choices || self.defaults || !self.defined.is_empty()
    }

    fn generator(self) -> Result<Request, Error> {
        if self.is_of_project() || self.python.is_some() {
            let help = "write `mrroc-new generator GENERATOR --as NAME` in the project's folder";
            return Err(Error::refused("this option is not for generators", help));
        }
        no_more(self.words.get(2))?;
        match self.words.into_iter().nth(1) {
            _ if self.list => Ok(Request::Generators),
            None => Err(Error::refused("no generator given", "`mrroc-new generator --list` lists them")),
            Some(name) => {
                Ok(Request::Generator { as_name: self.as_name.unwrap_or_else(|| name.clone()), name })
            }
        }
    }

    fn project(self) -> Result<Request, Error> {
        if self.list || self.as_name.is_some() {
            let help = "write `mrroc-new generator --list` or `mrroc-new generator GENERATOR --as NAME`";
            return Err(Error::refused("this option is for generators", help));
        }
        if self.python.is_some() {
            let help = "write `mrroc-new external --python SENSOR`";
            return Err(Error::refused("this option is for the program of a sensor", help));
        }
        no_more(self.words.get(1))?;
        let mut given = Given::new();
        self.defined.iter().try_for_each(|definition| define(&mut given, definition))?;
        if self.choices {
            return Ok(Request::Choices);
        }
        let name = self.words.into_iter().next().ok_or_else(|| {
            let help = "write `cargo run -p mrroc-new -- my-task`; see also `--help`";
            Error::refused("the project has no name", help)
        })?;
        let into = self.into.unwrap_or_else(|| ".".into());
        let rest = if self.defaults { Rest::Default } else { Rest::Asked };
        Ok(Request::Project(Project { name, into, given, rest }))
    }
}

fn no_more(word: Option<&String>) -> Result<(), Error> {
    match word {
        None => Ok(()),
        Some(word) => Err(Error::refused(
            format!("`{word}` is one name too many"),
            "a name has no blanks; see `--help`",
        )),
    }
}

fn define(given: &mut Given, definition: &str) -> Result<(), Error> {
    let Some((name, value)) = definition.split_once('=') else {
        let what = format!("`{definition}` chooses nothing");
        return Err(Error::refused(what, "write `--define name=value`; `--choices` lists them"));
    };
    match given.insert(name.to_owned(), value.to_owned()) {
        Some(first) if first != value => {
            let what = format!("{name} is chosen twice: `{first}` and `{value}`");
            Err(Error::refused(what, "choose one of them"))
        }
        Some(_) | None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn run(line: &str) -> Result<Request, String> {
        parse(line.split_whitespace().map(OsString::from)).map_err(|error| error.to_string())
    }

    #[test]
    fn all_options_are_read() {
        let Ok(Request::Project(found)) = run("a -d x=1=2 --define=y= --into b --defaults") else { panic!() };
        assert_eq!((found.name.as_str(), found.into, found.rest), ("a", "b".into(), Rest::Default));
        assert_eq!(
            found.given.into_iter().collect::<Vec<_>>(),
            [("x".to_owned(), "1=2".to_owned()), ("y".to_owned(), String::new())]
        );
        let copy = |name: &str, as_name: &str| {
            Ok(Request::Generator { name: name.to_owned(), as_name: as_name.to_owned() })
        };
        assert_eq!(run("generator straight_line"), copy("straight_line", "straight_line"));
        assert_eq!(run("generator straight_line --as my_line"), copy("straight_line", "my_line"));
        assert_eq!(run("generator --list"), Ok(Request::Generators));
        assert_eq!(run("external --python camera"), Ok(Request::External("camera".to_owned())));
        assert_eq!(run("--choices"), Ok(Request::Choices));
        let Ok(Request::Print(help)) = run("a -h") else { panic!() };
        assert!(help.contains("--define <CHOICE=VALUE>"), "{help}");
        assert_eq!(
            run("-V"),
            Ok(Request::Print(concat!("mrroc-new ", env!("CARGO_PKG_VERSION"), "\n").to_owned()))
        );
    }

    #[test]
    fn wrong_options_say_what_to_write() {
        for (line, part) in [
            ("", "cargo run -p mrroc-new -- my-task"),
            ("--defalts a", "a similar argument exists: '--defaults'"),
            ("--zzz", "For more information, try '--help'"),
            ("-x", "For more information, try '--help'"),
            ("a b", "one name too many"),
            ("a generator", "one name too many"),
            ("a --define", "a value is required for '--define <CHOICE=VALUE>'"),
            ("a --define x", "`x` chooses nothing"),
            ("a --define x", "--define name=value"),
            ("a -d x=1 -d x=2", "x is chosen twice: `1` and `2`"),
            ("a --as b", "for generators"),
            ("a --list", "for generators"),
            ("generator", "no generator given"),
            ("generator a b", "one name too many"),
            ("generator a --into b", "not for generators"),
            ("--into b generator a", "not for generators"),
            ("a --python b", "for the program of a sensor"),
            ("external", "no sensor given"),
            ("external a --python b", "one name too many"),
            ("external --python b --list", "not for the program of a sensor"),
        ] {
            let message = run(line).expect_err(line);
            assert!(message.contains(part), "{line}: {message}");
        }
    }

    #[test]
    fn the_help_fits_a_terminal() {
        Arguments::command().debug_assert();
        let Ok(Request::Print(help)) = run("generator --help") else { panic!() };
        assert!(help.lines().all(|line| line.len() <= 80), "{help}");
    }
}
