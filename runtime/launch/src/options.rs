//! The options of a task program.
//!
//! In: the command line. Out: what it asks for, or what is wrong with it.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use lexopt::prelude::*;

use mrroc_core::link::Clock;
use mrroc_core::operator::button::{Button, NoButton};
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::fault::Name;
use mrroc_core::suggestion::suggestion;

pub(super) const HELP: &str = "\
Runs the cell of cell.toml with simulated robots and draws what moved.

Options:
  --cell FILE      the cell [default: the project's cell.toml]
  --picture FILE   the picture [default: picture.svg]
  --no-picture     draw nothing
  --check          put the cell together and print it as a table, but run
                   nothing
  --dry-run        run the whole program under the virtual clock and say how
                   near it comes to the limits; with --processes, start them
                   only if it keeps them
  --record FILE    record every step to an MCAP file (feature `recording`)
  replay FILE      run the programs again on what a recording says of robots,
                   sensors and operator, and compare the demands; identical:
                   exit status 0, different: 1
  --partial        replay a recording that was cut off as far as it goes
  --processes      run every process of the cell as one of the operating
                   system, in real time (feature `processes`, Linux); draws
                   what is simulated
  --virtual        the same in lock-step under the virtual clock
  --spin US        with --processes: time that a process looks for messages
                   before it sleeps [default: 0]; for machines with more cores
                   than the cell has processes
  doctor           say what this machine can do for --processes; takes 10 s
  -q, --quiet      print errors only
  -h, --help       print this text

From another terminal, to the same cell while it runs by --processes:
  status           say what it does
  suspend          stop all robots on their paths
  resume           go on
  speed 50%        slow down or speed up on the path, 0% to 100% of the plan
  abort            stop on the path and end the instruction
  stop             stop on the path for good, as after a fault
  acknowledge, reset
                   after a fault: take notice of it, then start again, in a cell
                   whose file says after_fault = \"await reset\"
  console          any of these, line by line; take and release keep the control
                   from others meanwhile
  view             all of it as a screen with keys (feature `view`)
Everybody may stop and abort; the rest is for one console at a time.

Exit status: 0 if the programs ended well, 1 after a fault, 2 if the cell or
the command line was refused; then nothing has moved. From another terminal: 0
if it was done, 1 if it was refused, 2 if no such cell runs, 3 if it will be
done when the program, which computes, moves or waits again.
";

const NAMES: [&str; 12] = [
    "--cell",
    "--picture",
    "--no-picture",
    "--check",
    "--dry-run",
    "--record",
    "--partial",
    "--processes",
    "--virtual",
    "--spin",
    "--quiet",
    "--help",
];

/// What the command line asks for.
#[derive(Clone)]
pub(super) struct Options {
    pub(super) cell: Option<PathBuf>,
    pub(super) picture: Option<PathBuf>,
    pub(super) check: bool,
    pub(super) dry_run: bool,
    pub(super) record: Option<PathBuf>,
    pub(super) replay: Option<PathBuf>,
    pub(super) partial: bool,
    pub(super) quiet: bool,
    pub(super) processes: Option<Clock>,
    pub(super) doctor: bool,
    /// What a cell that runs already is asked.
    pub(super) operating: Option<Operating>,
    /// How long a process looks for messages before it sleeps \[ns\].
    pub(super) spin: u64,
    /// Which process of a cell this one is, and in which session, as its launcher started it.
    pub(super) part: Option<(ProcessId, PathBuf)>,
}

/// What an operator wants of a cell that runs already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operating {
    /// What it does, once.
    Status,
    /// Press a button.
    Press(Button),
    /// Any of these, line by line.
    Console,
    /// All of it as a screen.
    View,
}

/// A command line that cannot be followed.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n help: {help}")]
pub(super) struct BadOption {
    what: String,
    help: String,
}

