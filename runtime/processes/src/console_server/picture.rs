//! A picture of a running cell: what its operator is shown, and how that is written.
//!
//! In: the panels of its processes, or lines of text. Out: the other of the two. A picture is written as lines of words
//! apart by spaces, from `picture` to `end`; each begins with what it is about, and those about a process or a robot come as
//! often as there are such.

use core::fmt::{self, Write};
use core::str::{FromStr, SplitAsciiWhitespace};

use crate::figures::{FIGURES_WORDS, Figures};
use mrroc_core::link::memory::MAX_PROCESSES;
use mrroc_core::operator::button::CellState;
use mrroc_core::operator::state::Doing;
use mrroc_core::robot::MAX_JOINTS;

/// A line that is no part of a picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no part of a picture")]
pub struct BadPicture(String);

/// What a cell looks like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub state: CellState,
    /// The step of the MP, and its period \[ns\].
    pub step: u64,
    pub period: u64,
    /// Rate of path time, and the speed that is set, 0 to 1.
    pub rate: f64,
    pub speed: f64,
    /// Instructions begun; what the present one is, by which generator or condition.
    pub instructions: u64,
    pub doing: Doing,
    pub by: String,
    /// Which process holds the control token.
    pub holder: Option<u32>,
    /// What ended the last instruction that did not end well.
    pub fault: Option<String>,
    pub processes: Vec<ProcessPicture>,
    pub robots: Vec<RobotPicture>,
}

/// One process.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessPicture {
    /// `ecp left`.
    pub name: String,
    pub pid: u32,
    /// Whether it is there.
    pub runs: bool,
    /// How late it was, and how long it worked.
    pub figures: Figures,
}

/// One robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPicture {
    pub name: String,
    /// Time of the servo period \[s\].
    pub time: f64,
    /// Joint positions [rad or m].
    pub demanded: Vec<f64>,
    pub measured: Vec<f64>,
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "picture")?;
        writeln!(f, "cell {} {} {}", self.state.word(), self.step, self.period)?;
        writeln!(f, "feed {} {}", self.rate, self.speed)?;
        writeln!(f, "instruction {} {} {}", self.instructions, self.doing.word(), self.by)?;
        if let Some(holder) = self.holder {
            writeln!(f, "token {holder}")?;
        }
        if let Some(fault) = &self.fault {
            writeln!(f, "fault {}", one_line(fault))?;
        }
        for process in &self.processes {
            let state = if process.runs { "runs" } else { "ended" };
            write!(f, "process {} {state}", process.pid)?;
            let mut figures = [0; FIGURES_WORDS];
            process.figures.put(&mut figures);
            figures.iter().try_for_each(|figure| write!(f, " {figure}"))?;
            writeln!(f, " {}", process.name)?;
        }
        for robot in &self.robots {
            write!(f, "robot {} {} {}", robot.name, robot.time, robot.demanded.len())?;
            robot.demanded.iter().chain(&robot.measured).try_for_each(|q| write!(f, " {q}"))?;
            f.write_char('\n')?;
        }
        writeln!(f, "end")
    }
}

/// A program's text of a fault may have several.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Picture {
    /// Takes one line of a picture between its first and its last.
    ///
    /// # Errors
    /// [`BadPicture`]: it says nothing of a cell, or more than a cell can have.
    pub fn take(&mut self, line: &str) -> Result<(), BadPicture> {
        let mut words = line.split_ascii_whitespace();
        let taken = match words.next() {
            Some("cell") => self.take_cell(&mut words),
            Some("feed") => self.take_feed(&mut words),
            Some("instruction") => self.take_instruction(&mut words),
            Some("token") => number(&mut words).map(|holder| self.holder = Some(holder)),
            Some("fault") => {
                self.fault = Some(rest(&mut words));
                Some(())
            }
            Some("process") => process(&mut words)
                .filter(|_| self.processes.len() < MAX_PROCESSES)
                .map(|process| self.processes.push(process)),
            Some("robot") => robot(&mut words)
                .filter(|_| self.robots.len() < MAX_PROCESSES)
                .map(|robot| self.robots.push(robot)),
            Some(_) | None => None,
        };
        let whole = taken.is_some() && words.next().is_none();
        if whole { Ok(()) } else { Err(BadPicture(line.chars().take(80).collect())) }
    }

    fn take_cell(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        let word = words.next()?;
        self.state = CellState::ALL.into_iter().find(|state| state.word() == word)?;
        (self.step, self.period) = (number(words)?, number(words)?);
        Some(())
    }

    fn take_feed(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        (self.rate, self.speed) = (number(words)?, number(words)?);
        Some(())
    }

    fn take_instruction(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        self.instructions = number(words)?;
        let word = words.next()?;
        self.doing = Doing::ALL.into_iter().find(|doing| doing.word() == word)?;
        self.by = rest(words);
        Some(())
    }
}

fn number<T: FromStr>(words: &mut SplitAsciiWhitespace<'_>) -> Option<T> {
    words.next()?.parse().ok()
}

fn rest(words: &mut SplitAsciiWhitespace<'_>) -> String {
    words.collect::<Vec<_>>().join(" ")
}

fn process(words: &mut SplitAsciiWhitespace<'_>) -> Option<ProcessPicture> {
    let pid = number(words)?;
    let runs = match words.next()? {
        "runs" => true,
        "ended" => false,
        _ => return None,
    };
    let mut figures = [0; FIGURES_WORDS];
    for figure in &mut figures {
        *figure = number(words)?;
    }
    Some(ProcessPicture { pid, runs, figures: Figures::get(&figures), name: rest(words) })
}

fn robot(words: &mut SplitAsciiWhitespace<'_>) -> Option<RobotPicture> {
    let (name, time) = (words.next()?.to_owned(), number(words)?);
    let joints = number(words).filter(|&joints: &usize| joints <= MAX_JOINTS)?;
    let mut numbers = || (0..joints).map(|_| number(words)).collect::<Option<Vec<f64>>>();
    Some(RobotPicture { name, time, demanded: numbers()?, measured: numbers()? })
}
