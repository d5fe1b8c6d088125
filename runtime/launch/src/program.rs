//! How a task program runs its cell: on the memory link, or as processes of the operating system, one of which it may be.
//!
//! In: the command line, what of it is the program's own, and the cell. Out: a run, or one process's part of it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use super::options::{AskedRecording, Word, help_beside_own, is_word, parse, split_part, split_recording};
use super::outcome::answered;
use super::parts::Parts;
use mrroc_core::cell::{Cell, CellError, RunReport};
use mrroc_core::console::refused;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;

/// How a task program with a command line of its own runs its cell; [`launch`](crate) is for all others.
///
/// As processes, the launcher starts the program again for each of them, with the same arguments. So the program reads them
/// and puts its cell together before it asks who it is, and moves and writes nothing until then.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Which process of a cell this one is, and in which session, as its launcher started it.
    pub part: Option<(ProcessId, PathBuf)>,
    /// What the processes are started with.
    pub arguments: Vec<OsString>,
    /// What of a recording the command line asks for.
    pub(super) recording: Option<AskedRecording>,
    pub clock: Option<Clock>,
    /// How long a process looks for messages before it sleeps \[ns\].
    pub spin: u64,
    pub cell: Option<PathBuf>,
    pub quiet: bool,
    /// Whether the program watches robots and keeps something of the run.
    pub watching: bool,
    /// What the program was built with.
    pub(super) parts: &'static Parts,
}

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum Ran {
    /// It ran on the memory link, in this process; or as processes, and this is the one that has seen the robots
    /// ([`Launch::watching`]).
    Here(RunReport),
    /// It ran as processes, and this is their launcher.
    Processes(RunReport),
    /// This was one of the processes, or a replay; it is over, and ends with this status. What there is to say has been said,
    /// or another process says it.
    Part(ExitCode),
}

impl Launch {
    /// From the arguments after the program's name. On the memory link, unless told otherwise or started by a launcher.
    #[must_use]
    pub fn new(arguments: impl IntoIterator<Item = OsString>, parts: &'static Parts) -> Launch {
        let (part, arguments) = split_part(arguments.into_iter().collect());
        let (recording, arguments) = split_recording(arguments);
        Launch {
            part,
            arguments,
            recording,
            clock: None,
            spin: 0,
            cell: None,
            quiet: false,
            watching: false,
            parts,
        }
    }

    /// The arguments that are the program's own: without `replay FILE` before them, and `--record FILE` among them.
    #[must_use]
    pub fn arguments(&self) -> &[OsString] {
        &self.arguments
    }

    /// Runs the cell as processes of the operating system, in this time.
    #[must_use]
    pub fn processes(mut self, clock: Clock) -> Launch {
        self.clock = Some(clock);
        self
    }

    /// For how long a process looks for messages before it sleeps, no time unless it is said: for machines with more cores
    /// than the cell has processes.
    #[must_use]
    pub fn spin(mut self, time: Duration) -> Launch {
        self.spin = time.as_nanos().try_into().unwrap_or(u64::MAX);
        self
    }

    /// The file of the cell, or whatever else tells it from others: it is run by one launcher at a time. The program's own
    /// file unless it is said.
    #[must_use]
    pub fn cell_file(mut self, file: impl Into<PathBuf>) -> Launch {
        self.cell = Some(file.into());
        self
    }

    /// Says nothing but errors.
    #[must_use]
    pub fn quiet(mut self) -> Launch {
        self.quiet = true;
        self
    }

    /// The program watches simulated robots and keeps something of the run, such as a picture. As processes, the plant has
    /// what observers see ([`Cell::watch`](mrroc_core::Cell::watch), [`RobotSetup::observe`](mrroc_core::RobotSetup::observe)): there
    /// they are called, in the order of the memory link, and there [`is_here`](Launch::is_here) says that they see
    /// everything. When the cell has ended, [`run`](Launch::run) returns in the plant as on the memory link, and in the
    /// launcher, once the plant has ended, [`Ran::Part`] with its status. Where nothing is simulated, or the plant was lost,
    /// the launcher gets the report. Drives that search for their marks stay in their EDPs and are not seen; what the program
    /// of a robot would show to observers goes by [`Shown`](mrroc_core::Shown).
    #[must_use]
    pub fn watching(mut self) -> Launch {
        self.watching = true;
        self
    }

