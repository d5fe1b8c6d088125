//! The options of a task program.
//!
//! In: the command line. Out: the options, or what to print instead: the help, or what is wrong with the command line.

use std::ffi::{OsStr, OsString};
use std::iter;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches, Parser, Subcommand};

use crate::own;
use crate::telling::PartRequest;
use mrroc_core::fault::Name;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::operator::button::{Button, ButtonKind};
use mrroc_core::operator::jog::JogOrder;
use mrroc_core::operator::{NoRequest, Request};

const AFTER_HELP: &str = "\
From status on, the commands ask the same cell from another terminal, while it
runs by --processes. Everybody may stop and abort; the rest is for one console
at a time.

Exit status: 0 if the programs ended well, 1 after a fault, 2 if the cell or
the command line was refused; then nothing has moved. From another terminal: 0
if it was done, 1 if it was refused, 2 if no such cell runs, 3 if it will be
done when the program, which computes, moves or waits again.

What stands behind -- is the program's own: its page says what it knows.

Examples:
  cargo run                             run the cell, draw picture.svg
  cargo run -- --dry-run                how near does it come to the limits?
  cargo run --release -- --processes    in real time
  cargo run --release -- speed 50%      the same cell, from another terminal";

/// What the command line asks for.
#[derive(Clone, Debug, Parser)]
#[command(
    about = "Runs the cell of cell.toml with simulated robots and draws what moved",
    after_help = AFTER_HELP,
    args_override_self = true,
    disable_help_subcommand = true,
    max_term_width = 80
)]
pub(super) struct Options {
    /// The cell [default: the project's cell.toml].
    #[arg(long, value_name = "FILE", global = true)]
    pub(super) cell: Option<PathBuf>,
    /// The picture.
    #[arg(long, value_name = "FILE", default_value = "picture.svg", overrides_with = "no_picture")]
    picture: PathBuf,
    /// Draw nothing.
    #[arg(long, overrides_with = "picture")]
    no_picture: bool,
    /// Put the cell together and print it as a table, but run nothing.
    #[arg(long)]
    pub(super) check: bool,
    /// Run the whole program under the virtual clock and say how near it comes to the limits; with --processes, start
    /// them only if it keeps them.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// With --processes: begin at reduced speed. Robots move only while a key is held (`hold`, in another terminal), and no
    /// tool faster than 250 mm/s.
    #[arg(long, help_heading = "Processes")]
    pub(super) reduced: bool,
    /// Write how the run ended, and how punctual each process was, to a JSON file.
    #[arg(long, value_name = "FILE")]
    pub(super) outcome: Option<PathBuf>,
    /// Show the cell in a browser, and operate it there; without --processes, show the run when it is over (feature `panel`).
    #[arg(long)]
    pub(super) panel: bool,
    /// Let simulated drives stand in for real ones, as in a dry run.
    #[arg(long)]
    pub(super) simulated: bool,
    #[command(flatten)]
    pub(super) recording: RecordingOption,
    /// The lower cell that is asked, by its name: press, line.press.
    #[arg(long, value_name = "CELL", global = true, value_parser = lower_cell, help_heading = "Processes")]
    pub(super) of: Option<Name>,
    /// Print errors only.
    #[arg(short, long, global = true)]
    pub(super) quiet: bool,
    /// Run every process of the cell as one of the operating system, in real time (feature `processes`, Linux); draws what
    /// is simulated.
    #[arg(long, help_heading = "Processes")]
    processes: bool,
    /// The same in lock-step under the virtual clock.
    #[arg(long = "virtual", help_heading = "Processes")]
    lock_step: bool,
    /// With --processes: time that a process looks for messages before it sleeps, in microseconds; for machines with more
    /// cores than the cell has processes.
    #[arg(long, value_name = "US", default_value = "0", value_parser = nanoseconds, help_heading = "Processes")]
    pub(super) spin: u64,
    #[command(subcommand)]
    pub(super) word: Option<LaunchCommand>,
    /// Which process of a cell this one is, and in which session, as its launcher started it.
    #[arg(skip)]
    pub(super) part: Option<(ProcessId, PathBuf)>,
}

