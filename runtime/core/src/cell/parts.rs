//! The robots and virtual sensors of a cell.
//!
//! In: set-ups, programs of ECPs. Out: everything that is wrong with them, or the robots' names.

use core::any::Any;
use core::time::Duration;

use crate::console::quoted;
use crate::control::ecp::Ecp;
use crate::control::guarded::guarded;
use crate::link::places::MAX_PROCESSES;
use crate::model::fault::Fault;
use crate::model::name::Name;
use crate::model::named::CellNames;
use crate::model::pace::{Pace, ServoPeriod};
use crate::model::robot::Robot;
use crate::safety::stopping::noticing_time;
use crate::suggestion::suggestion;

use super::CellError;
use super::lower::LowerSetup;
use super::robot::{AnyRobot, RobotSetup};
use super::sensor::CellSensor;
use super::timing::Timing;

/// What a cell is made of.
#[derive(Default)]
pub(super) struct Parts {
    pub robots: Vec<Box<dyn AnyRobot>>,
    pub sensors: Vec<CellSensor>,
    /// Cells that are robots of this one.
    pub cells: Vec<LowerSetup>,
    /// Its frames and tools.
    pub named: CellNames,
    /// Sensors that the cell's file names.
    pub expected_sensors: Vec<String>,
    /// Lower cells that it names.
    pub expected_cells: Vec<String>,
    /// What was found wrong while the cell was put together.
    pub errors: Vec<CellError>,
}

impl Parts {
    /// Gives the ECP of a robot its program; what forbids that is kept as an error.
    pub fn give_program<R: Robot>(
        &mut self,
        robot: &str,
        program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static,
    ) {
        let Some(found) = self.robots.iter_mut().find(|known| known.name() == robot) else {
            let names = self.robots.iter().map(|robot| robot.name()).collect::<Vec<_>>().join(", ");
            self.errors.push(CellError::NoRobot(robot.to_owned(), names));
            return;
        };
        let kind = found.kind_name();
        let error = match (&mut **found as &mut dyn Any).downcast_mut::<RobotSetup<R>>() {
            Some(setup) if setup.has_program() => CellError::TwoPrograms(robot.to_owned()),
            Some(setup) => return setup.give_program(program),
            None => CellError::OtherKind { robot: robot.to_owned(), kind, written: R::KIND },
        };
        self.errors.push(error);
    }

    /// Checks the number of processes, the plant's among them: a cell may have as many on every link. All errors are kept in
    /// `errors`.
    pub fn check_size(&mut self, errors: &mut Vec<CellError>) {
        let processes = self.processes() + usize::from(self.is_simulated());
        if processes > MAX_PROCESSES {
            errors.push(CellError::TooMany { processes, limit: MAX_PROCESSES });
        }
    }

    /// How many processes it has without the plant, those of its lower cells among them.
    fn processes(&self) -> usize {
        let of_cells: usize = self.cells.iter().map(|lower| lower.cell.parts.processes()).sum();
        1 + 2 * self.robots.len() + self.sensors.len() + of_cells
    }

    /// Whether any robot is simulated, those of its lower cells among them.
    pub fn is_simulated(&mut self) -> bool {
        let of_cells = |lower: &mut LowerSetup| lower.cell.parts.is_simulated();
        self.robots.iter_mut().any(|robot| robot.is_simulated()) || self.cells.iter_mut().any(of_cells)
    }

    /// Takes the observers of all robots away.
    pub fn unwatch(&mut self) {
        self.robots.iter_mut().for_each(|robot| robot.unwatch());
        self.cells.iter_mut().for_each(|lower| lower.cell.parts.unwatch());
    }

    /// Checks the lower cells, and that each has a name of its own among these robots.
    pub fn check_cells(&mut self, robots: &[Name], errors: &mut Vec<CellError>) {
        let mut names = robots.to_vec();
        for lower in &mut self.cells {
            lower.check(errors);
            if let Ok(name) = Name::new(&lower.name) {
                if names.contains(&name) {
                    errors.push(CellError::Twice(name));
                }
                names.push(name);
            }
        }
        let without = |name: &&String| self.cells.iter().all(|lower| lower.name != **name);
        errors.extend(self.expected_cells.iter().filter(without).cloned().map(CellError::NoLowerCell));
    }

    /// Checks the robots; the names of those whose name is one.
    pub fn check_robots(&self, timing: &Timing, errors: &mut Vec<CellError>) -> Vec<Name> {
        let mut names = Vec::new();
        for robot in &self.robots {
            let name = match Name::new(robot.name()) {
                Ok(name) => name,
                Err(bad) => {
                    errors.push(bad.into());
                    continue;
                }
            };
            if names.contains(&name) {
                errors.push(CellError::Twice(name));
            }
            // The model and the driver are the user's code.
            match guarded(|| check_robot(&**robot, name, timing, self.noticing_time(timing))) {
                Ok(found) => errors.extend(found),
                Err(panic) => errors.push(CellError::Panicked(name, quoted(panic.message(), 120))),
            }
            names.push(name);
        }
        self.check_mountings(&names, errors);
        names
    }

    /// How long it takes until robots begin to stop for what is lost \[s\].
    pub fn noticing_time(&self, timing: &Timing) -> f64 {
        let silence = |robot: &dyn AnyRobot| match robot.servo_period().pace {
            Pace::Cell => Duration::ZERO,
            Pace::Robot { timeout } => timeout,
        };
        let silences = self.robots.iter().map(|robot| silence(&**robot));
        noticing_time(timing.step, silences.max().unwrap_or_default())
    }

