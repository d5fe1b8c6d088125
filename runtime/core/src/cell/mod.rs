//! A cell: robots, virtual sensors and programs, put together and run.
//!
//! In: set-ups. Out: a run, or everything that is wrong with them before anything moves.

mod assembly;
mod error;
mod layout;
mod limits;
#[cfg(test)]
mod orphans;
mod picture;
pub mod realtime;
mod robot;
mod sensor;

use core::time::Duration;
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use crate::control::ecp::Ecp;
use crate::control::guard::{Guard, RobotView};
use crate::control::mp::{Mp, StepHook};
use crate::link::memory::{MAX_PROCESSES, Pulse, Scheduler};
use crate::link::watchdog::Watchdog;
use crate::model::fault::{Fault, FaultKind, ProcessId, Role};
use crate::model::name::Name;
use crate::operator::Operator;

use crate::control::replay::RecordedRun;
use crate::model::robot::Robot;
use crate::model::sensor::VirtualSensor;
use crate::observe::recording::{NotRecorded, Recorder, Recording, RunRecord};
use crate::observe::servo::Observation;
use crate::observe::witness::Witness;
use crate::safety::stopping::STOP_TIME;

use robot::SharedObserver;
use sensor::AnySensor;

pub use robot::AnyRobot;

pub use crate::control::plant::{Rest, Rests};
pub use crate::safety::latch::AfterFault;
pub use assembly::Assembly;
pub use error::CellError;
pub use picture::RunPicture;
pub use realtime::{Permission, Realtime};
pub use robot::RobotSetup;
pub use sensor::SensorSetup;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunReport {
    /// Steps.
    pub steps: u64,
    /// Time on the cell's clock.
    pub time: Duration,
}

type MpProgram = Box<dyn FnMut(&mut Mp) -> Result<(), Fault>>;
type Outcomes = Rc<RefCell<Vec<(ProcessId, Result<(), Fault>)>>>;

/// A set-up cell.
pub struct Cell {
    step: Duration,
    stop_time: Duration,
    after_fault: AfterFault,
    rate_change: f64,
    robots: Vec<Box<dyn AnyRobot>>,
    sensors: Vec<Box<dyn AnySensor>>,
    program: Option<MpProgram>,
    operator: Operator,
    hook: Option<StepHook>,
    guard: Option<Guard>,
    /// Sensors that the cell's file names.
    expected_sensors: Vec<String>,
    /// What its processes ask of the machine.
    realtime: Option<Realtime>,
    /// How long a process may compute on the memory link.
    watchdog: Option<Duration>,
    /// Who watches the run.
    witnesses: Vec<Rc<dyn Witness>>,
    /// What it is recorded to.
    recording: Option<Recording>,
    /// What writes it.
    recorder: Option<&'static dyn Recorder>,
    /// Whether a dry run comes before one in real time.
    dry_run: bool,
    /// Whether observers look at simulated drives where those are, and not in their EDPs.
    watched_in_plant: bool,
    /// What it replays.
    recorded: Option<Rc<RecordedRun>>,
    /// What was found wrong while the cell was put together.
    errors: Vec<CellError>,
}

impl Cell {
    /// A cell of this step, 1 ms, 2 ms ..
    #[must_use]
    pub fn new(step: Duration) -> Cell {
        Cell {
            step,
            stop_time: STOP_TIME,
            after_fault: AfterFault::End,
            rate_change: crate::safety::rate::DEFAULT_CHANGE,
            robots: Vec::new(),
            sensors: Vec::new(),
            program: None,
            operator: Operator::new(),
            hook: None,
            guard: None,
            expected_sensors: Vec::new(),
            realtime: None,
            watchdog: None,
            witnesses: Vec::new(),
            recording: None,
            recorder: None,
            dry_run: false,
            watched_in_plant: false,
            recorded: None,
            errors: Vec::new(),
        }
    }

    /// The longest time from the cause of a stop to a standstill that the cell allows any joint, 600 ms unless it says
    /// otherwise: time to notice a lost peer and to brake from the velocity limit, `v / a + 2.5 a / j`. A cell with
    /// a joint that would take longer does not run.
    #[must_use]
    pub fn stop_time(mut self, limit: Duration) -> Cell {
        self.stop_time = limit;
        self
    }

    /// What the cell does when a fault has stopped it: it ends, unless it is told to await a reset.
    #[must_use]
    pub fn after_fault(mut self, after_fault: AfterFault) -> Cell {
        self.after_fault = after_fault;
        self
    }