pub(super) fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Options>, BadOption> {
    let bad = |what: String, help: &str| BadOption { what, help: help.to_owned() };
    let mut parser = lexopt::Parser::from_args(arguments);
    let mut options = Options {
        cell: None,
        picture: Some(PathBuf::from("picture.svg")),
        check: false,
        dry_run: false,
        record: None,
        replay: None,
        partial: false,
        quiet: false,
        processes: None,
        doctor: false,
        operating: None,
        spin: 0,
        part: None,
    };
    let (mut role, mut session) = (Vec::new(), None);
    let next = |parser: &mut lexopt::Parser| {
        parser.value().map(PathBuf::from).map_err(|error| bad(error.to_string(), "give a file"))
    };
    while let Some(argument) = parser.next().map_err(|error| bad(error.to_string(), "see --help"))? {
        match argument {
            Short('h') | Long("help") => return Ok(None),
            Short('q') | Long("quiet") => options.quiet = true,
            Long("check") => options.check = true,
            Long("dry-run") => options.dry_run = true,
            Long("record") => options.record = Some(next(&mut parser)?),
            Long("partial") => options.partial = true,
            Long("processes") => options.processes = options.processes.or(Some(Clock::Real)),
            Long("virtual") => options.processes = Some(Clock::Virtual),
            Long("spin") => {
                let value = parser.value().ok().and_then(|value| value.parse::<u32>().ok());
                let wrong = || bad("--spin is no number of microseconds".to_owned(), "write --spin 20");
                options.spin = 1000 * u64::from(value.ok_or_else(wrong)?);
            }
            Long("session") => session = Some(next(&mut parser)?),
            Long("no-picture") => options.picture = None,
            Long("cell") => options.cell = Some(next(&mut parser)?),
            Long("picture") => options.picture = Some(next(&mut parser)?),
            Long(name) => {
                let help = suggestion(&format!("--{name}"), &NAMES, "the options are");
                return Err(BadOption { what: format!("no option --{name}"), help });
            }
            Short(letter) => return Err(bad(format!("no option -{letter}"), "see --help")),
            Value(value) if value == "doctor" => options.doctor = true,
            Value(value) if value == "replay" => options.replay = Some(next(&mut parser)?),
            Value(word) if options.operating.is_none() && role.is_empty() && operates(&word) => {
                let rest = parser.raw_args().map_err(|error| bad(error.to_string(), "see --help"))?;
                options.operating = Some(read_operating(&word, rest)?);
            }
            Value(value) if role.len() < 2 && is_role(&role, &value) => role.push(value),
            Value(value) => {
                let word = value.to_string_lossy();
                let words: Vec<_> = ["replay", "doctor"].into_iter().chain(words()).collect();
                let help = suggestion(&word, &words, "words are");
                return Err(bad(format!("`{word}` is not asked for"), &help));
            }
        }
    }
    if let Some(process) = read_role(&role) {
        let help = "processes are started by the launcher: --processes";
        let session = session.ok_or_else(|| bad(format!("`{process}` is not asked for"), help))?;
        options.part = Some((process, session));
    }
    Ok(Some(options))
}

/// Whether a word is for a cell that runs already.
pub(super) fn operates(word: &OsStr) -> bool {
    words().any(|known| word == OsStr::new(known))
}

/// All such words.
fn words() -> impl Iterator<Item = &'static str> {
    ["status", "console", "view"].into_iter().chain(Button::WORDS)
}

/// Reads it, with the speed that may come after it: `50%` or `50 %`.
fn read_operating(word: &OsStr, mut rest: lexopt::RawArgs<'_>) -> Result<Operating, BadOption> {
    Ok(match word.to_str().unwrap_or_default() {
        "status" => Operating::Status,
        "console" => Operating::Console,
        "view" => Operating::View,
        word => {
            let mut value = String::new();
            while word == "speed"
                && rest.peek().is_some_and(|next| !next.to_string_lossy().starts_with("--"))
                && !value.ends_with('%')
            {
                value.extend(rest.next().map(|next| next.to_string_lossy().into_owned()));
            }
            let bad = |error: NoButton| BadOption { what: error.what, help: error.help };
            Operating::Press(Button::read(word, &value).map_err(bad)?)
        }
    })
}