    /// Does what the arguments ask of a cell that runs already in another terminal, such as `status` or `stop`, or of the
    /// machine, `doctor`; `None`: they begin with no such word. The cell is the one of [`cell_file`](Launch::cell_file).
    #[must_use]
    pub fn operate(&self) -> Option<ExitCode> {
        if self.is_part() || !self.arguments.first().is_some_and(|first| is_word(first)) {
            return None;
        }
        let options = match parse(self.arguments.iter().cloned()) {
            Ok(options) => options,
            Err(answer) => return Some(answered(&answer)),
        };
        let operating = match options.word? {
            Word::Doctor => return Some(self.parts.examine()),
            Word::Replay { .. } => return None,
            Word::Operating(word) => match word.read() {
                Ok(operating) => operating,
                Err(error) => return Some(refused(&error)),
            },
        };
        let file = options.cell.or_else(|| self.cell.clone()).map_or_else(std::env::current_exe, Ok);
        Some(file.map_or_else(|error| refused(&error), |file| self.parts.operate(&file, operating)))
    }

    /// What the help of a program with a command line of its own says of the words that [`operate`](Launch::operate) carries
    /// out, of `replay FILE` and of `--record FILE`: sections to be put below its options.
    #[must_use]
    pub fn help() -> String {
        help_beside_own()
    }

    /// Prints what `clap` has to say instead of a program's own options: the help or version that was asked for, exit status
    /// 0, or what is wrong with the command line, exit status 2.
    #[must_use = "the exit status tells that nothing has moved"]
    pub fn answer(answer: &clap::Error) -> ExitCode {
        answered(answer)
    }

    /// Whether what watches the robots from here sees everything: the cell runs in this process, all of it, and nothing else
    /// than the program's own work is asked for, or this is the plant of a program that is [`watching`](Launch::watching).
    #[must_use]
    pub fn is_here(&self) -> bool {
        self.is_watched_plant() || self.part.is_none() && self.clock.is_none() && self.recording.is_none()
    }

    /// Whether this is the plant of a program that watches.
    pub fn is_watched_plant(&self) -> bool {
        self.watching && matches!(self.part, Some((ProcessId::PLANT, _)))
    }

    /// Whether this is a process that a launcher has started.
    #[must_use]
    pub const fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// Runs the cell, or this process's part of it.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up, or why processes cannot run it, before anything moves; or the first
    /// cause of a stop.
    pub fn run(self, cell: Cell) -> Result<Ran, CellError> {
        let mut cell = self.parts.equip(cell);
        if let Some((process, session)) = &self.part {
            cell.check()?;
            return self.parts.take_part(cell, *process, session, &self);
        }
        match &self.recording {
            Some(AskedRecording::Replay(file)) => {
                cell.check()?;
                return Ok(Ran::Part(self.parts.replay(cell, file, false, self.quiet)));
            }
            Some(AskedRecording::Record(file)) => cell = cell.record_to(file),
            None => {}
        }
        match self.clock {
            None => cell.run().map(Ran::Here),
            Some(_) => self.parts.launch(cell, self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launch(arguments: &[&str]) -> Launch {
        Launch::new(
            arguments.iter().map(OsString::from),
            &Parts { recorder: None, replay: None, processes: None },
        )
    }

    #[test]
    fn who_is_started_by_a_launcher_is_told_from_the_programs_own_arguments() {
        let own = launch(&["--text", "mp", "edp", "a"]);
        assert!(own.is_here() && own.arguments().len() == 4);
        for (role, words) in [("mp", &["mp"][..]), ("edp a", &["edp", "a"]), ("plant", &["plant"])] {
            let started: Vec<_> = words.iter().chain(&["--session", "s", "--text", "x"]).copied().collect();
            let launch = launch(&started);
            let (process, session) = launch.part.clone().expect("a part");
            assert_eq!((process.to_string().as_str(), session), (role, PathBuf::from("s")));
            assert_eq!(launch.arguments(), ["--text", "x"]);
        }
        assert!(own.operate().is_none(), "a drawing is no word for a cell that runs");
        for other in [&["mp", "--text", "x"][..], &["edp", "--session", "s"], &["edp", "a", "--session"], &[]]
        {
            assert!(launch(other).is_here(), "{other:?}");
        }
    }
}