    /// Adds a robot.
    #[must_use]
    pub fn robot<R: Robot>(mut self, setup: RobotSetup<R>) -> Cell {
        self.robots.push(Box::new(setup));
        self
    }

    /// Gives the ECP of a robot that was added before its program. Without one an ECP is transparent: it passes the MP's
    /// demands on. It is called again after a [reset](AfterFault::AwaitReset).
    #[must_use]
    pub fn ecp<R: Robot>(
        mut self,
        robot: &str,
        program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static,
    ) -> Cell {
        let found = self.robots.iter_mut().find(|known| known.name() == robot);
        match found.map(|found| (found.kind_name(), found.as_any().downcast_mut::<RobotSetup<R>>())) {
            Some((_, Some(setup))) if setup.has_program() => {
                self.errors.push(CellError::TwoPrograms(robot.to_owned()));
            }
            Some((_, Some(setup))) => setup.give_program(program),
            Some((kind, None)) => {
                let robot = robot.to_owned();
                self.errors.push(CellError::OtherKind { robot, kind, written: R::KIND });
            }
            None => {
                let names = self.robots.iter().map(|robot| robot.name()).collect::<Vec<_>>().join(", ");
                self.errors.push(CellError::NoRobot(robot.to_owned(), names));
            }
        }
        self
    }

    /// Shows every servo period of every robot that was added before to `observer`.
    #[must_use]
    pub fn watch(mut self, observer: impl FnMut(&Observation<'_>) + 'static) -> Cell {
        let observer: SharedObserver = Rc::new(RefCell::new(observer));
        for robot in &mut self.robots {
            robot.watch(Rc::clone(&observer));
        }
        self
    }

    /// The same without the observers that it has.
    pub fn unobserved(mut self) -> Cell {
        self.robots.iter_mut().for_each(|robot| robot.unwatch());
        self
    }

    /// Lets observers look at simulated drives in the plant.
    pub const fn watched_in_plant(mut self) -> Cell {
        self.watched_in_plant = true;
        self
    }

    /// Adds a robot of any kind.
    pub fn push_robot(&mut self, robot: Box<dyn AnyRobot>) {
        self.robots.push(robot);
    }

    /// The cell does not run without these sensors.
    pub fn expect_sensors<'a>(mut self, names: impl Iterator<Item = &'a str>) -> Cell {
        self.expected_sensors.extend(names.map(str::to_owned));
        self
    }

    /// Adds a virtual sensor.
    #[must_use]
    pub fn sensor<V: VirtualSensor>(mut self, setup: SensorSetup<V>) -> Cell {
        self.sensors.push(Box::new(setup));
        self
    }

    /// The program of the MP. Without one the MP nudges: it starts every ECP's program and waits for all. It is called
    /// again, from its first line, after a [reset](AfterFault::AwaitReset): what it would give away it clones.
    #[must_use]
    pub fn program(mut self, program: impl FnMut(&mut Mp) -> Result<(), Fault> + 'static) -> Cell {
        self.program = Some(Box::new(program));
        self
    }

    /// Adds a hook to the one that there is.
    pub fn also_on_step(mut self, mut hook: impl FnMut(u64, &Operator) + 'static) -> Cell {
        let mut own = self.hook.take();
        self.on_step(move |step, operator| {
            if let Some(own) = &mut own {
                own(step, operator);
            }
            hook(step, operator);
        })
    }

    /// Calls `hook` at the start of every step with its index and the operator: for a progress bar, or an
    /// operator that acts in known steps.
    #[must_use]
    pub fn on_step(mut self, hook: impl FnMut(u64, &Operator) + 'static) -> Cell {
        self.hook = Some(Box::new(hook));
        self
    }

    /// Lets `watch` look at all robots every so many steps, at least 1, while programs Move and Wait; robots that the
    /// instruction does not name are asked, too. While robots look for their reference marks nothing is looked at. Its fault is a protective stop: the robots slow down on their paths with bounded deceleration, all
    /// together, and the cell stops with the fault at standstill. One guard a cell: the last one given.
    #[must_use]
    pub fn guard(
        mut self,
        every: u32,
        watch: impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static,
    ) -> Cell {
        self.guard = Some(Guard::new(every, watch));
        self
    }