/// Whether a word goes on with what a process is called: `mp`, `ecp NAME`.
fn is_role(role: &[OsString], word: &OsStr) -> bool {
    match role {
        [] => ["mp", "plant", "ecp", "edp", "vsp"].iter().any(|role| word == OsStr::new(role)),
        [role] => role != "mp" && role != "plant",
        _ => false,
    }
}

/// Splits off what a launcher tells a process that it starts: who it is, and in which session.
pub(super) fn split_part(mut arguments: Vec<OsString>) -> (Option<(ProcessId, PathBuf)>, Vec<OsString>) {
    let words = (0..2).take_while(|&n| arguments.get(n).is_some_and(|word| is_role(&arguments[..n], word)));
    let words = words.count();
    let part = match (read_role(&arguments[..words]), arguments.get(words), arguments.get(words + 1)) {
        (Some(process), Some(session), Some(folder)) if session == "--session" => (process, folder.into()),
        _ => return (None, arguments),
    };
    arguments.drain(..words + 2);
    (Some(part), arguments)
}

/// What a command line asks for of a recording, whatever the program's own arguments are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum AskedRecording {
    /// The run goes to this file.
    Record(PathBuf),
    /// The run of this file is made again.
    Replay(PathBuf),
}

/// Splits off `replay FILE` at the beginning, or else the first `--record FILE`.
pub(super) fn split_recording(mut arguments: Vec<OsString>) -> (Option<AskedRecording>, Vec<OsString>) {
    if arguments.len() >= 2 && arguments[0] == "replay" {
        let file = arguments.drain(..2).next_back();
        return (file.map(|file| AskedRecording::Replay(file.into())), arguments);
    }
    let at = arguments.iter().position(|argument| argument == "--record" || argument == "--");
    match at.filter(|&at| arguments[at] == "--record" && at + 1 < arguments.len()) {
        Some(at) => {
            let file = arguments.drain(at..at + 2).next_back();
            (file.map(|file| AskedRecording::Record(file.into())), arguments)
        }
        None => (None, arguments),
    }
}

fn read_role(words: &[OsString]) -> Option<ProcessId> {
    let role = match words.first()?.to_str()? {
        "mp" => return Some(ProcessId::MP),
        "plant" => return Some(ProcessId::PLANT),
        "ecp" => Role::Ecp,
        "edp" => Role::Edp,
        _ => Role::Vsp,
    };
    let name = words.get(1)?.to_str()?;
    Some(ProcessId::new(role, Name::new(name).ok()?))
}

