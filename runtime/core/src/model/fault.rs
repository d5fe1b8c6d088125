//! Faults: `f_E` of the paper. What went wrong, in which process, for which robot and joint, in which step.

use core::fmt;

use crate::console::quoted;
use crate::model::driver::DriveFault;
use crate::model::excess::Excess;
use crate::model::name::Name;
use crate::model::wire::{BadWords, WORDS, Wire};

/// How severe a fault is; the most severe active one decides, the first of equals is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultClass {
    /// Bad input before motion: nothing moved.
    Refused,
    /// Late, lost or stale inside the budget: counted, never returned.
    Tolerated,
    /// A controlled stop on the path, drives hold (stop category 2).
    Suspended,
    /// A controlled stop, latched (stop category 1).
    Stopped,
    /// Power removed by a drive (stop category 0).
    PowerOff,
}

macro_rules! fault_kinds {
    ($($(#[doc = $doc:literal])* $kind:ident = $code:literal: $class:ident, $text:literal;)*) => {
        /// The cause of a fault.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum FaultKind {
            $($(#[doc = $doc])* $kind,)*
        }

        impl FaultKind {
            /// The class that the kind belongs to.
            #[must_use]
            pub const fn class(self) -> FaultClass {
                match self { $(FaultKind::$kind => FaultClass::$class,)* }
            }

            const fn text(self) -> &'static str {
                match self { $(FaultKind::$kind => $text,)* }
            }

            const fn code(self) -> u64 {
                match self { $(FaultKind::$kind => $code,)* }
            }

            const fn from_code(code: u64) -> Option<FaultKind> {
                match code { $($code => Some(FaultKind::$kind),)* _ => None }
            }
        }
    };
}

fault_kinds! {
    /// The cell was put together wrongly.
    Config = 1: Refused, "the cell is not put together as the program needs it";
    /// The program broke a rule of the runtime, or threw a fault of its own.
    Program = 2: Stopped, "fault thrown by the program";
    /// The two halves of a motion disagree about the order's payload.
    PayloadMismatch = 3: Refused, "the MP and the ECP disagree about the order";
    /// The operator aborted the instruction.
    Aborted = 4: Suspended, "aborted by the operator";
    /// The MP ended the instruction that the ECP was still working on. [`Ecp::obey`](crate::program::Ecp::obey) turns it into `Ok`.
    InstructionEnded = 5: Suspended, "the instruction was ended by the MP";
    /// A Wait did not see its condition within its time-out.
    TimedOut = 6: Suspended, "the condition was not met in time";
    /// An ECP finished a tight motion before the MP ended it.
    FinishedEarly = 7: Stopped, "the ECP finished a tight motion before the MP ended it";
    /// The process at the other end is gone.
    PeerLost = 8: Stopped, "the process at the other end is gone";
    /// Another process of the cell stopped with a fault, which is reported there.
    StoppedByCell = 9: Stopped, "the cell was stopped by a fault elsewhere";
    /// A number in a demand is NaN or infinite.
    DemandNotFinite = 10: Stopped, "demand is not finite";
    /// A demanded orientation is no rotation.
    DemandInvalidFrame = 11: Stopped, "demanded frame is no rotation";
    /// A demanded position lies beyond a joint limit, or so near that the joint could not stop before it.
    DemandOutOfRange = 12: Stopped, "demanded position exceeds the limit";
    /// The demanded velocity exceeds the limit.
    DemandedVelocity = 13: Stopped, "demanded velocity exceeds the limit";
    /// The demanded acceleration exceeds the limit.
    DemandedAcceleration = 14: Stopped, "demanded acceleration exceeds the limit";
    /// The demanded jerk exceeds the limit.
    DemandedJerk = 15: Stopped, "demanded jerk exceeds the limit";
    /// At the start of a motion the robot is not where it was demanded to be.
    StartPoseMismatch = 16: Refused, "wrong start";
    /// A demanded pose has no joint positions.
    NoInverseKinematics = 17: Stopped, "no inverse kinematics";
    /// A sensor's reading is older than the program allows.
    SensorStale = 18: Suspended, "the sensor's reading is too old";
    /// A virtual sensor gave no reading.
    SensorFailed = 19: Suspended, "the virtual sensor failed";
    /// The robot does not follow its demands.
    FollowingError = 20: Stopped, "following error exceeds the limit";
    /// A drive tripped.
    DriveFault = 21: PowerOff, "drive fault";
    /// A step function, a driver or a guard panicked.
    Panicked = 22: Stopped, "panic in the program";
    /// A demand chooses a regulator's parameter set that the drive does not have.
    NoRegulator = 25: Stopped, "the drive has no such regulator";
    /// A guard of the cell saw what must not go on: a protective stop on the path.
    ProtectiveStop = 26: Stopped, "protective stop";
    /// A process was late for too many steps.
    Overrun = 27: Stopped, "too many steps were missed";
    /// The cell is closing: the MP's program is over.
    CellClosed = 24: Refused, "the MP's program is over";
    /// A message could not be read.
    Message = 23: Stopped, "a message could not be read";
}

impl FaultKind {
    /// Whether it says how the runtime ended an instruction or the cell: thrown by a program it means nothing.
    const fn is_the_runtimes(self) -> bool {
        matches!(
            self,
            FaultKind::Aborted
                | FaultKind::InstructionEnded
                | FaultKind::StoppedByCell
                | FaultKind::CellClosed
        )
    }
}

/// The message of an operator's protective stop.
pub const BY_OPERATOR: &str = "by the operator";

/// What is added to the message of a protective stop that was too long on the path: short, for texts of guards are long.
const OFF_PATH: &str = "; left the path";

/// The message of the stop of a cell whose launcher stands still.
pub const UNSUPERVISED: &str = "the launcher stands still: nobody supervises the cell";

/// A short text that travels with a fault: what the program or a panic said, cut at 120 bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Text {
    bytes: [u8; 120],
    len: u8,
}

impl Text {
    fn new(text: &str) -> Text {
        let text = Text::cut(text, 120);
        let mut bytes = [0; 120];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Text { bytes, len: text.len() as u8 }
    }

    /// As much of a text as has so many bytes.
    fn cut(text: &str, bytes: usize) -> &str {
        let mut len = text.len().min(bytes);
        while !text.is_char_boundary(len) {
            len -= 1;
        }
        &text[..len]
    }

    fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.len)]).unwrap_or("")
    }
}

