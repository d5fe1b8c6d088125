//! Faults: `f_E` of the paper. What went wrong, in which process, for which robot and joint, in which step.
//!
//! [`kind`] has the causes, [`process`] who meets them; here is the report of one, and [`wire`] is how it travels.

mod kind;
mod process;
mod text;
mod wire;

use core::fmt;

use crate::console::quoted;
use crate::model::drive_fault::DriveFault;
use crate::model::excess::Excess;
use crate::model::instruction::Instruction;
use crate::model::name::Name;
use crate::model::robot_stop::{ClearedBy, RobotStop, StopCause, Stopped};

pub use kind::{FaultClass, FaultKind};
pub use process::{ProcessId, Role};
use text::Text;
pub use wire::FaultWords;

/// The message of an operator's protective stop.
pub const BY_OPERATOR: &str = "by the operator";

/// What is added to the message of a protective stop that was too long on the path: short, for texts of guards are long.
const OFF_PATH: &str = "; left the path";

/// The message of the stop of a cell whose launcher stands still.
pub const UNSUPERVISED: &str = "the launcher stands still: nobody supervises the cell";

#[derive(Clone, Copy, PartialEq)]
struct Report {
    kind: FaultKind,
    process: Option<ProcessId>,
    joint: Option<u32>,
    step: Option<u64>,
    /// The instruction in which it happened.
    instruction: Option<Instruction>,
    excess: Option<Excess>,
    text: Text,
    /// What has stopped the robot, if nothing in the cell has.
    stopped: Option<Stopped>,
    /// Met by the first demand of a motion.
    first: bool,
    /// Made by the runtime as the end of an instruction at standstill: nothing is to be stopped for it. It never
    /// travels, and is lost where a program's own function throws the fault.
    orderly: bool,
}

/// Why a Move or a Wait ended without its condition. One fault is one cause; the first cause of a stop is kept.
///
/// A program throws one of its own with [`Fault::thrown`]; the runtime fills in process and step.
#[derive(Clone, PartialEq)]
pub struct Fault(Box<Report>);

impl Fault {
    /// A fault of the given kind.
    #[must_use]
    pub fn new(kind: FaultKind) -> Fault {
        Fault(Box::new(Report {
            kind,
            process: None,
            joint: None,
            step: None,
            instruction: None,
            excess: None,
            text: Text::new(""),
            stopped: None,
            first: false,
            orderly: false,
        }))
    }

    /// A fault that ends an instruction, or the cell, in order: no robot moves, and none has to be stopped.
    pub fn orderly(kind: FaultKind) -> Fault {
        let mut fault = Fault::new(kind);
        fault.0.orderly = true;
        fault
    }

    /// Whether the runtime ended an instruction by it at standstill.
    pub fn is_orderly(&self) -> bool {
        self.0.orderly
    }

    /// The fault that user code threw: a kind that only the runtime can know of is the program's own then.
    pub fn thrown_by_program(mut self) -> Fault {
        self.0.orderly = false;
        if self.kind().is_the_runtimes() {
            self.0.text = Text::new(&format!("the program threw `{:?}`: {}", self.kind(), self.message()));
            self.0.kind = FaultKind::Program;
        }
        self
    }

    /// The fault for which a guard stops the cell.
    pub fn of_guard(self) -> Fault {
        let mut fault = self.thrown_by_program();
        if fault.kind() == FaultKind::Program {
            fault.0.kind = FaultKind::ProtectiveStop;
        }
        fault
    }

    /// Whether it is of a sensor that answers, without a reading to move by: robots can stop on their paths for it.
    pub fn leaves_demands_sound(&self) -> bool {
        let of_sensor = self.process().is_some_and(|process| process.role == Role::Vsp);
        of_sensor && !self.is_orderly() && !matches!(self.kind(), FaultKind::PeerLost | FaultKind::Message)
    }

    /// The operator's protective stop.
    pub fn of_operator() -> Fault {
        Fault::new(FaultKind::ProtectiveStop).text(BY_OPERATOR)
    }

    /// The protective stop of a cell whose launcher stands still.
    pub fn of_launcher() -> Fault {
        Fault::new(FaultKind::ProtectiveStop).text(UNSUPERVISED)
    }

    /// The fault of a drive that gave up.
    pub fn of_drive(trip: &DriveFault) -> Fault {
        let fault = Fault::new(FaultKind::DriveFault).text(trip.what());
        match *trip {
            DriveFault::Exceeded { joint, excess, .. } => fault.at_joint(joint).exceeds_by(excess),
            DriveFault::Stopped(stop) => Fault::of_robot_stop(&stop),
            DriveFault::NoAnswer | DriveFault::Other(_) => fault,
        }
    }

    /// The fault of a robot that was stopped by its own controller or a person beside it.
    pub fn of_robot_stop(stop: &RobotStop) -> Fault {
        let mut fault = Fault::new(FaultKind::RobotStopped).text(&stop.to_string());
        fault.0.stopped = Some(Stopped::from(stop));
        fault
    }

    /// What has stopped the robot, and who may clear that, of a [`RobotStopped`](FaultKind::RobotStopped).
    #[must_use]
    pub fn robot_stop(&self) -> Option<(StopCause, ClearedBy)> {
        self.stopped().map(|stopped| (stopped.cause, stopped.cleared_by))
    }

    pub(crate) fn stopped(&self) -> Option<Stopped> {
        self.0.stopped
    }

    /// A fault that a program throws: lower case, what is wrong, what to do (cut at 120 bytes).
    #[must_use]
    pub fn thrown(text: &str) -> Fault {
        Fault::new(FaultKind::Program).text(text)
    }

    /// Adds a text.
    #[must_use]
    pub fn text(mut self, text: &str) -> Fault {
        self.0.text = Text::new(text);
        self
    }