/// Where a run is recorded.
#[derive(Clone, Debug, Args)]
pub(super) struct RecordingOption {
    /// Record every step to an MCAP file (feature `recording`).
    #[arg(long = "record", value_name = "FILE", help_heading = "Recording")]
    pub(super) file: Option<PathBuf>,
    /// Draw the images of sensors as PNG files, in an empty folder (feature `recording`).
    #[arg(long, value_name = "FOLDER", help_heading = "Recording")]
    pub(super) frames: Option<PathBuf>,
}

/// What is asked for instead of a run.
#[derive(Clone, Debug, Subcommand)]
pub(super) enum LaunchCommand {
    /// Run the programs again on what a recording says of robots, sensors and operator, and compare the demands;
    /// identical: exit status 0, different: 1.
    Replay {
        /// The recording.
        file: PathBuf,
        /// Replay a recording that was cut off as far as it goes.
        #[arg(long)]
        partial: bool,
    },
    /// Say what this machine can do for --processes, and the network between the machines of the cell; takes 10 s.
    Doctor,
    /// Print the calibration of a robot, as its controller tells it, for the file that cell.toml names.
    Calibration {
        /// The robot.
        robot: String,
    },
    /// Print a robot as a URDF, with what that cannot say of it in a comment.
    ExportUrdf {
        /// The robot.
        robot: String,
    },
    /// Print the Python module by which a program of another sends what a sensor reads, or simulates a robot.
    External {
        /// The sensor, or the robot.
        name: String,
    },
    /// Have the processes of a machine of the cell, which is started on another one; until it is ended.
    Node {
        /// The node.
        name: String,
    },
    /// Make certificates for the machines of the cell, and for programs elsewhere that send what its sensors read.
    Certificates {
        /// A new folder.
        folder: String,
    },
    /// Run the gateway of a sensor whose program is on another machine: its process starts this.
    #[command(hide = true)]
    Gateway {
        /// The sensor.
        name: String,
    },
    /// Show the cell, which runs in another terminal, or a recording of it, in a browser (feature `panel`).
    Panel {
        /// The recording.
        recording: Option<PathBuf>,
    },
    #[command(flatten)]
    Operating(OperatingWord),
}

/// What an operator writes to a cell that runs already.
#[derive(Clone, Debug, Subcommand)]
pub(super) enum OperatingWord {
    /// Say what the cell does.
    Status,
    #[command(flatten)]
    Press(ButtonWords),
    /// Let robots move at reduced speed while the space bar is held; or jog one: hold left tool x 20%.
    Hold {
        /// The robot, and how it is jogged.
        #[arg(value_name = "JOG", allow_hyphen_values = true)]
        jog: Vec<String>,
    },
    /// Any of these, line by line; `take` and `release` keep the control from others meanwhile.
    Console,
}

/// The kinds of buttons that somebody writes.
fn written() -> impl Iterator<Item = &'static ButtonKind> {
    ButtonKind::ALL.iter().filter(|kind| !kind.does.is_empty())
}

/// A button, as it is written: `speed 50 %`.
#[derive(Clone, Debug)]
pub(super) struct ButtonWords(String);

impl FromArgMatches for ButtonWords {
    fn from_arg_matches(matches: &ArgMatches) -> Result<ButtonWords, clap::Error> {
        let (word, of_word) =
            matches.subcommand().ok_or_else(|| clap::Error::new(ErrorKind::MissingSubcommand))?;
        let rest = of_word.try_get_many::<String>("rest").ok().flatten().into_iter().flatten();
        let words: Vec<_> = iter::once(word).chain(rest.map(String::as_str)).collect();
        Ok(ButtonWords(words.join(" ")))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        ButtonWords::from_arg_matches(matches).map(|words| *self = words)
    }
}

