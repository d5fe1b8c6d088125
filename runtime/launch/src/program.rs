//! How a task program with a command line of its own runs its cell: on the memory link, or as processes of the
//! operating system.
//!
//! In: the command line, and the cell. Out: the program's own arguments; a run, or the part of the run that belongs to
//! this process.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use super::files::{check_outputs, recorded};
use super::options::{
    AskedRecording, LaunchCommand, help_beside_own, is_word, parse, split_asked, split_panel, split_part,
    split_recording,
};
use super::outcome::answered;
use super::panel;
use super::parts::{Launch, Parts, Ran};
use super::telling::{self, PartRequest};
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::refused;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;
use mrroc_core::observe::NotRecorded;

impl Launch {
    /// Reads the arguments after the program's name. The cell will run on the memory link, unless
    /// [`processes`](Launch::processes) is called or a launcher has started this process.
    #[must_use]
    pub fn new(arguments: impl IntoIterator<Item = OsString>, parts: &'static Parts) -> Launch {
        let (part, arguments) = split_part(arguments.into_iter().collect());
        let (asked, arguments) = split_asked(arguments);
        let (recording, arguments) = split_recording(arguments);
        let (panel, arguments) = split_panel(arguments);
        Launch {
            part,
            arguments,
            recording,
            asked,
            panel,
            clock: None,
            spin: 0,
            cell: None,
            outcome: None,
            quiet: false,
            watching: false,
            parts,
        }
    }

    /// The program's own arguments, without `replay FILE`, `calibration ROBOT`, `export-urdf ROBOT` or `external NAME` at their beginning
    /// and `--record FILE` and `--panel` among them.
    #[must_use]
    pub fn arguments(&self) -> &[OsString] {
        &self.arguments
    }

    /// Makes the cell run as processes of the operating system, by this clock.
    #[must_use]
    pub fn processes(mut self, clock: Clock) -> Launch {
        self.clock = Some(clock);
        self
    }

    /// Sets how long a process polls for messages before it sleeps; zero by default. For machines with more cores than
    /// the cell has processes.
    #[must_use]
    pub fn spin(mut self, time: Duration) -> Launch {
        self.spin = time.as_nanos().try_into().unwrap_or(u64::MAX);
        self
    }

    /// Sets the file of the cell, or another path that identifies it: a cell is run by one launcher at a time. By
    /// default it is the program's own file.
    #[must_use]
    pub fn cell_file(mut self, file: impl Into<PathBuf>) -> Launch {
        self.cell = Some(file.into());
        self
    }

    /// Makes the run print errors only.
    #[must_use]
    pub fn quiet(mut self) -> Launch {
        self.quiet = true;
        self
    }

    /// Says that the program watches simulated robots and keeps something of the run, such as a picture. When the cell
    /// runs as processes, observers ([`Cell::watch`](mrroc_core::cell::Cell::watch),
    /// [`RobotSetup::observe`](mrroc_core::cell::RobotSetup::observe)) are called in the plant, in the same order as on the
    /// memory link; there [`is_here`](Launch::is_here) says that they see everything. When the cell has ended,
    /// [`run`](Launch::run) returns in the plant as on the memory link; in the launcher it returns [`Ran::Part`] with the
    /// plant's status, once the plant has ended. If nothing is simulated, or the plant was lost, the launcher gets the
    /// report. Drives that search for their marks stay in their EDPs and are not observed. The program of a robot shows
    /// data to observers by [`Shown`](mrroc_core::observe::Shown).
    #[must_use]
    pub fn watching(mut self) -> Launch {
        self.watching = true;
        self
    }

