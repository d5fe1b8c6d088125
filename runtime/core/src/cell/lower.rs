//! Lower cells: cells that another one has as robots.
//!
//! In: a cell under a name. Out: what its processes are called on a link, `mp press`, `ecp press.arm`; how long its MP waits for
//! orders of the MP above, and that one for its robots to stand; and what forbids it to be one.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use crate::control::mp::Upper;
use crate::link::Server;
use crate::link::timeout::AnswerTimeout;
use crate::model::fault::{ProcessId, Role};
use crate::model::name::{BadName, Name};
use crate::model::time::Nanos;
use crate::observe::layout::{RobotLayout, SensorLayout};
use crate::observe::servo::Observation;

use super::robot::SharedObserver;
use super::{Cell, CellError};

/// A lower cell of a cell that is put together.
pub(super) struct LowerSetup {
    pub name: String,
    pub cell: Cell,
}

/// What is above a lower cell.
pub(super) struct Above {
    /// The name of the cell, those of the cells that it is in before it.
    pub name: Name,
    /// The port of its orders.
    pub port: Box<dyn Server>,
    /// Length of a step of the cell above.
    pub step: Duration,
}

impl Above {
    /// Its MP as the cell's own sees it.
    pub fn upper(self) -> Upper {
        Upper::new(self.port, ProcessId::new(Role::Mp, self.name), silence(self.step))
    }
}

/// For how long the MP of a lower cell waits for orders, in a cell above with this step \[ns\]: that one may wait for an answer of
/// another cell meanwhile.
pub(super) fn silence(step: Duration) -> Nanos {
    let AnswerTimeout { most, again } = AnswerTimeout::of_step(step);
    2 * most + again
}

/// The name that a process has on the link, whose cell may be a lower one.
pub(super) fn scoped(name: Name, within: Option<Name>) -> Result<Name, BadName> {
    within.map_or(Ok(name), |cell| name.within(cell))
}

/// A time of a lower cell in steps of the cell above, rounded up.
fn in_steps(time: Duration, step: Duration) -> u64 {
    u64::try_from(time.as_nanos().div_ceil(step.as_nanos().max(1))).unwrap_or(u64::MAX)
}

impl LowerSetup {
    /// Steps of the cell above within which all robots of this one stand that it has told to stop.
    pub fn stop_steps(&self, step: Duration) -> u64 {
        let own = self.cell.timing.step;
        // One for the order to be heard, one for the answer.
        let steps = u32::try_from(self.cell.stop_steps()).unwrap_or(u32::MAX);
        in_steps(own.saturating_mul(steps.saturating_add(2)), step)
    }

    /// Steps of the cell above after which a protective stop of this one leaves the path.
    pub fn path_stop_steps(&self, step: Duration) -> u64 {
        let steps = u32::try_from(self.cell.path_stop_steps()).unwrap_or(u32::MAX);
        let time = self.cell.timing.step.saturating_mul(steps);
        u64::try_from(time.as_nanos() / step.as_nanos().max(1)).unwrap_or(u64::MAX)
    }

    /// What is wrong with it.
    pub fn check(&mut self, errors: &mut Vec<CellError>) {
        let mut wrong = Vec::new();
        let cell = Name::new(&self.name);
        match (&cell, self.cell.check()) {
            (Ok(cell), Ok(robots)) => {
                let sensors =
                    self.cell.parts.sensors.iter().filter_map(|sensor| Name::new(sensor.name()).ok());
                let names = robots.into_iter().chain(sensors).map(|name| name.within(*cell));
                wrong.extend(names.filter_map(Result::err).map(CellError::from));
            }
            (Err(bad), _) => errors.push(bad.clone().into()),
            (Ok(_), Err(CellError::Several(several))) => wrong.extend(several),
            (Ok(_), Err(error)) => wrong.push(error),
        }
        if self.cell.coordination.program.is_none() && !wrong.contains(&CellError::NoProgram) {
            wrong.push(CellError::NoObedience);
        }
        if self.cell.watching.recording.is_some() {
            wrong.push(CellError::RecordedInCell);
        }
        errors.extend(wrong.into_iter().map(|error: CellError| error.in_cell(&self.name)));
    }
}