impl Subcommand for ButtonWords {
    fn augment_subcommands(command: Command) -> Command {
        let one = |kind: &ButtonKind| {
            let command = Command::new(kind.word).about(kind.does);
            let rest = Arg::new("rest").value_name(kind.rest).num_args(1..).action(ArgAction::Append);
            if kind.rest.is_empty() { command } else { command.arg(rest) }
        };
        command.subcommands(written().map(one))
    }

    fn augment_subcommands_for_update(command: Command) -> Command {
        ButtonWords::augment_subcommands(command)
    }

    fn has_subcommand(word: &str) -> bool {
        written().any(|kind| kind.word == word)
    }
}

/// What an operator wants of a cell that runs already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operating {
    /// Something, once.
    Ask(Request),
    /// Any of these, line by line.
    Console,
    /// Hold a key, which jogs a robot if one is named.
    Hold(Option<(Name, JogOrder)>),
}

impl Options {
    /// The file of the picture; `None` if no picture is wanted.
    pub(super) fn picture(&self) -> Option<&Path> {
        (!self.no_picture).then_some(&*self.picture)
    }

    /// Whether simulated drives stand in for real ones in what this process runs: a dry run is on the memory link, whatever
    /// comes after it.
    pub(super) fn simulates(&self) -> bool {
        self.simulated || self.dry_run && self.clock().is_none() && self.part.is_none()
    }

    /// Whether the program of the cell runs in this process, by no word and no other option.
    pub(super) fn is_plain(&self) -> bool {
        self.word.is_none() && self.part.is_none() && !self.dry_run && self.clock().is_none()
    }

    /// By which clock the cell runs as processes of the operating system; `None` if it does not.
    pub(super) fn clock(&self) -> Option<Clock> {
        match (self.processes, self.lock_step) {
            (_, true) => Some(Clock::Virtual),
            (true, false) => Some(Clock::Real),
            (false, false) => None,
        }
    }
}

impl OperatingWord {
    /// What it asks for.
    ///
    /// # Errors
    /// What stands behind a word is nothing that can.
    pub(super) fn read(&self) -> Result<Operating, NoRequest> {
        Ok(match self {
            OperatingWord::Status => Operating::Ask(Request::Status),
            OperatingWord::Press(ButtonWords(words)) => Operating::Ask(Request::read(words)?),
            OperatingWord::Hold { jog } if jog.is_empty() => Operating::Hold(None),
            // Which hold it is, the key that is held says.
            OperatingWord::Hold { jog } => match Request::read(&format!("jog 0 0 {}", jog.join(" ")))? {
                Request::Press(Button::Jog(_, robot, order)) => Operating::Hold(Some((robot, order))),
                request => Operating::Ask(request),
            },
            OperatingWord::Console => Operating::Console,
        })
    }
}

/// Reads the arguments after the program's name.
///
/// # Errors
/// What to print instead of a run: the help, or what is wrong with the arguments.
pub(super) fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Options, clap::Error> {
    let (part, arguments) = split_part(arguments.into_iter().collect());
    if let Some(word) = arguments.first().filter(|word| is_role(&[], word)) {
        let word = word.display();
        let text =
            format!("`{word}` is not asked for\n help: processes are started by the launcher: --processes\n");
        return Err(clap::Error::raw(ErrorKind::InvalidSubcommand, text));
    }
    let program = std::env::args_os().next().unwrap_or_default();
    let arguments = arguments.into_iter().take_while(|argument| !own::is_beginning(argument));
    let options = Options::try_parse_from(iter::once(program).chain(arguments))?;
    Ok(Options { part, ..options })
}

/// For a program's help: the words for a cell that runs already, and the options that are common to all programs.
pub(super) fn help_beside_own() -> String {
    let command = LaunchCommand::augment_subcommands(RecordingOption::augment_args(Command::new("")));
    let command = command.disable_help_flag(true).disable_help_subcommand(true).max_term_width(80);
    command.help_template("{all-args}").render_help().to_string().trim_end().to_owned()
}