    /// Ends the executable, with status 1 and the name of the process, when one process of the cell computes for longer than
    /// `patience` at a stretch on the memory link: there it has the only thread, and an endless loop in a step function can
    /// be met in no other way. Processes of the operating system need none of it.
    #[must_use]
    pub fn end_when_stuck(mut self, patience: Duration) -> Cell {
        self.watchdog = Some(patience);
        self
    }

    /// The operator's handle of this cell.
    #[must_use]
    pub fn operator(&self) -> Operator {
        self.operator.clone()
    }

    /// Its robots, for a trial to watch.
    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut (dyn AnyRobot + 'static)> {
        self.robots.iter_mut().map(|robot| &mut **robot)
    }

    /// The length of a step.
    pub const fn step_length(&self) -> Duration {
        self.step
    }

    /// Steps within which every robot must stand after a stop began.
    pub fn stop_steps(&self) -> u64 {
        let servos = self.robots.iter().map(|robot| robot.servo_period());
        let delay = crate::control::interpolation::delay(self.step, servos).unwrap_or_default();
        self.robots.iter().map(|robot| robot.stop_steps(self.step, delay)).max().unwrap_or(0)
    }

    /// Steps in which the rate falls from the planned one to a standstill.
    pub fn rate_steps(&self) -> u64 {
        // A float becomes the nearest integer that there is.
        (1.0 / (self.rate_change * self.step.as_secs_f64())).ceil() as u64
    }

    /// How long a stop of one of its robots may take.
    pub const fn stop_limit(&self) -> Duration {
        self.stop_time
    }

    /// What its processes ask of the machine.
    pub const fn realtime(&self) -> Option<&Realtime> {
        self.realtime.as_ref()
    }

    /// Asks the machine for priority and for memory that stays in its place when the cell runs as processes in real time,
    /// and runs without them where it does not permit that: `[realtime]` of a cell's file with `permission = "best effort"`,
    /// for a cell without a file.
    #[must_use]
    pub fn prefer_real_time(self) -> Cell {
        self.ask_for(Some(Realtime::PREFERRED))
    }

    /// Asks this of the machine for its processes.
    pub fn ask_for(mut self, realtime: Option<Realtime>) -> Cell {
        self.realtime = realtime;
        self
    }

    /// Records every step to a file: what robots are demanded and do, what sensors read, what the MP orders. The crate that
    /// records makes the [`Recording`].
    #[must_use]
    pub fn record(mut self, recording: Recording) -> Cell {
        self.recorder = recording.recorder().or(self.recorder);
        self.recording = Some(recording);
        self
    }

    /// Lets this recorder write what the cell is asked to record, where nothing else is said.
    #[must_use]
    pub fn recorded_by(mut self, recorder: &'static dyn Recorder) -> Cell {
        self.recorder.get_or_insert(recorder);
        self
    }

    /// Records to this file what it is asked to record, or everything.
    #[must_use]
    pub fn record_to(mut self, file: &Path) -> Cell {
        let asked = self.recording.take().unwrap_or_else(|| Recording::to(file));
        self.recording = Some(asked.with_file(file));
        self
    }

    /// Records nothing.
    pub fn unrecorded(mut self) -> Cell {
        self.recording = None;
        self
    }

    /// Lets no run in real time begin before a dry run has gone well.
    pub const fn demand_dry_run(mut self) -> Cell {
        self.dry_run = true;
        self
    }

    /// Whether a dry run comes before one in real time.
    pub const fn demands_dry_run(&self) -> bool {
        self.dry_run
    }

