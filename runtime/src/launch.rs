//! The command line of a task program: finds `cell.toml`, runs the cell, says how it ended.
//!
//! In: what the program makes of a [`CellFile`], and a [`Recorder`]. Out: a run, a picture of it, and an exit status.

use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use lexopt::prelude::*;

use crate::cell::{Cell, CellError, RunReport};
use crate::cell_file::CellFile;
use crate::console::{complain, refused, say};
use crate::fault::{Fault, ProcessId, Role};
use crate::name::Name;
use crate::operator::Operator;
#[cfg(all(feature = "processes", target_os = "linux"))]
use crate::processes::NoPart;
use crate::suggestion::suggestion;

/// What watches the robots of a run and keeps something of it, such as a picture.
pub trait Recorder {
    /// Begins to watch every robot of the cell.
    fn watch(&mut self, cell: Cell) -> Cell;

    /// Writes what was seen to a file; after a fault, too.
    ///
    /// # Errors
    /// The file cannot be written.
    fn save(&mut self, file: &Path) -> io::Result<()>;
}

const HELP: &str = "\
Runs the cell of cell.toml with simulated robots and draws what moved.

Options:
  --cell FILE      the cell [default: the project's cell.toml]
  --picture FILE   the picture [default: picture.svg]
  --no-picture     draw nothing
  --check          put the cell together, but run nothing
  --processes      run every process of the cell as one of the operating
                   system, in real time (feature `processes`, Linux); draws
                   nothing
  --virtual        the same in lock-step under the virtual clock
  --spin US        with --processes: time that a process looks for messages
                   before it sleeps [default: 0]; for machines with more cores
                   than the cell has processes
  doctor           say what this machine can do for --processes; takes 10 s
  -q, --quiet      print errors only
  -h, --help       print this text

Exit status: 0 if the programs ended well, 1 after a fault, 2 if the cell or
the command line was refused; then nothing has moved.
";

const NAMES: [&str; 9] = [
    "--cell",
    "--picture",
    "--no-picture",
    "--check",
    "--processes",
    "--virtual",
    "--spin",
    "--quiet",
    "--help",
];

/// What the command line asks for.
struct Options {
    cell: Option<PathBuf>,
    picture: Option<PathBuf>,
    check: bool,
    quiet: bool,
    processes: Option<Clock>,
    doctor: bool,
    /// How long a process looks for messages before it sleeps \[ns\].
    spin: u64,
    /// Which process of a cell this one is, and in which session, as its launcher started it.
    part: Option<(ProcessId, PathBuf)>,
}

/// Whose time processes run in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Clock {
    Real,
    Virtual,
}

/// A command line that cannot be followed.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n help: {help}")]
struct BadOption {
    what: String,
    help: String,
}