/// Whether a word is asked for instead of a run.
pub(super) fn is_word(word: &OsStr) -> bool {
    word.to_str().is_some_and(LaunchCommand::has_subcommand)
}

/// The name of a lower cell.
fn lower_cell(text: &str) -> Result<Name, String> {
    Name::of_process(text).map_err(|error| error.to_string())
}

/// Microseconds, as nanoseconds.
fn nanoseconds(text: &str) -> Result<u64, &'static str> {
    let micros = text.parse::<u32>().map_err(|_| "write a whole number of microseconds: --spin 20")?;
    Ok(1000 * u64::from(micros))
}

/// Whether a word continues the name of a process: `mp`, `ecp NAME`.
fn is_role(role: &[OsString], word: &OsStr) -> bool {
    match role {
        [] => ["mp", "plant", "ecp", "edp", "vsp"].iter().any(|role| word == OsStr::new(role)),
        // `mp press` is that of a lower cell.
        [role] if role == "mp" => !word.as_encoded_bytes().starts_with(b"-"),
        [role] => role != "plant",
        _ => false,
    }
}

/// Splits off the arguments that a launcher gives to a process that it starts: which process it is, and in which
/// session.
pub(super) fn split_part(mut arguments: Vec<OsString>) -> (Option<(ProcessId, PathBuf)>, Vec<OsString>) {
    let words = (0..2).take_while(|&n| arguments.get(n).is_some_and(|word| is_role(&arguments[..n], word)));
    // `node NAME` is a word of users, too, without a session.
    let is_node = arguments.first().is_some_and(|word| word == "node") && arguments.len() > 1;
    let words = if is_node { 2 } else { words.count() };
    let part = match (read_role(&arguments[..words]), arguments.get(words), arguments.get(words + 1)) {
        (Some(process), Some(session), Some(folder)) if session == "--session" => (process, folder.into()),
        _ => return (None, arguments),
    };
    arguments.drain(..words + 2);
    (Some(part), arguments)
}

/// What a command line asks for concerning a recording, apart from the program's own arguments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum AskedRecording {
    /// Record the run to this file.
    Record(PathBuf),
    /// Replay the run of this file.
    Replay(PathBuf),
}

/// Splits off `calibration ROBOT`, `export-urdf ROBOT` or `external NAME` at the beginning.
pub(super) fn split_asked(mut arguments: Vec<OsString>) -> (Option<(PartRequest, String)>, Vec<OsString>) {
    let is_panel = arguments.first().is_some_and(|word| word == "panel");
    let word = arguments.first().filter(|_| arguments.len() > 1 || is_panel).and_then(|word| word.to_str());
    let Some(asked) = word.and_then(PartRequest::of) else { return (None, arguments) };
    // The name of a recording need not follow.
    let is_alone = is_panel && arguments.get(1).is_none_or(|name| name.as_encoded_bytes().starts_with(b"-"));
    if is_alone {
        arguments.remove(0);
        return (Some((asked, String::new())), arguments);
    }
    let name = arguments.drain(..2).next_back();
    (name.map(|name| (asked, name.to_string_lossy().into_owned())), arguments)
}

/// Splits off `--panel`.
pub(super) fn split_panel(mut arguments: Vec<OsString>) -> (bool, Vec<OsString>) {
    let own = arguments.iter().position(|argument| argument == "--").unwrap_or(arguments.len());
    let at = arguments[..own].iter().position(|argument| argument == "--panel");
    if let Some(at) = at {
        arguments.remove(at);
    }
    (at.is_some(), arguments)
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
    let name = || Name::of_process(words.get(1)?.to_str()?).ok();
    let role = match words.first()?.to_str()? {
        // With a name it is that of a lower cell.
        "mp" => return Some(ProcessId { name: name(), ..ProcessId::MP }),
        "plant" => return Some(ProcessId::PLANT),
        "ecp" => Role::Ecp,
        "edp" => Role::Edp,
        "node" => Role::Node,
        _ => Role::Vsp,
    };
    Some(ProcessId::new(role, name()?))
}