    /// What it is recorded to.
    pub const fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    /// What records it.
    pub fn recorder(&self) -> Option<&'static dyn Recorder> {
        self.recorder
    }

    /// Shows what happens in the cell's processes to a witness.
    pub fn witnessed_by(mut self, witness: Rc<dyn Witness>) -> Cell {
        self.witnesses.push(witness);
        self
    }

    /// Answers from a recording in place of drives, sensors and the operator. The recording is of this cell.
    pub fn replaying(mut self, recorded: Rc<RecordedRun>) -> Cell {
        let step = self.step;
        for robot in &mut self.robots {
            if let Some(robot_record) = recorded.robot(robot.name()) {
                robot.replay(Rc::clone(robot_record), step);
            }
        }
        self.recorded = Some(recorded);
        self
    }

    /// Runs the cell on the memory link, under the virtual clock, until the MP's program is over.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up, before anything moves; or the first cause of a stop.
    pub fn run(mut self) -> Result<RunReport, CellError> {
        let names = self.check()?;
        let record = self.begin_record()?;
        if let Some(record) = &record {
            self = self.witnessed_by(Rc::clone(record) as Rc<dyn Witness>);
        }
        let outcome = self.run_on_memory(&names);
        // Bodies that were given up keep theirs.
        record.iter().for_each(|record| record.finish());
        outcome
    }

    /// Begins the recording that it is asked for.
    fn begin_record(&self) -> Result<Option<Rc<dyn RunRecord>>, NotRecorded> {
        let Some(recording) = &self.recording else { return Ok(None) };
        let recorder = self.recorder.ok_or(NotRecorded::NoFeature)?;
        recorder.begin(recording, &self.layout()).map(Some)
    }

    /// Runs a cell in which nothing is wrong.
    pub fn run_on_memory(self, names: &[Name]) -> Result<RunReport, CellError> {
        let mut scheduler = Scheduler::new();
        let patience = self.watchdog;
        let assembly = self.assemble(names, &mut scheduler)?;
        let _watchdog = patience.map(|patience| {
            let pulse = Arc::<Pulse>::default();
            scheduler.show(Arc::clone(&pulse));
            Watchdog::new(scheduler.names(), pulse, patience)
        });
        let time = scheduler.run()?;
        first_cause(&assembly.outcomes.borrow())?;
        Ok(RunReport { steps: assembly.steps.get(), time: Duration::from_nanos(time) })
    }

    /// The robots' names, when nothing is wrong with the set-up.
    pub fn check(&mut self) -> Result<Vec<Name>, CellError> {
        if self.step.is_zero() {
            return Err(CellError::Step);
        }
        let (mut names, mut errors) = (Vec::new(), core::mem::take(&mut self.errors));
        let processes = 1 + 2 * self.robots.len() + self.sensors.len();
        if processes > MAX_PROCESSES {
            errors.push(CellError::TooMany { processes, limit: MAX_PROCESSES });
        }
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
            let (servo, step) = (robot.servo_period(), self.step);
            let divides = |a: Duration, b: Duration| b.as_nanos().is_multiple_of(a.as_nanos());
            if servo.is_zero() {
                errors.push(CellError::NoServo(name));
            } else if !divides(servo, step) && !divides(step, servo) {
                errors.push(CellError::Period { robot: name, servo, step });
            }
            errors.extend(robot.check_space(name));
            errors.extend(robot.check_limits(name, step, self.stop_time));
            names.push(name);
        }
        let mut sensors = Vec::new();
        for sensor in &self.sensors {
            match Name::new(sensor.name()) {
                Ok(name) => {
                    if sensors.contains(&name) {
                        errors.push(CellError::Twice(name));
                    }
                    errors.extend(sensor.check(name, &names));
                    sensors.push(name);
                }
                Err(bad) => errors.push(bad.into()),
            }
        }
        let without = |name: &&String| self.sensors.iter().all(|sensor| sensor.name() != name.as_str());
        errors.extend(self.expected_sensors.iter().filter(without).cloned().map(CellError::NoVsp));
        let layout = self.recording.as_ref().map(|_| self.layout());
        let unrecorded = self.recording.iter().zip(&layout).flat_map(|(asked, layout)| asked.check(layout));
        errors.extend(unrecorded.map(CellError::from));
        let misplaced =
            |error: &CellError| matches!(error, CellError::NoRobot(..) | CellError::OtherKind { .. });
        let has_program = self.program.is_some() || self.robots.iter().any(|robot| robot.has_program());
        if !has_program && !errors.iter().any(misplaced) {
            errors.push(CellError::NoProgram);
        }
        CellError::all(errors).map(|()| names)
    }
}

/// The MP's fault, or else the first of an ECP's.
pub fn first_cause(outcomes: &[(ProcessId, Result<(), Fault>)]) -> Result<(), Fault> {
    let mp = outcomes.iter().filter(|(process, _)| process.role == Role::Mp);
    let others = outcomes.iter().filter(|(process, _)| process.role != Role::Mp);
    for (process, outcome) in mp.chain(others) {
        if let Err(fault) = outcome {
            if fault.kind() == FaultKind::CellClosed {
                let text = "it waits for an instruction, but the MP's program is over: write `obey_all`, or let the MP order one more";
                return Err(Fault::thrown(text).in_process(*process));
            }
            return Err(fault.clone());
        }
    }
    Ok(())
}