/// The main function of a task program: runs what `cell` makes of `cell.toml`, under the options of the command line.
///
/// ```no_run
/// # use mrroc::{Cell, CellError, CellFile, Recorder};
/// # fn cell(file: &CellFile) -> Result<Cell, CellError> { file.cell(&mrroc::Kinds::new()) }
/// # fn film() -> impl Recorder { struct R; impl Recorder for R {
/// #     fn watch(&mut self, cell: Cell) -> Cell { cell }
/// #     fn save(&mut self, _: &std::path::Path) -> std::io::Result<()> { Ok(()) }
/// # } R }
/// # #[allow(unused)]
/// fn main() -> std::process::ExitCode {
///     mrroc::launch(cell, film())
/// }
/// ```
pub fn launch(
    cell: impl FnOnce(&CellFile) -> Result<Cell, CellError>,
    mut recorder: impl Recorder,
) -> ExitCode {
    let options = match parse(std::env::args_os().skip(1)) {
        Ok(Some(options)) if options.doctor => return examine(),
        Ok(Some(options)) => options,
        Ok(None) => return say(HELP),
        Err(error) => return refused(&error),
    };
    let path = options.cell.clone().unwrap_or_else(nearest_cell);
    let assembled = CellFile::read(&path).map_err(CellError::from).and_then(|file| cell(&file));
    let checked = assembled.and_then(|mut cell| cell.check().map(|_| cell));
    let mut cell = match checked {
        Ok(cell) => cell,
        Err(error) => return cell_refused(&error),
    };
    if options.check {
        let well = format!("{}: nothing is wrong with the cell\n", path.display());
        return if options.quiet { ExitCode::SUCCESS } else { say(&well) };
    }
    if let Some((process, session)) = &options.part {
        return take_part(cell, *process, session, options.quiet);
    }
    if let Some(clock) = options.processes {
        return match launch_processes(cell, (clock, options.spin), path, options.quiet) {
            Ok(_) if options.quiet => ExitCode::SUCCESS,
            Ok(report) => tell(&report, None),
            Err(status) => status,
        };
    }
    if let Some(picture) = &options.picture {
        // Found out now, not after a long run.
        if let Err(error) = OpenOptions::new().append(true).create(true).open(picture) {
            return refused(&unwritable(picture, &error));
        }
        cell = recorder.watch(cell);
    }
    if !options.quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    let outcome = match cell.run() {
        Ok(report) => Ok(report),
        Err(CellError::Fault(fault)) => Err(fault),
        Err(error) => return cell_refused(&error),
    };
    let drawn = options
        .picture
        .as_ref()
        .map_or(Ok(()), |picture| recorder.save(picture).map_err(|error| unwritable(picture, &error)));
    let ended = match outcome {
        Ok(_) if options.quiet => ExitCode::SUCCESS,
        Ok(report) => tell(&report, options.picture.as_deref().filter(|_| drawn.is_ok())),
        Err(fault) => stopped(&fault),
    };
    match drawn {
        Ok(()) => ended,
        Err(error) => {
            report(&error);
            ExitCode::FAILURE
        }
    }
}

/// Runs one process of a cell for its launcher.
#[cfg(all(feature = "processes", target_os = "linux"))]
fn take_part(mut cell: Cell, process: ProcessId, session: &Path, quiet: bool) -> ExitCode {
    if !quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    match crate::processes::run(cell, process, session) {
        Ok(()) => ExitCode::SUCCESS,
        Err(NoPart::NoLauncher(_)) if session.is_dir() => ExitCode::FAILURE,
        Err(error @ NoPart::NoLauncher(_)) => refused(&error),
        // The launcher says it.
        Err(NoPart::Told(_)) => ExitCode::FAILURE,
    }
}

/// Runs all processes of a cell.
#[cfg(all(feature = "processes", target_os = "linux"))]
fn launch_processes(
    cell: Cell,
    (clock, spin): (Clock, u64),
    path: PathBuf,
    quiet: bool,
) -> Result<RunReport, ExitCode> {
    use crate::link::iceoryx::Clock as LinkClock;
    use crate::processes::{LaunchError, Plan, launch};
    use crate::realtime::Permission;
    let clock = match clock {
        Clock::Real => LinkClock::Real,
        Clock::Virtual => LinkClock::Virtual,
    };
    let permission = cell.realtime().map_or(Permission::BestEffort, |realtime| realtime.permission);
    launch(cell, &Plan { cell: path, clock, spin, permission, quiet }).map_err(|error| match error {
        LaunchError::Cell(CellError::Fault(fault)) => stopped(&fault),
        LaunchError::Cell(error) => cell_refused(&error),
        error => refused(&error),
    })
}

/// Says what this machine can do for processes.
#[cfg(all(feature = "processes", target_os = "linux"))]
fn examine() -> ExitCode {
    say(&crate::processes::examine())
}

#[cfg(not(all(feature = "processes", target_os = "linux")))]
fn examine() -> ExitCode {
    refused(&NO_PROCESSES)
}

#[cfg(not(all(feature = "processes", target_os = "linux")))]
fn take_part(_: Cell, process: ProcessId, _: &Path, _: bool) -> ExitCode {
    refused(&format!("{process}: {NO_PROCESSES}"))
}

#[cfg(not(all(feature = "processes", target_os = "linux")))]
fn launch_processes(_: Cell, _: (Clock, u64), _: PathBuf, _: bool) -> Result<RunReport, ExitCode> {
    Err(refused(&NO_PROCESSES))
}