/// `cell.toml` in this folder or in the nearest folder above it, up to the project's folder, which has the Cargo.toml.
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

    fn parsed(arguments: &[&str]) -> Result<Options, String> {
        parse(arguments.iter().map(OsString::from)).map_err(|error| error.to_string())
    }

    fn options(arguments: &[&str]) -> Options {
        parsed(arguments).expect("right")
    }

    #[test]
    fn options_say_which_cell_runs_and_where_the_picture_goes() {
        let told = options(&["--cell", "a/b.toml", "--picture=c.svg", "-q"]);
        assert_eq!(told.cell, Some(PathBuf::from("a/b.toml")));
        assert_eq!(told.picture(), Some(Path::new("c.svg")));
        assert!(told.quiet && !told.check);
        let told = options(&["--no-picture", "--check"]);
        assert!(told.picture().is_none() && told.check);
        // The last option counts.
        assert_eq!(options(&["--no-picture", "--picture", "c.svg"]).picture(), Some(Path::new("c.svg")));
        assert_eq!(options(&["--picture", "c.svg", "--no-picture"]).picture(), None);
        assert_eq!(options(&["--cell", "a", "--cell", "b"]).cell, Some(PathBuf::from("b")));
        assert_eq!(options(&[]).picture(), Some(Path::new("picture.svg")));
        let help = parse(["-h".into()]).expect_err("help");
        assert_eq!(help.kind(), ErrorKind::DisplayHelp);
    }

    #[test]
    fn an_option_that_there_is_not_is_refused_with_the_one_that_was_meant() {
        for (arguments, told) in [
            (&["--pictur", "x"][..], "a similar argument exists: '--picture'"),
            (&["--cell"], "a value is required for '--cell <FILE>'"),
            (&["replay"], "<FILE>"),
            (&["run"], "unrecognized subcommand 'run'"),
            (&["sttus"], "a similar subcommand exists: 'status'"),
            (
                &["ecp", "left"],
                "`ecp` is not asked for\n help: processes are started by the launcher: --processes",
            ),
            (&["plant", "left", "--session", "x"], "`plant` is not asked for"),
            (&["ecp", "--session", "x"], "`ecp` is not asked for"),
            (&["--processes", "--spin"], "a value is required for '--spin <US>'"),
            (&["--spin", "1.5"], "write a whole number of microseconds: --spin 20"),
            (&["-x"], "unexpected argument '-x'"),
            (&["status", "--of", "a b"], "`a b` is no name"),
        ] {
            let error = parse(arguments.iter().map(OsString::from)).expect_err("refused");
            assert_eq!(error.exit_code(), 2);
            assert!(error.to_string().contains(told), "{error}");
        }
    }

    #[test]
    fn the_help_fits_a_terminal_and_shows_every_word() {
        let help = parsed(&["--help"]).expect_err("help");
        for text in [help, help_beside_own()] {
            assert!(text.lines().all(|line| line.len() <= 80), "{text}");
            for word in ["replay", "doctor", "status", "console", "--record"]
                .iter()
                .chain(&["hold"])
                .chain(written().map(|kind| &kind.word))
            {
                assert!(
                    text.lines().any(|line| line.trim_start().starts_with(word)),
                    "{word} is not in\n{text}"
                );
            }
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
        let part =
            options(&["edp", "left", "--session", "s", "--cell", "c", "--quiet"]).part.expect("a part");
        assert_eq!((part.0.to_string().as_str(), part.1), ("edp left", PathBuf::from("s")));
        assert_eq!(options(&["mp", "--session", "s"]).part.expect("a part").0, ProcessId::MP);
        assert_eq!(options(&[]).clock(), None);
        assert_eq!(options(&["--processes"]).clock(), Some(Clock::Real));
        for both in [&["--virtual"][..], &["--processes", "--virtual"], &["--virtual", "--processes"]] {
            assert_eq!(options(both).clock(), Some(Clock::Virtual));
        }
        assert_eq!(options(&["--processes", "--spin", "20"]).spin, 20_000);
        assert!(matches!(options(&["doctor"]).word, Some(LaunchCommand::Doctor)));
    }

    #[test]
    fn a_replay_may_take_what_there_is_of_a_recording() {
        for (arguments, taken) in [
            (&["replay", "a.mcap"][..], false),
            (&["--no-picture", "replay", "a.mcap", "--partial", "-q"], true),
        ] {
            let Some(LaunchCommand::Replay { file, partial }) = options(arguments).word else {
                panic!("{arguments:?}")
            };
            assert_eq!((file, partial), (PathBuf::from("a.mcap"), taken));
        }
    }

    #[test]
    fn an_operator_says_in_words_what_a_running_cell_is_to_do() {
        let asked = |arguments: &[&str]| match parsed(arguments)?.word {
            Some(LaunchCommand::Operating(word)) => word.read().map(Some).map_err(|error| error.to_string()),
            _ => Ok(None),
        };
        assert_eq!(asked(&[]), Ok(None));
        assert_eq!(asked(&["status"]), Ok(Some(Operating::Ask(Request::Status))));
        assert_eq!(asked(&["console"]), Ok(Some(Operating::Console)));
        assert_eq!(options(&["console", "--cell", "c"]).cell, Some(PathBuf::from("c")));
        for of in [&["--of", "line.press", "reset"], &["reset", "--of", "line.press"]] {
            assert_eq!(asked(of), Ok(Some(Operating::Ask(Request::Press(Button::Reset)))));
            assert_eq!(options(of).of, Name::of_process("line.press").ok());
        }
        let half = Ok(Some(Operating::Ask(Request::Press(Button::Speed(0.5)))));
        for speed in [
            &["speed", "50%"][..],
            &["speed", "50"],
            &["speed", "50", "%"],
            &["--cell", "c", "speed", "50%", "-q"],
        ] {
            assert_eq!(asked(speed), half, "{speed:?}");
        }
        assert_eq!(asked(&["hold"]), Ok(Some(Operating::Hold(None))));
        let Ok(Some(Operating::Hold(Some((robot, order))))) = asked(&["hold", "left", "tool", "x", "-20%"])
        else {
            panic!("no jog")
        };
        assert_eq!((robot.as_str(), order.to_string().as_str()), ("left", "tool x -20%"));
        assert!(matches!(
            asked(&["jog-done", "left"]),
            Ok(Some(Operating::Ask(Request::Press(Button::JogDone(_)))))
        ));
        assert_eq!(
            asked(&["reduced", "off"]),
            Ok(Some(Operating::Ask(Request::Press(Button::Reduced(false)))))
        );
        for kind in written().filter(|kind| kind.rest.is_empty()) {
            let button = Request::read(kind.word).expect("a button");
            assert_eq!(asked(&[kind.word]), Ok(Some(Operating::Ask(button))));
        }
        // What a held key sends is not for a command line.
        assert!(asked(&["let-go", "1"]).is_err());
        for (arguments, told) in [
            (&["speed", "fast"][..], "write 0% to 100%"),
            (&["speed"], "write 0% to 100%"),
            (&["speed", "--cell", "c"], "write 0% to 100%"),
            (&["reduced", "maybe"], "write reduced on"),
            (&["hold", "left", "up"], "tool x -50%"),
            (&["stop", "now"], "unexpected argument 'now'"),
            (&["stop", "abort"], "unexpected argument 'abort'"),
        ] {
            let error = asked(arguments).expect_err("refused");
            assert!(error.contains(told), "{error}");
        }
    }
}