    /// Says that the robots left their paths to stand in time.
    pub fn off_path(self) -> Fault {
        let message = self.message();
        let cut = Text::cut(message, 120 - OFF_PATH.len());
        let text =
            format!("{cut}{}", if cut.is_empty() { OFF_PATH.trim_start_matches("; ") } else { OFF_PATH });
        self.text(&text)
    }

    /// Says that the first demand of a motion met it.
    pub fn of_first_demand(mut self) -> Fault {
        self.0.first = true;
        self
    }

    /// Whether the first demand of a motion met it: the generator does not begin where the robot is.
    #[must_use]
    pub fn is_of_first_demand(&self) -> bool {
        self.0.first
    }

    /// Names the process, unless one is named.
    #[must_use]
    pub fn in_process(mut self, process: ProcessId) -> Fault {
        self.0.process.get_or_insert(process);
        self
    }

    /// Names the joint, counted from 0.
    #[must_use]
    pub fn at_joint(mut self, joint: usize) -> Fault {
        self.0.joint = Some(joint as u32);
        self
    }

    /// Names the step, unless one is named.
    #[must_use]
    pub fn at_step(mut self, step: u64) -> Fault {
        self.0.step.get_or_insert(step);
        self
    }

    /// Names the instruction in which it happened, unless one is named; none names none.
    pub(crate) fn in_instruction(mut self, instruction: Option<Instruction>) -> Fault {
        self.0.instruction = self.0.instruction.or(instruction);
        self
    }

    /// Says which value exceeds which limit.
    #[must_use]
    pub fn exceeds(mut self, actual: f64, limit: f64, unit: &'static str) -> Fault {
        self.0.excess = Some(Excess::new(actual, limit, unit));
        self
    }

    /// Says which value exceeds its limit.
    #[must_use]
    pub fn exceeds_by(mut self, excess: Excess) -> Fault {
        self.0.excess = Some(excess);
        self
    }

    /// The cause.
    #[must_use]
    pub fn kind(&self) -> FaultKind {
        self.0.kind
    }

    /// How severe it is.
    #[must_use]
    pub fn class(&self) -> FaultClass {
        self.0.kind.class()
    }

    /// The process that met it.
    #[must_use]
    pub fn process(&self) -> Option<ProcessId> {
        self.0.process
    }

    /// The robot concerned, when it was met by a process of a robot.
    #[must_use]
    pub fn robot(&self) -> Option<Name> {
        self.0
            .process
            .filter(|process| matches!(process.role, Role::Ecp | Role::Edp))
            .and_then(|process| process.name)
    }

    /// The joint, counted from 0.
    #[must_use]
    pub fn joint(&self) -> Option<usize> {
        self.0.joint.map(|joint| joint as usize)
    }

    /// The index of the step since the cell started.
    #[must_use]
    pub fn step(&self) -> Option<u64> {
        self.0.step
    }

    /// The instruction of the program in which it happened; `None` between two of them.
    #[must_use]
    pub fn instruction(&self) -> Option<Instruction> {
        self.0.instruction
    }

    /// The value that exceeded its limit.
    #[must_use]
    pub fn excess(&self) -> Option<Excess> {
        self.0.excess
    }

    /// What the program, a panic or the runtime said besides.
    #[must_use]
    pub fn message(&self) -> &str {
        self.0.text.as_str()
    }
}

/// `edp rnt joint 3: demanded velocity exceeds the limit: 2.91 rad/s, at most 2.62 rad/s in Move 7 (Carry) at step 10482`.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = &self.0;
        if let Some(process) = &report.process {
            write!(f, "{process}")?;
            if let Some(joint) = report.joint {
                write!(f, " joint {}", joint + 1)?;
            }
            f.write_str(": ")?;
        }
        f.write_str(report.kind.text())?;
        if report.first {
            f.write_str(", in the first step of a motion")?;
        }
        if report.text.len > 0 {
            // A fault may come from a recording, and a text of a program from a file.
            write!(f, ": {}", quoted(report.text.as_str(), report.text.bytes.len()))?;
        }
        if let Some(excess) = report.excess {
            let Excess { actual, limit, unit } = excess;
            let digits = if unit == "step" { 0 } else { 6 };
            let space = if unit.is_empty() { "" } else { " " };
            let allowed = excess.allowed();
            write!(f, ": {actual:.digits$}{space}{unit}, {allowed} {limit:.digits$}{space}{unit}")?;
        }
        if let Some(instruction) = report.instruction {
            write!(f, " in {instruction}")?;
            // The Moves of an ECP's own program are not counted with those of the coordinator.
            match (instruction.is_of_ecp(), report.process.map(|process| process.role)) {
                (true, Some(Role::Ecp)) => {}
                (true, _) => f.write_str(" of its ECP")?,
                (false, Some(Role::Ecp)) => f.write_str(" of the MP")?,
                (false, _) => {}
            }
        }
        match report.step.filter(|&step| step > 0) {
            Some(step) => write!(f, " at step {step}"),
            None => Ok(()),
        }
    }
}

impl fmt::Debug for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fault({:?}: {self})", self.0.kind)
    }
}

impl std::error::Error for Fault {}

/// What unwinds a program that will not end otherwise: no panic of its own.
pub struct Ended(pub &'static str);

/// The fault that a panic of a program or a sensor becomes.
pub fn panicked(panic: &(dyn core::any::Any + Send)) -> Fault {
    if let Some(Ended(text)) = panic.downcast_ref() {
        return Fault::thrown(text);
    }
    let text = panic.downcast_ref::<&str>().copied();
    let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    Fault::new(FaultKind::Panicked).text(text.unwrap_or("no message"))
}