#[cfg(not(all(feature = "processes", target_os = "linux")))]
const NO_PROCESSES: &str = "this program was built without processes\n help: on Linux, build it with mrroc's feature `processes`: \
                            cargo run --release --features mrroc/processes -- --processes";

/// Says which fault stopped the cell, and what to do about it.
fn stopped(fault: &Fault) -> ExitCode {
    match fault.help() {
        Some(help) => report(&format!("{fault}\n help: {help}")),
        None => report(fault),
    }
    ExitCode::FAILURE
}

/// Says how long a run took, and where its picture is.
fn tell(report: &RunReport, picture: Option<&Path>) -> ExitCode {
    let (seconds, steps) = (report.time.as_secs_f64(), report.steps);
    if steps == 0 {
        note("nothing moved: the program returned before a Move or a Wait");
    }
    let picture = picture.map_or_else(String::new, |picture| format!(": see {}", picture.display()));
    say(&format!("ran {seconds:.3} s in {steps} steps{picture}\n"))
}

fn unwritable(picture: &Path, error: &io::Error) -> String {
    let picture = picture.display();
    format!("{picture}: cannot be written: {error}\n help: give another file by --picture, or --no-picture")
}

fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Option<Options>, BadOption> {
    let bad = |what: String, help: &str| BadOption { what, help: help.to_owned() };
    let mut parser = lexopt::Parser::from_args(arguments);
    let mut options = Options {
        cell: None,
        picture: Some(PathBuf::from("picture.svg")),
        check: false,
        quiet: false,
        processes: None,
        doctor: false,
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
            Value(value) if role.len() < 2 && is_role(&role, &value) => role.push(value),
            Value(value) => {
                let what = format!("`{}` is not asked for", value.to_string_lossy());
                return Err(bad(what, "see --help"));
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

/// Whether a word goes on with what a process is called: `mp`, `ecp NAME`.
fn is_role(role: &[OsString], word: &OsStr) -> bool {
    match role {
        [] => ["mp", "plant", "ecp", "edp", "vsp"].iter().any(|role| word == OsStr::new(role)),
        [role] => role != "mp" && role != "plant",
        _ => false,
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
fn nearest_cell() -> PathBuf {
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

/// Tells of all that is wrong with a cell.
fn cell_refused(error: &CellError) -> ExitCode {
    match error {
        CellError::Several(errors) => errors.iter().for_each(|one| report(one)),
        one => report(one),
    }
    ExitCode::from(2)
}

fn report(error: &dyn Display) {
    complain(&format!("error: {error}"));
}

fn note(text: &str) {
    complain(&format!("note: {text}"));
}

/// Whoever waits for a run that may have no end is told of it, ever more seldom.
struct Patience {
    since: Instant,
    next: Duration,
}

impl Patience {
    fn new() -> Patience {
        Patience { since: Instant::now(), next: Duration::from_secs(10) }
    }

    /// A hook that looks at the wall clock now and then.
    fn notes(mut self) -> impl FnMut(u64, &Operator) {
        move |step, _| {
            if step % 1024 == 0
                && let Some(text) = self.after(self.since.elapsed(), step)
            {
                note(&text);
            }
        }
    }

    /// What is said of a run that is in this step after so much time, if anything.
    fn after(&mut self, elapsed: Duration, step: u64) -> Option<String> {
        if elapsed < self.next {
            return None;
        }
        self.next = elapsed * 2;
        Some(format!(
            "still running after {} s, in step {step}: a motion ends where its step function returns `Step::Done`, a Wait \
             where its condition holds; stop the program by Ctrl-C",
            elapsed.as_secs()
        ))
    }
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
    fn a_run_without_an_end_is_told_of_ever_more_seldom() {
        let mut patience = Patience::new();
        let told: Vec<_> = (0..100)
            .filter(|&second| patience.after(Duration::from_secs(second), second * 500).is_some())
            .collect();
        assert_eq!(told, [10, 20, 40, 80]);
        let text = patience.after(Duration::from_secs(160), 80_000).expect("160 s is twice 80 s");
        assert!(text.contains("160 s, in step 80000") && text.contains("`Step::Done`"), "{text}");
    }
}
