//! A picture of a running cell: the state that the operator is shown, and its form as text.
//!
//! In: a [`Picture`], or lines of text. Out: the text, or the picture again. The text begins with the line `picture`
//! and ends with the line `end`. Each line between them consists of words separated by spaces, and its first word says
//! what the line is about; there is one line for each process and each robot, for what it carries, for each reading and each body.

use core::fmt;
use core::str::SplitAsciiWhitespace;

use super::beside::{BodyPicture, CarriedPicture, ReadingPicture, number};
use crate::board::entry::BODIES;
use crate::board::figures::{FIGURES_WORDS, Figures};
use mrroc_core::link::places::MAX_PROCESSES;
use mrroc_core::operator::CellState;
use mrroc_core::operator::jog::JogStop;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::payload::Wire;
use mrroc_core::pose::Pose;
use mrroc_core::robot::MAX_JOINTS;

/// A line that cannot be part of a picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no part of a picture")]
pub struct BadPicture(String);

/// The state of a running cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Whether the MP is idle, runs an instruction, or is latched after a fault.
    pub state: CellState,
    /// Index of the MP's step.
    pub step: u64,
    /// Period of the step \[ns\].
    pub period: u64,
    /// The epoch: every reset begins another one.
    pub epoch: u32,
    /// The rate of path time, 0 to 1.
    pub rate: f64,
    /// The speed that the operator has set, as a share of the planned speed, 0 to 1.
    pub speed: f64,
    /// Whether the cell is at reduced speed.
    pub reduced: bool,
    /// Whether a person holds what lets its robots move then.
    pub held: bool,
    /// Number of instructions begun.
    pub instructions: u64,
    /// The kind of the present instruction.
    pub doing: InstructionKind,
    /// The name of the present instruction's generator or condition; empty where the MP has no program of its own and
    /// lets those of the ECPs run.
    pub by: String,
    /// The number of the process that holds the control token.
    pub holder: Option<u32>,
    /// The fault that ended the last instruction that failed.
    pub fault: Option<String>,
    /// What to do about it, where its kind alone tells.
    pub help: Option<String>,
    /// In a latched cell: what forbids a reset, or made the last one fail.
    pub persisting: Option<String>,
    /// Its lower cells, and theirs.
    pub cells: Vec<CellPicture>,
    /// The processes of the cell, in the order of their places.
    pub processes: Vec<ProcessPicture>,
    /// The robots of the cell.
    pub robots: Vec<RobotPicture>,
    /// What they carry, and their inputs and outputs.
    pub carried: Vec<CarriedPicture>,
    /// The newest readings of the virtual sensors.
    pub readings: Vec<ReadingPicture>,
    /// Where bodies are.
    pub bodies: Vec<BodyPicture>,
}

/// One lower cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellPicture {
    /// Its name: `press`, `line.press`.
    pub name: String,
    /// Whether its MP is idle, runs an instruction, or is latched after a fault.
    pub state: CellState,
    /// Index of its MP's step.
    pub step: u64,
    /// Period of that step \[ns\].
    pub period: u64,
    /// The rate of its path time, 0 to 1.
    pub rate: f64,
    /// The speed that its own operator has set, as a share of the planned speed, 0 to 1.
    pub speed: f64,
    /// The kind of its present instruction.
    pub doing: InstructionKind,
    /// The name of the present instruction's generator or condition.
    pub by: String,
    /// The fault that ended its last instruction that failed.
    pub fault: Option<String>,
}

/// One process of the cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessPicture {
    /// Its role and robot or sensor, such as `ecp left`.
    pub name: String,
    /// Its number in the operating system.
    pub pid: u32,
    /// Whether it runs.
    pub runs: bool,
    /// How late it was and how long it worked.
    pub figures: Figures,
}