/// `cell.toml` in this folder or in the nearest one upwards, no farther than the project, which has the Cargo.toml.
pub(super) fn nearest_cell() -> PathBuf {
    let here = PathBuf::from("cell.toml");
    if here.is_file() {
        return here;
    }
    let Ok(folder) = std::env::current_dir() else { return here };
    let has = |folder: &Path, file: &str| folder.join(file).is_file();
    let ends = |folder: &&Path| has(folder, "cell.toml") || has(folder, "Cargo.toml");
    let found = folder.ancestors().find(ends).filter(|folder| has(folder, "cell.toml"));
    found.map_or(here, |folder| folder.join("cell.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(arguments: &[&str]) -> Result<Option<Options>, String> {
        parse(arguments.iter().map(OsString::from)).map_err(|error| error.to_string())
    }

    #[test]
    fn options_say_which_cell_runs_and_where_the_picture_goes() {
        let options =
            parsed(&["--cell", "a/b.toml", "--picture=c.svg", "-q"]).expect("right").expect("no help");
        assert_eq!(options.cell, Some(PathBuf::from("a/b.toml")));
        assert_eq!(options.picture, Some(PathBuf::from("c.svg")));
        assert!(options.quiet && !options.check);
        let options = parsed(&["--no-picture", "--check"]).expect("right").expect("no help");
        assert!(options.picture.is_none() && options.check);
        assert!(parsed(&["-h"]).expect("right").is_none());
    }

    #[test]
    fn an_option_that_there_is_not_is_refused_with_the_one_that_was_meant() {
        for (arguments, told) in [
            (&["--pictur", "x"][..], "did you mean `--picture`?"),
            (&["--cell"], "give a file"),
            (&["run"], "`run` is not asked for"),
            (&["sttus"], "did you mean `status`?"),
            (&["ecp", "left"], "`ecp left` is not asked for"),
            (&["mp", "left", "--session", "x"], "`left` is not asked for"),
            (&["--processes", "--spin"], "--spin is no number of microseconds"),
            (&["-x"], "no option -x"),
        ] {
            let error = parsed(arguments).err().expect("refused");
            assert!(error.contains(told) && error.contains("\n help: "), "{error}");
        }
    }

    #[test]
    fn what_a_program_is_asked_of_a_recording_is_none_of_its_own_arguments() {
        let split = |arguments: &[&str]| split_recording(arguments.iter().map(OsString::from).collect());
        let own = |arguments: &[&str]| arguments.iter().map(OsString::from).collect::<Vec<_>>();
        let record = Some(AskedRecording::Record("a.mcap".into()));
        assert_eq!(
            split(&["--text", "x", "--record", "a.mcap", "-q"]),
            (record, own(&["--text", "x", "-q"]))
        );
        let replay = Some(AskedRecording::Replay("a.mcap".into()));
        assert_eq!(split(&["replay", "a.mcap", "-q"]), (replay, own(&["-q"])));
        for none in [&["--record"][..], &["replay"], &["--", "--record", "a"], &["-q"]] {
            assert_eq!(split(none), (None, own(none)));
        }
    }

    #[test]
    fn a_launcher_tells_a_process_who_it_is_and_a_user_whose_time_processes_run_in() {
        let options = |arguments: &[&str]| parsed(arguments).expect("right").expect("no help");
        let part =
            options(&["edp", "left", "--session", "s", "--cell", "c", "--quiet"]).part.expect("a part");
        assert_eq!((part.0.to_string().as_str(), part.1), ("edp left", PathBuf::from("s")));
        assert_eq!(options(&["mp", "--session", "s"]).part.expect("a part").0, ProcessId::MP);
        assert_eq!(options(&[]).processes, None);
        assert_eq!(options(&["--processes"]).processes, Some(Clock::Real));
        for both in [&["--virtual"][..], &["--processes", "--virtual"], &["--virtual", "--processes"]] {
            assert_eq!(options(both).processes, Some(Clock::Virtual));
        }
        assert_eq!(options(&["--processes", "--spin", "20"]).spin, 20_000);
        assert!(options(&["doctor"]).doctor && !options(&[]).doctor);
    }

    #[test]
    fn an_operator_says_in_words_what_a_running_cell_is_to_do() {
        let options = |arguments: &[&str]| parsed(arguments).expect("right").expect("no help");
        assert_eq!(options(&[]).operating, None);
        assert_eq!(options(&["status"]).operating, Some(Operating::Status));
        assert_eq!(options(&["view", "--cell", "c"]).operating, Some(Operating::View));
        let half = Some(Operating::Press(Button::Speed(0.5)));
        for speed in [&["speed", "50%"][..], &["speed", "50", "%"], &["--cell", "c", "speed", "50%", "-q"]] {
            assert_eq!(options(speed).operating, half, "{speed:?}");
        }
        assert_eq!(options(&["stop"]).operating, Some(Operating::Press(Button::Stop)));
        for (arguments, told) in [
            (&["speed", "fast"][..], "write 0% to 100%"),
            (&["speed"], "write 0% to 100%"),
            (&["speed", "--cell", "c"], "write 0% to 100%"),
            (&["stop", "now"], "`now` is not asked for"),
            (&["stop", "abort"], "`abort` is not asked for"),
        ] {
            let error = parsed(arguments).err().expect("refused");
            assert!(error.contains(told), "{error}");
        }
    }
}