/// The role of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Master process, the coordinator.
    Mp,
    /// Effector control process.
    Ecp,
    /// Effector driver process.
    Edp,
    /// Virtual sensor process.
    Vsp,
    /// The simulated drives of a cell, where they are a process of their own.
    Plant,
}

/// Who a process is: `mp`, `ecp rnt`, `edp rnt`, `vsp force`, `plant`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProcessId {
    /// What it does.
    pub role: Role,
    /// Whose it is; `None` for the MP and the plant.
    pub name: Option<Name>,
}

impl ProcessId {
    /// The MP.
    pub const MP: ProcessId = ProcessId { role: Role::Mp, name: None };

    /// The simulated drives.
    pub const PLANT: ProcessId = ProcessId { role: Role::Plant, name: None };

    /// The process of a robot or a sensor.
    #[must_use]
    pub const fn new(role: Role, name: Name) -> ProcessId {
        ProcessId { role, name: Some(name) }
    }
}

impl fmt::Display for ProcessId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let role = match self.role {
            Role::Mp => "mp",
            Role::Ecp => "ecp",
            Role::Edp => "edp",
            Role::Vsp => "vsp",
            Role::Plant => "plant",
        };
        match &self.name {
            Some(name) => write!(f, "{role} {name}"),
            None => f.write_str(role),
        }
    }
}

/// The units that excesses come in; a unit travels as its place in this list.
const UNITS: [&str; 13] =
    ["", "rad", "m", "rad/s", "m/s", "rad/s²", "m/s²", "rad/s³", "m/s³", "step", "A", "N", "N m"];