    /// Carries out the word with which the arguments begin: a request to a cell that runs already in another terminal,
    /// such as `status` or `stop`, or `doctor`. Returns `None` if they begin with no such word. The cell is that of
    /// [`cell_file`](Launch::cell_file).
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
            LaunchCommand::Doctor => return Some(self.parts.examine()),
            LaunchCommand::Replay { .. }
            | LaunchCommand::Calibration { .. }
            | LaunchCommand::ExportUrdf { .. }
            | LaunchCommand::External { .. }
            | LaunchCommand::Node { .. }
            | LaunchCommand::Certificates { .. }
            | LaunchCommand::Gateway { .. }
            | LaunchCommand::Panel { .. } => {
                return None;
            }
            LaunchCommand::Operating(word) => match word.read() {
                Ok(operating) => operating,
                Err(error) => return Some(refused(&error)),
            },
        };
        let file = options.cell.or_else(|| self.cell.clone()).map_or_else(std::env::current_exe, Ok);
        Some(
            file.map_or_else(
                |error| refused(&error),
                |file| self.parts.operate(&file, options.of, operating),
            ),
        )
    }

    /// The sections of the help on the words that [`operate`](Launch::operate) carries out, on `replay FILE` and on
    /// `--record FILE`: a program with a command line of its own prints them below its options.
    #[must_use]
    pub fn help() -> String {
        help_beside_own()
    }

    /// Prints the answer that `clap` gives instead of a program's options, and returns the exit status: 0 after the
    /// help or the version, 2 after an error in the command line.
    #[must_use = "the exit status tells that nothing has moved"]
    pub fn answer(answer: &clap::Error) -> ExitCode {
        answered(answer)
    }

    /// Whether observers in this process see everything: either the whole cell runs in this process and nothing besides
    /// the program's own work is asked for, or this is the plant of a program that is [`watching`](Launch::watching).
    #[must_use]
    pub fn is_here(&self) -> bool {
        let only_runs = self.recording.is_none() && self.asked.is_none() && !self.panel;
        self.is_watched_plant() || self.part.is_none() && self.clock.is_none() && only_runs
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
    /// [`CellError`]: what is wrong with the set-up, or why the cell cannot run as processes, before any robot moves; or the
    /// first cause of a stop.
    pub fn run(self, cell: Cell) -> Result<Ran, CellError> {
        let mut cell = self.parts.equip(cell);
        if let Some((PartRequest::Node, name)) = self.asked.clone() {
            return Ok(Ran::Part(self.parts.node(cell, &name, self)));
        }
        if let Some((PartRequest::Panel, recording)) = &self.asked {
            cell.check()?;
            let recording = Some(Path::new(recording)).filter(|file| !file.as_os_str().is_empty());
            let file = self.cell.clone().map_or_else(std::env::current_exe, Ok);
            let shown =
                file.map_or_else(|error| refused(&error), |file| self.parts.show(&cell, &file, recording));
            return Ok(Ran::Part(shown));
        }
        if let Some((asked, robot)) = &self.asked {
            cell.check()?;
            return Ok(Ran::Part(telling::tell(
                &mut cell,
                self.cell.as_deref().unwrap_or(Path::new("")),
                robot,
                *asked,
            )));
        }
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
        check_outputs(recorded(&cell)).map_err(|error| NotRecorded::Overwrites(error.to_string()))?;
        if self.panel
            && let Err(status) = panel::check(self.parts, self.clock, false)
        {
            return Ok(Ran::Part(status));
        }
        match self.clock {
            None => {
                let (panel, cell) = panel::observe_run(self.parts.panel.filter(|_| self.panel), cell);
                let ran = cell.run().map(Ran::Here);
                panel.map_or(ran, |panel| Ok(Ran::Part(panel.show())))
            }
            Some(_) => {
                let own = self.arguments.iter().cloned();
                let asked = [OsString::from("panel"), OsString::new()].into_iter().chain(own);
                let _panel = self.panel.then(|| panel::begin(asked.collect::<Vec<_>>()));
                self.parts.launch(cell, self)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn launch(arguments: &[&str]) -> Launch {
        Launch::new(
            arguments.iter().map(OsString::from),
            &Parts { recorder: None, replay: None, processes: None, panel: None },
        )
    }

    #[test]
    fn what_a_robot_is_asked_for_is_told_from_the_programs_own_arguments() {
        let of = |asked| Some((asked, "arm".to_owned()));
        assert_eq!(launch(&["calibration", "arm", "-x"]).asked, of(PartRequest::Calibration));
        let urdf = launch(&["export-urdf", "arm", "-x"]);
        assert_eq!(urdf.asked, of(PartRequest::Urdf));
        assert!(urdf.arguments() == ["-x"] && !urdf.is_here());
        assert_eq!(launch(&["external", "eye"]).asked, Some((PartRequest::Python, "eye".to_owned())));
        assert_eq!(launch(&["export-urdf"]).asked, None);
        assert_eq!(launch(&["--text", "export-urdf", "arm"]).asked, None);
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