/// One robot of the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotPicture {
    /// Its name.
    pub name: String,
    /// Time of the servo period that is shown \[s\].
    pub time: f64,
    /// Demanded joint positions, in the order of the joints [rad or m].
    pub demanded: Vec<f64>,
    /// Measured joint positions, in the order of the joints [rad or m].
    pub measured: Vec<f64>,
    /// The pose of its tool at the measured joints, `X_WE`; of a mounted robot, in the flange that carries it.
    pub tool: Pose,
    /// What the program of its ECP does now.
    pub doing: InstructionKind,
    /// The name of the generator or condition of that program's last instruction; empty before the first one, and where
    /// the ECP has no program of its own.
    pub by: String,
    /// Whether a program lets it be jogged now.
    pub jogs: bool,
    /// Why it stands though it is jogged.
    pub stop: JogStop,
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "picture")?;
        writeln!(f, "cell {} {} {} {}", self.state.word(), self.step, self.period, self.epoch)?;
        writeln!(f, "feed {} {} {} {}", self.rate, self.speed, self.reduced, self.held)?;
        writeln!(f, "instruction {} {} {}", self.instructions, self.doing.word(), self.by)?;
        if let Some(holder) = self.holder {
            writeln!(f, "token {holder}")?;
        }
        if let Some(fault) = &self.fault {
            writeln!(f, "fault {}", one_line(fault))?;
        }
        if let Some(help) = &self.help {
            writeln!(f, "help {}", one_line(help))?;
        }
        if let Some(persisting) = &self.persisting {
            writeln!(f, "persisting {}", one_line(persisting))?;
        }
        for cell in &self.cells {
            let CellPicture { name, step, period, rate, speed, by, .. } = cell;
            writeln!(
                f,
                "lower {name} {} {step} {period} {rate} {speed} {} {by}",
                cell.state.word(),
                cell.doing.word()
            )?;
            if let Some(fault) = &cell.fault {
                writeln!(f, "lower-fault {}", one_line(fault))?;
            }
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
            // With an exponent: however small a number is, it takes at most 24 bytes.
            robot.demanded.iter().chain(&robot.measured).try_for_each(|q| write!(f, " {q:e}"))?;
            let mut tool = [0; Pose::LEN];
            robot.tool.put(&mut tool);
            tool.iter().try_for_each(|word| write!(f, " {:e}", f64::from_bits(*word)))?;
            let (jogs, stop) = (robot.jogs, robot.stop.to_word());
            writeln!(f, " {jogs} {stop} {} {}", robot.doing.word(), robot.by)?;
        }
        self.carried.iter().try_for_each(|carried| writeln!(f, "{carried}"))?;
        self.readings.iter().try_for_each(|reading| writeln!(f, "{reading}"))?;
        self.bodies.iter().try_for_each(|body| writeln!(f, "{body}"))?;
        writeln!(f, "end")
    }
}

impl Picture {
    /// Who carries out the present instruction, in words: its generator or condition, or the programs of the ECPs.
    #[must_use]
    pub fn by_whom(&self) -> &str {
        match self.doing {
            InstructionKind::Move if self.by.is_empty() => "of each robot by its own program",
            InstructionKind::Nothing
            | InstructionKind::Homing
            | InstructionKind::Move
            | InstructionKind::Wait => &self.by,
        }
    }
}

impl Picture {
    /// How its speed is reduced, in words that follow others; empty where it is not.
    #[must_use]
    pub const fn reduction(&self) -> &'static str {
        match (self.reduced, self.held) {
            (false, _) => "",
            (true, true) => ", reduced, held",
            (true, false) => ", reduced, nobody holds",
        }
    }
}

impl RobotPicture {
    /// What the program of its ECP does, in words that follow others: `: move Line`; empty where it does nothing, or is
    /// none.
    #[must_use]
    pub fn motion(&self) -> String {
        match self.doing {
            InstructionKind::Nothing => String::new(),
            InstructionKind::Homing | InstructionKind::Move | InstructionKind::Wait => {
                format!(": {} {}", self.doing.word(), self.by)
            }
        }
    }
}