#[derive(Clone, Copy, PartialEq)]
struct Report {
    kind: FaultKind,
    process: Option<ProcessId>,
    joint: Option<u32>,
    step: Option<u64>,
    excess: Option<Excess>,
    text: Text,
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
            excess: None,
            text: Text::new(""),
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
        Fault::new(FaultKind::ProtectiveStop).in_process(ProcessId::MP).text(BY_OPERATOR)
    }

    /// The protective stop of a cell whose launcher stands still.
    pub fn of_launcher() -> Fault {
        Fault::new(FaultKind::ProtectiveStop).in_process(ProcessId::MP).text(UNSUPERVISED)
    }

    /// The fault of a drive that gave up.
    pub fn of_drive(trip: &DriveFault) -> Fault {
        let fault = Fault::new(FaultKind::DriveFault).text(trip.what());
        match *trip {
            DriveFault::Exceeded { joint, excess, .. } => fault.at_joint(joint).exceeds_by(excess),
            DriveFault::NoAnswer | DriveFault::Other(_) => fault,
        }
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

/// `edp rnt joint 3: demanded velocity exceeds the limit: 2.91 rad/s, limit 2.62 rad/s at step 10482`.
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
        if let Some(Excess { actual, limit, unit }) = report.excess {
            let digits = if unit == "step" { 0 } else { 6 };
            let space = if unit.is_empty() { "" } else { " " };
            write!(f, ": {actual:.digits$}{space}{unit}, limit {limit:.digits$}{space}{unit}")?;
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

/// A fault on the wire.
#[derive(Clone, Copy)]
pub struct FaultWords(Report);

impl From<&Fault> for FaultWords {
    fn from(fault: &Fault) -> Self {
        FaultWords(*fault.0)
    }
}

impl From<FaultWords> for Fault {
    fn from(words: FaultWords) -> Self {
        Fault(Box::new(words.0))
    }
}

const NONE: u64 = u64::MAX;

/// The bit beside a text's length that says that the first demand of a motion met the fault.
const FIRST_DEMAND: u64 = 1 << 32;

impl Wire for FaultWords {
    const LEN: usize = 8 + 3 + 15;
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "fault");

    fn put(&self, words: &mut [u64]) {
        let report = &self.0;
        words[0] = report.kind.code();
        words[1] = report.process.map_or(NONE, |process| process.role as u64);
        words[2] = report.joint.map_or(NONE, u64::from);
        words[3] = report.step.unwrap_or(NONE);
        let unit =
            report.excess.map(|excess| UNITS.iter().position(|&u| u == excess.unit).unwrap_or(0) as u64);
        words[4] = unit.unwrap_or(NONE);
        words[5] = report.excess.map_or(0, |excess| excess.actual.to_bits());
        words[6] = report.excess.map_or(0, |excess| excess.limit.to_bits());
        words[7] = u64::from(report.text.len) | if report.first { FIRST_DEMAND } else { 0 };
        match report.process.and_then(|process| process.name) {
            Some(name) => name.put(&mut words[8..11]),
            None => words[8..11].fill(0),
        }
        for (word, chunk) in words[11..26].iter_mut().zip(report.text.bytes.chunks_exact(8)) {
            *word = chunk.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        let some = |word: u64| (word != NONE).then_some(word);
        let role = match some(words[1]) {
            None => None,
            Some(0) => Some(Role::Mp),
            Some(1) => Some(Role::Ecp),
            Some(2) => Some(Role::Edp),
            Some(3) => Some(Role::Vsp),
            Some(4) => Some(Role::Plant),
            Some(_) => return Err(BadWords),
        };
        let process = role.map(|role| ProcessId { role, name: Name::get(&words[8..11]).ok() });
        let excess = match some(words[4]) {
            None => None,
            Some(unit) => Some(Excess {
                actual: f64::from_bits(words[5]),
                limit: f64::from_bits(words[6]),
                unit: UNITS.get(unit as usize).copied().ok_or(BadWords)?,
            }),
        };
        let mut bytes = [0; 120];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(&words[11..]) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        let len = u8::try_from(words[7] & !FIRST_DEMAND).ok().filter(|&len| len <= 120).ok_or(BadWords)?;
        Ok(FaultWords(Report {
            kind: FaultKind::from_code(words[0]).ok_or(BadWords)?,
            process,
            joint: some(words[2]).map(|joint| joint as u32),
            step: some(words[3]),
            excess,
            text: Text { bytes, len },
            first: words[7] & FIRST_DEMAND != 0,
            orderly: false,
        }))
    }
}

const _: () = assert!(FaultWords::LEN <= WORDS, "a fault fits into a message");

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