impl Cell {
    /// Adds a cell as **one robot of this one**: the MP of that cell [serves](crate::program::Mp::serve) the orders of this cell's
    /// MP, for which it is a robot of the kind [`LowerCell`](super::LowerCell). A lower cell may have lower cells itself, and a step
    /// of its own.
    ///
    /// All are one run: it is over when the program of the uppermost MP is. Each cell keeps its own operator, guard, limits and
    /// latch; ask a cell for its [`operator`](Cell::operator) before it is added. In messages its processes have its name before
    /// theirs: `mp press`, `ecp press.arm`.
    ///
    /// ```
    /// use std::time::Duration;
    ///
    /// use mrroc::cell::LowerCell;
    /// use mrroc::prelude::*;
    ///
    /// #[derive(Clone, Copy, Payload)]
    /// enum Job {
    ///     Rest,
    /// }
    ///
    /// #[generator(mp)]
    /// fn rest() -> Always<(LowerCell,), Job> {
    ///     Always((Job::Rest,))
    /// }
    ///
    /// let press = Cell::new(Duration::from_millis(1)).program(|mp| mp.serve_all(|_, _: Job| Ok(())));
    /// Cell::new(Duration::from_millis(2))
    ///     .cell("press", press)
    ///     .program(|mp| {
    ///         let mut press = mp.robot::<LowerCell>("press")?;
    ///         mp.move_robots((&mut press,), (), rest {}).map(drop)
    ///     })
    ///     .run()?;
    /// # Ok::<(), CellError>(())
    /// ```
    #[must_use]
    pub fn cell(mut self, name: &str, cell: Cell) -> Cell {
        self.parts.cells.push(LowerSetup { name: name.to_owned(), cell });
        self
    }

    /// Shows `observer` all robots that were added so far, those of its lower cells by their names in this one.
    pub(super) fn watch_all(&mut self, observer: &SharedObserver) {
        for robot in &mut self.parts.robots {
            robot.watch(Rc::clone(observer), self.coordination.activity.clone());
        }
        for lower in &mut self.parts.cells {
            let observer = Rc::clone(observer);
            // The names are known after the first servo period.
            let (cell, mut names) = (lower.name.clone(), Vec::<(String, String)>::new());
            let named = move |seen: &Observation<'_>| {
                let known = names.iter().position(|(name, _)| name == seen.robot);
                let known = known.unwrap_or_else(|| {
                    names.push((seen.robot.to_owned(), format!("{cell}.{}", seen.robot)));
                    names.len() - 1
                });
                let on = names.iter().find(|(name, _)| Some(name.as_str()) == seen.mounted_on);
                let mounted_on = on.map(|(_, name)| name.as_str());
                let robot = names.get(known).map_or(seen.robot, |(_, name)| name);
                (*observer.borrow_mut())(&Observation { robot, mounted_on, ..*seen });
            };
            lower.cell.watch_all(&(Rc::new(RefCell::new(named)) as SharedObserver));
        }
    }

    /// Its lower cells and theirs, by their names in this one, with the length of their steps.
    pub(super) fn lower_cells(&self) -> impl Iterator<Item = (String, Duration)> + '_ {
        self.parts.cells.iter().flat_map(|lower| {
            let below = lower.cell.layout().cells.into_iter();
            let below = below.map(|(name, step)| (format!("{}.{name}", lower.name), step));
            core::iter::once((lower.name.clone(), lower.cell.timing.step)).chain(below)
        })
    }

    /// The robots of its lower cells, by their names in this one.
    pub(super) fn lower_robots(&self) -> impl Iterator<Item = RobotLayout> + '_ {
        self.parts.cells.iter().flat_map(|lower| {
            let within = |name: &str| format!("{}.{name}", lower.name);
            lower.cell.layout().robots.into_iter().map(move |mut robot| {
                robot.name = within(&robot.name);
                robot.mounted_on = robot.mounted_on.as_deref().map(within);
                robot
            })
        })
    }

    /// Their sensors.
    pub(super) fn lower_sensors(&self) -> impl Iterator<Item = SensorLayout> + '_ {
        self.parts.cells.iter().flat_map(|lower| {
            let within = |name: &str| format!("{}.{name}", lower.name);
            lower.cell.layout().sensors.into_iter().map(move |mut sensor| {
                sensor.name = within(&sensor.name);
                sensor.of = sensor.of.as_deref().map(within);
                sensor.readers = sensor.readers.iter().map(|reader| within(reader)).collect();
                sensor
            })
        })
    }
}