/// Joins the lines of a text: a program's text of a fault may have several.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl Picture {
    /// Takes one line between the first and the last line of a picture.
    ///
    /// # Errors
    /// `BadPicture`: the line has no valid form, or there are more processes or robots than a cell can have.
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
            Some("help") => {
                self.help = Some(rest(&mut words));
                Some(())
            }
            Some("persisting") => {
                self.persisting = Some(rest(&mut words));
                Some(())
            }
            Some("lower") => lower(&mut words)
                .filter(|_| self.cells.len() < MAX_PROCESSES)
                .map(|cell| self.cells.push(cell)),
            Some("lower-fault") => self.cells.last_mut().map(|cell| cell.fault = Some(rest(&mut words))),
            Some("process") => process(&mut words)
                .filter(|_| self.processes.len() < MAX_PROCESSES)
                .map(|process| self.processes.push(process)),
            Some("robot") => robot(&mut words)
                .filter(|_| self.robots.len() < MAX_PROCESSES)
                .map(|robot| self.robots.push(robot)),
            Some("carries") => CarriedPicture::take(&mut words)
                .filter(|_| self.carried.len() < MAX_PROCESSES)
                .map(|carried| self.carried.push(carried)),
            Some("reading") => ReadingPicture::take(&mut words)
                .filter(|_| self.readings.len() < MAX_PROCESSES)
                .map(|reading| self.readings.push(reading)),
            Some("body") => BodyPicture::take(&mut words)
                .filter(|_| self.bodies.len() < BODIES)
                .map(|body| self.bodies.push(body)),
            Some(_) | None => None,
        };
        let whole = taken.is_some() && words.next().is_none();
        if whole { Ok(()) } else { Err(BadPicture(line.chars().take(80).collect())) }
    }

    fn take_cell(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        self.state = state(words)?;
        (self.step, self.period, self.epoch) = (number(words)?, number(words)?, number(words)?);
        Some(())
    }

    fn take_feed(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        (self.rate, self.speed) = (number(words)?, number(words)?);
        (self.reduced, self.held) = (number(words)?, number(words)?);
        Some(())
    }

    fn take_instruction(&mut self, words: &mut SplitAsciiWhitespace<'_>) -> Option<()> {
        self.instructions = number(words)?;
        (self.doing, self.by) = (doing(words)?, rest(words));
        Some(())
    }
}

fn state(words: &mut SplitAsciiWhitespace<'_>) -> Option<CellState> {
    let word = words.next()?;
    CellState::ALL.into_iter().find(|state| state.word() == word)
}

fn doing(words: &mut SplitAsciiWhitespace<'_>) -> Option<InstructionKind> {
    let word = words.next()?;
    InstructionKind::ALL.into_iter().find(|doing| doing.word() == word)
}

fn rest(words: &mut SplitAsciiWhitespace<'_>) -> String {
    words.collect::<Vec<_>>().join(" ")
}

fn lower(words: &mut SplitAsciiWhitespace<'_>) -> Option<CellPicture> {
    Some(CellPicture {
        name: words.next()?.to_owned(),
        state: state(words)?,
        step: number(words)?,
        period: number(words)?,
        rate: number(words)?,
        speed: number(words)?,
        doing: doing(words)?,
        by: rest(words),
        fault: None,
    })
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
    let (demanded, measured) = (numbers()?, numbers()?);
    let mut tool = [0; Pose::LEN];
    for word in &mut tool {
        *word = number::<f64>(words)?.to_bits();
    }
    let tool = Pose::get(&tool).ok()?;
    let (jogs, stop) = (number(words)?, JogStop::from_word(number(words)?));
    Some(RobotPicture {
        name,
        time,
        demanded,
        measured,
        tool,
        jogs,
        stop,
        doing: doing(words)?,
        by: rest(words),
    })
}
