//! Why a cell did not run.

use core::time::Duration;

use crate::cell::robot::signals::WrongSignal;
use crate::link::memory::Stuck;
use crate::model::fault::Fault;
use crate::model::name::{BadName, Name};
use crate::observe::recording::NotRecorded;

/// Why a cell did not run, or did not run to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CellError {
    /// A word that cannot be a name.
    #[error(transparent)]
    Name(#[from] BadName),
    /// Two robots, or two sensors, of one name.
    #[error("the cell has two of the name `{0}`: give each a name of its own")]
    Twice(Name),
    /// A sensor of a robot that the cell does not have.
    #[error("sensor `{0}` belongs to robot `{1}`, which the cell does not have")]
    NoSuchRobot(Name, String),
    /// A reader of a sensor that the cell does not have.
    #[error("sensor `{0}` shall be read by robot `{1}`, which the cell does not have")]
    NoSuchReader(Name, String),
    /// A sensor that is asked too seldom, or has a period of its own.
    #[error(
        "sensor `{sensor}` is asked every {every} steps, and its readings are too old to move by after {max_age}\n help: write every = 1 to {max_age}, or a longer stale_after_ms; a free-running sensor has a period_ms and no `every`"
    )]
    AskedEvery {
        /// The sensor.
        sensor: Name,
        /// The steps that one order is for.
        every: u32,
        /// Steps after which a reading is too old.
        max_age: u32,
    },
    /// A program for the ECP of a robot that the cell does not have.
    #[error(
        "a program is given to the ECP of robot `{0}`, which the cell does not have; it has: {1}\n help: write one of these in `.ecp(..)`, or a table [robots.{0}] in cell.toml"
    )]
    NoRobot(String, String),
    /// A program for the ECP of a robot of another kind.
    #[error(
        "robot `{robot}` is of the kind {kind}, the program of its ECP is written for another kind, {written}\n help: write the program for it, `Ecp<..>` of its kind, or another `kind` in cell.toml"
    )]
    OtherKind {
        /// The robot.
        robot: String,
        /// Its kind.
        kind: &'static str,
        /// The kind that the program is written for.
        written: &'static str,
    },
    /// A sensor of the cell's file that no virtual sensor computes.
    #[error(
        "sensor `{0}` of the cell's file has no VSP: add `.sensor(file.sensor(\"{0}\", ..)?)` to the cell, with the virtual sensor that computes it, or take [sensors.{0}] out of the file"
    )]
    NoVsp(String),
    /// It cannot run as processes of the operating system; nothing has moved.
    #[error("{0}")]
    Processes(String),
    /// Drives that are hardware, in a cell whose time is not that of the world.
    #[error(
        "robot `{robot}` has real drives, {hardware}, which cannot follow the virtual clock; nothing was opened\n help: run the cell in real time, `cargo run -- --processes`; or let simulated drives stand in: `--dry-run`, `--simulated`, in a program `cell.simulated()`"
    )]
    RealDrives {
        /// The robot.
        robot: Name,
        /// What its driver calls them.
        hardware: String,
    },
    /// Real drives that nothing can stand in for.
    #[error(
        "robot `{robot}` has real drives, {hardware}, and nothing to stand in for them; nothing was opened\n help: give its set-up simulated drives, `.stand_in(..)`"
    )]
    NoStandIn {
        /// The robot.
        robot: Name,
        /// What its driver calls them.
        hardware: String,
    },
    /// A sensor with hardware, in a cell whose time is not that of the world.
    #[error(
        "sensor `{sensor}` has hardware, {hardware}, which cannot follow the virtual clock; nothing was opened\n help: run the cell in real time, `cargo run -- --processes`; or let a simulated sensor stand in: `--dry-run`, `--simulated`, in a program `cell.simulated()`"
    )]
    RealSensor {
        /// The sensor.
        sensor: Name,
        /// What it calls its hardware.
        hardware: String,
    },
    /// A sensor with hardware that nothing can stand in for.
    #[error(
        "sensor `{sensor}` has hardware, {hardware}, and nothing to stand in for it; nothing was opened\n help: give its set-up a simulated sensor, `.stand_in(..)`"
    )]
    NoSensorStandIn {
        /// The sensor.
        sensor: Name,
        /// What it calls its hardware.
        hardware: String,
    },
    /// What is wrong with the cell's file.
    #[error("{0}")]
    File(String),
    /// A second program for one ECP.
    #[error("the ECP of robot `{0}` is given two programs: give it one")]
    TwoPrograms(String),
    /// More processes than a cell may have.
    #[error(
        "the cell has {processes} processes: an MP, two for each robot, one for each sensor, and one for all drives that are \
         simulated; there may be {limit}: remove robots or sensors"
    )]
    TooMany {
        /// How many it has.
        processes: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A step that takes no time.
    #[error("the step of the cell takes no time: give it 1 ms or more")]
    Step,
    /// Neither an MP program nor an ECP program.
    #[error(
        "the cell has no program: give one to the MP, `cell.program(coordinate)`, or to an ECP, `cell.ecp(\"arm\", arm)`"
    )]
    NoProgram,
    /// A lower cell of the cell's file that the program does not add.
    #[error(
        "cell `{0}` of the cell's file is not in the cell: add `.cell(\"{0}\", file.lower(\"{0}\")?.cell(&kinds)?.program(..))`, or take \
         [cells.{0}] out of the file"
    )]
    NoLowerCell(String),
    /// Something that is wrong with a lower cell.
    #[error("cell `{cell}`: {error}")]
    InCell {
        /// The lower cell.
        cell: String,
        /// What is wrong with it.
        error: Box<CellError>,
    },
    /// A lower cell whose MP has no program.
    #[error(
        "its MP has no program that serves: give it one, `.program(|mp| mp.serve_all(|mp, order: YourOrder| ..))`"
    )]
    NoObedience,
    /// A lower cell that asks for a recording of its own.
    #[error(
        "it asks for a recording of its own; that of the uppermost cell has all cells in it\n help: take [recording] out of its file, and \
         record the uppermost cell, by [recording] or --record"
    )]
    RecordedInCell,
    /// A driver whose servo period takes no time.
    #[error(
        "robot `{0}`: its servo period is 0\n help: let `Driver::period` say how often the drives take a demand"
    )]
    NoServo(Name),
    /// A named input or output of a robot that cannot be.
    #[error("robot `{robot}`, signal `{}`: {wrong}", crate::console::quoted(signal, 40))]
    Signal {
        /// The robot.
        robot: Name,
        /// The signal.
        signal: String,
        /// What is wrong with it.
        wrong: WrongSignal,
    },
    /// Two frames, or two tools, of one name.
    #[error("the cell has two {what}s of the name `{name}`: give each a name of its own")]
    TwoNamed {
        /// `frame` or `tool`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A tool whose load is that of no body.
    #[error("tool `{name}`: {wrong}")]
    ToolLoad {
        /// The tool.
        name: String,
        /// What is wrong with it.
        wrong: &'static str,
    },
    /// Interpolation in the task space of a robot whose joints a pose does not determine.
    #[error(
        "robot `{0}`: a pose does not determine its joints, so nothing can be interpolated in the task space\n help: leave `interpolation(InterpolationSpace::Task)` out"
    )]
    TaskSpace(Name),
    /// A servo period that does not fit the step.
    #[error(
        "robot `{robot}`: the step, {step:?}, and its servo period, {servo:?}, must be multiples of one another\n help: write step_ms = {0}, or a multiple of it, in cell.toml",
        servo.as_secs_f64() * 1e3
    )]
    Period {
        /// The robot.
        robot: Name,
        /// Its servo period.
        servo: Duration,
        /// The cell's step.
        step: Duration,
    },
    /// A value of a robot's set-up that no demand could be checked against.
    #[error("robot `{robot}` joint {}: {what} {value} {unit} {rule}", joint + 1)]
    Limit {
        /// The robot.
        robot: Name,
        /// The joint, counted from 0.
        joint: usize,
        /// Which value.
        what: &'static str,
        /// The value.
        value: f64,
        /// What must hold of it.
        rule: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// A robot that is mounted on none of the cell.
    #[error("robot `{robot}` is mounted on `{on}`, which is not there: {there}")]
    NoCarrier {
        /// The robot.
        robot: Name,
        /// What it should be mounted on.
        on: String,
        /// What to write.
        there: String,
    },
    /// A robot that is mounted on itself, perhaps through others.
    #[error("robot `{robot}` is mounted on `{on}`, and that on it: one of them must stand in the world")]
    MountedOnItself {
        /// The robot.
        robot: Name,
        /// What it is mounted on.
        on: String,
    },
    /// A joint that could not stop in the time that the cell allows its robot, by
    /// [`Cell::stop_time`](crate::cell::Cell::stop_time) or [`RobotSetup::stop_time`](crate::cell::RobotSetup::stop_time).
    #[error(
        "robot `{robot}` joint {}: a stop may take {time:.3} s, at most {limit:.3} s: lower its velocity limit or allow it longer stops, stop_ms = {} in [robots.{robot}] of cell.toml",
        joint + 1,
        (time * 1e3).ceil()
    )]
    StopTime {
        /// The robot.
        robot: Name,
        /// The joint, counted from 0.
        joint: usize,
        /// The longest time that a stop may take \[s\].
        time: f64,
        /// The time allowed \[s\].
        limit: f64,
    },
    /// Code of a robot or of its driver panicked while the set-up was checked.
    #[error(
        "robot `{0}`: its code panicked while the cell was checked: {1}\n help: the line that panicked is printed above; `limits`, `joint`, \
         `forward` and `inverse` answer for all positions within the limits, `inverse` with an `Err` where there is no answer"
    )]
    Panicked(Name, String),
    /// More than one thing is wrong with the set-up.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<CellError>),
    /// A free-running sensor whose period takes no time.
    #[error("the period of the free-running sensor `{0}` is 0: give it 1 ms or more")]
    NoPeriod(Name),
    /// A configuration or a reading that is too long for a message.
    #[error("sensor `{0}`: its configuration may take 16 words and its reading 64")]
    TooLong(Name),
    /// The run cannot be recorded.
    #[error(transparent)]
    Recording(#[from] NotRecorded),
    /// The processes wait for each other.
    #[error(transparent)]
    Stuck(#[from] Stuck),
    /// The program ended with a fault: the first cause.
    #[error(transparent)]
    Fault(#[from] Fault),
}

impl CellError {
    /// The error of a lower cell.
    #[must_use]
    pub fn in_cell(self, cell: &str) -> CellError {
        CellError::InCell { cell: cell.to_owned(), error: Box::new(self) }
    }

    /// All that is wrong with a set-up as one error.
    pub fn all(mut errors: Vec<CellError>) -> Result<(), CellError> {
        match errors.pop() {
            None => Ok(()),
            Some(only) if errors.is_empty() => Err(only),
            Some(last) => {
                errors.push(last);
                Err(CellError::Several(errors))
            }
        }
    }
}
