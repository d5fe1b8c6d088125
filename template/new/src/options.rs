//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use lexopt::prelude::*;

use crate::choices::Given;
use crate::error::Error;
use crate::suggestion;

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
    /// The list of generators, to be printed.
    Generators,
    /// The list of choices, to be printed.
    Choices,
    /// The help, to be printed.
    Help,
    /// The version, to be printed.
    Version,
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

/// The text of `--help`.
pub const HELP: &str = "\
Makes a new mrroc project, and copies generators of the library into it.

Usage: mrroc-new [OPTIONS] NAME
       mrroc-new generator GENERATOR [--as NAME]
       mrroc-new generator --list

A new project in a folder of its own, NAME:
  -d, --define CHOICE=VALUE  choose beforehand; may be repeated
      --defaults             ask nothing: take the defaults for the rest
      --into FOLDER          where the project's folder is made [default: .]
      --choices              print what can be chosen
  What is left open is asked for when there is a terminal, and otherwise
  taken by default.

A generator of the library, copied into the project in which you are, to be
changed there:
      --as NAME              call the copy NAME [default: as in the library]
      --list                 print the library's generators

  -h, --help                 print this text
  -V, --version              print the version

Exit status: 0 if it was made, 2 if what was asked for was refused, and 1 if
it failed; then nothing was written.
";

const NAMES: &[&str] = &["define", "defaults", "into", "choices", "as", "list", "help", "version"];

/// Reads the arguments after the program's name.
///
/// # Errors
/// [`Error::Refused`] with what to write instead.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Request, Error> {
    let mut parser = lexopt::Parser::from_args(arguments);
    let mut words: Vec<String> = Vec::new();
    let (mut into, mut as_name, mut given) = (None, None, Given::new());
    let (mut rest, mut choices, mut list) = (Rest::Asked, false, false);
    while let Some(argument) = parser.next().map_err(|error| refused(error.to_string(), "see `--help`"))? {
        let name = match argument {
            Short('h') => "help".to_owned(),
            Short('V') => "version".to_owned(),
            Short('d') => "define".to_owned(),
            Short(other) => return Err(refused(format!("no option -{other}"), "`--help` lists them all")),
            Long(name) => name.to_owned(),
            Value(word) => {
                words.push(text(word)?);
                continue;
            }
        };
        match name.as_str() {
            "help" => return Ok(Request::Help),
            "version" => return Ok(Request::Version),
            "choices" => choices = true,
            "defaults" => rest = Rest::Default,
            "list" => list = true,
            "into" => into = Some(PathBuf::from(value(&mut parser, "--into")?)),
            "as" => as_name = Some(text(value(&mut parser, "--as")?)?),
            "define" => define(&mut given, &text(value(&mut parser, "--define")?)?)?,
            other => {
                let help = match suggestion::nearest(other, NAMES.iter().copied()) {
                    Some(name) => format!("did you mean `--{name}`?"),
                    None => "`--help` lists them all".to_owned(),
                };
                return Err(refused(format!("no option --{other}"), help));
            }
        }
    }
    let mut words = words.into_iter();
    let first = words.next();
    if first.as_deref() == Some("generator") {
        if into.is_some() || choices || !given.is_empty() || rest == Rest::Default {
            let help = "write `mrroc-new generator GENERATOR --as NAME` in the project's folder";
            return Err(refused("this option is for a new project", help));
        }
        let name = words.next();
        no_more(words)?;
        return match name {
            _ if list => Ok(Request::Generators),
            None => Err(refused("no generator given", "`mrroc-new generator --list` lists them")),
            Some(name) => Ok(Request::Generator { as_name: as_name.unwrap_or_else(|| name.clone()), name }),
        };
    }
    if list || as_name.is_some() {
        let help = "write `mrroc-new generator --list` or `mrroc-new generator GENERATOR --as NAME`";
        return Err(refused("this option is for generators", help));
    }
    no_more(words)?;
    if choices {
        return Ok(Request::Choices);
    }
    let name = first.ok_or_else(|| {
        refused("the project has no name", "write `cargo run -p mrroc-new -- my-task`; see also `--help`")
    })?;
    Ok(Request::Project(Project { name, into: into.unwrap_or_else(|| ".".into()), given, rest }))
}

fn define(given: &mut Given, definition: &str) -> Result<(), Error> {
    let Some((name, value)) = definition.split_once('=') else {
        let what = format!("`{definition}` chooses nothing");
        return Err(refused(what, "write `--define name=value`; `--choices` lists them"));
    };
    match given.insert(name.to_owned(), value.to_owned()) {
        Some(first) if first != value => {
            let what = format!("{name} is chosen twice: `{first}` and `{value}`");
            Err(refused(what, "choose one of them"))
        }
        Some(_) | None => Ok(()),
    }
}

fn value(parser: &mut lexopt::Parser, name: &str) -> Result<OsString, Error> {
    parser.value().map_err(|_| refused(format!("{name} without a value"), "see `--help`"))
}

fn text(word: OsString) -> Result<String, Error> {
    word.into_string()
        .map_err(|word| refused(format!("{} is no valid text", word.display()), "write it in UTF-8"))
}

fn no_more(mut words: impl Iterator<Item = String>) -> Result<(), Error> {
    match words.next() {
        None => Ok(()),
        Some(word) => {
            Err(refused(format!("`{word}` is one name too many"), "a name has no blanks; see `--help`"))
        }
    }
}

fn refused(what: impl Into<String>, help: impl Into<String>) -> Error {
    Error::refused(what, help)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(run("--choices"), Ok(Request::Choices));
        assert_eq!(run("a -h"), Ok(Request::Help));
        assert_eq!(run("-V"), Ok(Request::Version));
    }

    #[test]
    fn wrong_options_say_what_to_write() {
        for (line, part) in [
            ("", "cargo run -p mrroc-new -- my-task"),
            ("--defalts a", "did you mean `--defaults`?"),
            ("--zzz", "`--help` lists them all"),
            ("-x", "`--help` lists them all"),
            ("a b", "one name too many"),
            ("a --define", "--define without a value"),
            ("a --define x", "--define name=value"),
            ("a -d x=1 -d x=2", "x is chosen twice: `1` and `2`"),
            ("a --as b", "for generators"),
            ("generator", "no generator given"),
            ("generator a b", "one name too many"),
            ("generator a --into b", "for a new project"),
        ] {
            let message = run(line).expect_err(line);
            assert!(message.contains(part), "{line}: {message}");
        }
    }

    #[test]
    fn the_help_names_every_option() {
        assert!(NAMES.iter().all(|name| HELP.contains(&format!("--{name}"))));
        assert!(HELP.lines().all(|line| line.len() <= 80));
    }
}