    /// Checks that robots are mounted on robots of the cell, and none on itself, not even through others.
    fn check_mountings(&self, names: &[Name], errors: &mut Vec<CellError>) {
        let carrier = |name: &str| self.robots.iter().find(|robot| robot.name() == name)?.mounted_on();
        for &robot in names {
            let Some(on) = carrier(robot.as_str()) else { continue };
            if !names.iter().any(|name| name.as_str() == on) {
                let names: Vec<_> = names.iter().map(Name::as_str).collect();
                let there = suggestion(on, &names, "the cell has");
                errors.push(CellError::NoCarrier { robot, on: on.to_owned(), there });
                continue;
            }
            let chain = core::iter::successors(Some(on), |on| carrier(on)).take(names.len());
            if chain.into_iter().any(|on| on == robot.as_str()) {
                errors.push(CellError::MountedOnItself { robot, on: on.to_owned() });
            }
        }
    }

    /// Refuses drives and sensors that cannot follow the virtual clock. A replay opens no sensor.
    ///
    /// # Errors
    /// [`CellError::RealDrives`] for the first robot that has such, [`CellError::RealSensor`] for the first sensor.
    pub fn refuse_hardware(&self, names: &[Name], replays: bool) -> Result<(), CellError> {
        let mut robots = self.robots.iter().zip(names).filter(|(robot, _)| !robot.is_in_simulator());
        let real = robots.find_map(|(robot, &name)| Some((name, robot.hardware()?)));
        if let Some((robot, hardware)) = real {
            return Err(CellError::RealDrives { robot, hardware });
        }
        let mut opened = self.sensors.iter().filter(|_| !replays);
        match opened.find_map(|sensor| Some((sensor.name(), sensor.hardware()?))) {
            Some((sensor, hardware)) => Err(CellError::RealSensor { sensor: Name::new(sensor)?, hardware }),
            None => Ok(()),
        }
    }

    /// Lets simulated drives and sensors stand in for real ones.
    ///
    /// # Errors
    /// Why there are none for some robots and sensors.
    pub fn simulate(&mut self) -> Result<(), CellError> {
        let robots = self.robots.iter_mut().filter(|robot| robot.hardware().is_some());
        let refused = robots.filter_map(|robot| {
            let name = Name::new(robot.name()).map_err(CellError::from);
            name.and_then(|name| robot.simulate(name)).err()
        });
        let mut refused: Vec<_> = refused.collect();
        for sensor in core::mem::take(&mut self.sensors) {
            match sensor.simulated() {
                Ok(sensor) => self.sensors.push(sensor),
                Err(error) => refused.push(error),
            }
        }
        for lower in &mut self.cells {
            if let Err(error) = lower.cell.parts.simulate() {
                refused.push(error.in_cell(&lower.name));
            }
        }
        CellError::all(refused)
    }

    /// Checks the sensors of robots with these names.
    pub fn check_sensors(&self, robots: &[Name], step: Duration, errors: &mut Vec<CellError>) {
        let mut sensors = Vec::new();
        for sensor in &self.sensors {
            match Name::new(sensor.name()) {
                Ok(name) => {
                    if sensors.contains(&name) {
                        errors.push(CellError::Twice(name));
                    }
                    errors.extend(sensor.check(name, robots, step));
                    sensors.push(name);
                }
                Err(bad) => errors.push(bad.into()),
            }
        }
        let without = |name: &&String| self.sensors.iter().all(|sensor| sensor.name() != name.as_str());
        errors.extend(self.expected_sensors.iter().filter(without).cloned().map(CellError::NoVsp));
    }

    /// Checks the frames and tools.
    pub fn check_named(&self, errors: &mut Vec<CellError>) {
        let frames: Vec<_> = self.named.frames.iter().map(|(name, _)| &**name).collect();
        let tools: Vec<_> = self.named.tools.iter().map(|(name, _)| &**name).collect();
        for (what, names) in [("frame", frames), ("tool", tools)] {
            for (i, name) in names.iter().enumerate() {
                if let Err(bad) = Name::new(name) {
                    errors.push(bad.into());
                }
                if names[..i].contains(name) {
                    errors.push(CellError::TwoNamed { what, name: (*name).to_owned() });
                }
            }
        }
        for (name, tool) in &self.named.tools {
            if let Some(wrong) = tool.load.fault() {
                errors.push(CellError::ToolLoad { name: name.clone(), wrong });
            }
        }
    }

    /// Whether an ECP has a program.
    pub fn has_program(&self) -> bool {
        self.robots.iter().any(|robot| robot.has_program())
    }
}

/// What is wrong with the set-up of one robot.
fn check_robot(robot: &dyn AnyRobot, name: Name, timing: &Timing, noticing: f64) -> Vec<CellError> {
    let mut errors = Vec::new();
    let step = timing.step;
    let ServoPeriod { length: servo, pace } = robot.servo_period();
    let divides = |a: Duration, b: Duration| b.as_nanos().is_multiple_of(a.as_nanos());
    if servo.is_zero() {
        errors.push(CellError::NoServo(name));
    } else if pace == Pace::Cell && !divides(servo, step) && !divides(step, servo) {
        errors.push(CellError::Period { robot: name, servo, step });
    }
    errors.extend(robot.check_space(name));
    errors.extend(robot.check_signals(name));
    errors.extend(robot.check_limits(name, noticing, robot.stop_time(timing.stop_time)));
    errors
}
