//! A cell: robots, virtual sensors and programs, put together and run.
//!
//! In: set-ups. Out: a run, or everything that is wrong with them before anything moves.
//!
//! Here are the functions that a user calls. A cell keeps what they are told in four parts: `parts` for robots and sensors, `timing`,
//! `coordination` for the MP and its operator, `watching` for those who look on; `running` runs the cell.

mod assembly;
mod coordination;
mod error;
mod layout;
mod limits;
mod parts;
mod picture;
pub mod realtime;
mod robot;
mod running;
mod sensor;
#[cfg(test)]
mod tests;
mod timing;
mod watching;

use core::time::Duration;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use std::rc::Rc;

use crate::control::ecp::Ecp;
use crate::control::guard::{Guard, RobotView};
use crate::control::mp::Mp;
use crate::control::replay::RecordedRun;
use crate::model::fault::Fault;
use crate::model::robot::Robot;
use crate::model::sensor::VirtualSensor;
use crate::observe::recording::{Recorder, Recording};
use crate::observe::servo::Observation;
use crate::observe::witness::Witness;
use crate::operator::Operator;
pub use crate::safety::limits::rates::PATH_SHARE;
use crate::safety::rate::{RateHeadroom, path_stop_time};
use crate::safety::stopping::path_stop_steps;

use coordination::Coordination;
use parts::Parts;
use robot::SharedObserver;
use timing::Timing;
use watching::Watching;

pub use crate::control::plant::{Rest, Rests};
pub use crate::safety::latch::AfterFault;
pub use assembly::{Assembly, Outcomes};
pub use error::CellError;
pub use picture::RunPicture;
pub use realtime::{Permission, Realtime};
pub use robot::{AnyRobot, RobotSetup};
pub use running::{RunReport, first_cause};
pub use sensor::SensorSetup;

/// A set-up cell.
pub struct Cell {
    parts: Parts,
    timing: Timing,
    coordination: Coordination,
    watching: Watching,
}

impl Cell {
    /// A cell of this step, 1 ms, 2 ms ..
    #[must_use]
    pub fn new(step: Duration) -> Cell {
        Cell {
            parts: Parts::default(),
            timing: Timing::of_step(step),
            coordination: Coordination::default(),
            watching: Watching::default(),
        }
    }

    /// The longest time from the cause of a stop to a standstill that the cell allows any joint, 600 ms unless it says
    /// otherwise: time to notice a lost peer and to brake from the velocity limit, `v / a + 2.5 a / j`. A cell with
    /// a joint that would take longer does not run.
    #[must_use]
    pub fn stop_time(mut self, limit: Duration) -> Cell {
        self.timing.stop_time = limit;
        self
    }

    /// What the cell does when a fault has stopped it: it ends, unless it is told to await a reset.
    #[must_use]
    pub fn after_fault(mut self, after_fault: AfterFault) -> Cell {
        self.coordination.after_fault = after_fault;
        self
    }

    /// Adds a robot.
    #[must_use]
    pub fn robot<R: Robot>(mut self, setup: RobotSetup<R>) -> Cell {
        self.parts.robots.push(Box::new(setup));
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
        self.parts.give_program::<R>(robot, program);
        self
    }

    /// Shows every servo period of every robot that was added before to `observer`.
    #[must_use]
    pub fn watch(mut self, observer: impl FnMut(&Observation<'_>) + 'static) -> Cell {
        let observer: SharedObserver = Rc::new(RefCell::new(observer));
        for robot in &mut self.parts.robots {
            robot.watch(Rc::clone(&observer));
        }
        self
    }

    /// The same without the observers that it has.
    pub fn unobserved(mut self) -> Cell {
        self.parts.robots.iter_mut().for_each(|robot| robot.unwatch());
        self
    }

    /// Lets observers look at simulated drives in the plant.
    pub const fn watched_in_plant(mut self) -> Cell {
        self.watching.watched_in_plant = true;
        self
    }

    /// Adds a robot of any kind.
    pub fn push_robot(&mut self, robot: Box<dyn AnyRobot>) {
        self.parts.robots.push(robot);
    }

    /// The cell does not run without these sensors.
    pub fn expect_sensors<'a>(mut self, names: impl Iterator<Item = &'a str>) -> Cell {
        self.parts.expected_sensors.extend(names.map(str::to_owned));
        self
    }

    /// Adds a virtual sensor.
    #[must_use]
    pub fn sensor<V: VirtualSensor>(mut self, setup: SensorSetup<V>) -> Cell {
        self.parts.sensors.push(Box::new(setup));
        self
    }

    /// The program of the MP. Without one the MP nudges: it starts every ECP's program and waits for all. It is called
    /// again, from its first line, after a [reset](AfterFault::AwaitReset): what it would give away it clones.
    #[must_use]
    pub fn program(mut self, program: impl FnMut(&mut Mp) -> Result<(), Fault> + 'static) -> Cell {
        self.coordination.program = Some(Box::new(program));
        self
    }

    /// Calls another hook at the start of every step, after the one that the cell has.
    pub fn also_on_step(mut self, mut hook: impl FnMut(u64, &Operator) + 'static) -> Cell {
        let mut own = self.coordination.hook.take();
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
        self.coordination.hook = Some(Box::new(hook));
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
        self.coordination.guard = Some(Guard::new(every, watch));
        self
    }

    /// Ends the executable, with status 1 and the name of the process, when one process of the cell computes for longer than
    /// `patience` at a stretch on the memory link: there it has the only thread, and an endless loop in a step function can
    /// be met in no other way. As processes of the operating system, in real time, the cell is ended when its MP begins no
    /// step for that long; a sixth of it is told. There it is 60 s unless this says otherwise.
    #[must_use]
    pub fn end_when_stuck(mut self, patience: Duration) -> Cell {
        self.timing.watchdog = Some(patience);
        self
    }

    /// How long one of its processes may compute at a stretch, if anything says so.
    pub const fn patience(&self) -> Option<Duration> {
        self.timing.watchdog
    }

    /// Lets simulated drives stand in for all that name [hardware](crate::robot::Driver::hardware), which is then neither
    /// opened nor asked for anything but its name and its period: so the cell runs under the virtual clock.
    /// [`layout`](Cell::layout) tells which robots have such stand-ins.
    ///
    /// # Errors
    /// [`CellError`] for each robot with real drives and [nothing to stand in](RobotSetup::stand_in) for them.
    pub fn simulated(mut self) -> Result<Cell, CellError> {
        self.parts.simulate().map(|()| self)
    }

    /// The operator's handle of this cell.
    #[must_use]
    pub fn operator(&self) -> Operator {
        self.coordination.operator.clone()
    }

    /// Its robots, for a trial to watch.
    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut (dyn AnyRobot + 'static)> {
        self.parts.robots.iter_mut().map(|robot| &mut **robot)
    }

    /// The hardware that its drivers name, each once.
    pub fn hardware(&self) -> Vec<String> {
        let names: BTreeSet<_> = self.parts.robots.iter().filter_map(|robot| robot.hardware()).collect();
        names.into_iter().collect()
    }

    /// The length of a step.
    pub const fn step_length(&self) -> Duration {
        self.timing.step
    }

    /// Steps within which every robot must stand after a stop began.
    pub fn stop_steps(&self) -> u64 {
        let delay = self.delay().unwrap_or_default();
        self.parts.robots.iter().map(|robot| robot.stop_steps(self.timing.step, delay)).max().unwrap_or(0)
    }

    /// The longest time that a stop on the path takes: a suspension, an abort. Robots at their velocity limits on paths that
    /// use nine tenths of their acceleration and jerk limits.
    pub fn path_stop_time(&self) -> Duration {
        let step = self.timing.step;
        let headroom = |rate: f64| {
            let robots = self.parts.robots.iter().map(|robot| robot.least_headroom(rate, step));
            robots.fold(RateHeadroom::UNLIMITED, RateHeadroom::and)
        };
        Duration::from_secs_f64(path_stop_time(self.timing.rate_change, step.as_secs_f64(), headroom))
    }

    /// How far drives are behind their demands; `None`: each takes every demand as it is.
    fn delay(&self) -> Option<Duration> {
        self.timing.delay(self.parts.robots.iter().map(|robot| robot.servo_period()))
    }

    /// Steps after which a protective stop leaves the path.
    fn path_stop_steps(&self) -> u64 {
        let delay = self.delay().unwrap_or_default();
        let braking = self.parts.robots.iter().map(|robot| robot.braking_time()).fold(0.0, f64::max);
        path_stop_steps(self.timing.stop_time, braking, self.timing.step, delay)
    }

    /// Steps in which the rate falls from the planned one to a standstill.
    pub fn rate_steps(&self) -> u64 {
        self.timing.rate_steps()
    }

    /// How long a stop of one of its robots may take.
    pub const fn stop_limit(&self) -> Duration {
        self.timing.stop_time
    }

    /// What its processes ask of the machine.
    pub const fn realtime(&self) -> Option<&Realtime> {
        self.timing.realtime.as_ref()
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
        self.timing.realtime = realtime;
        self
    }

    /// Records every step to a file: what robots are demanded and do, what sensors read, what the MP orders. The crate that
    /// records makes the [`Recording`].
    #[must_use]
    pub fn record(mut self, recording: Recording) -> Cell {
        self.watching.recorder = recording.recorder().or(self.watching.recorder);
        self.watching.recording = Some(recording);
        self
    }

    /// Lets this recorder write what the cell is asked to record, where nothing else is said.
    #[must_use]
    pub fn recorded_by(mut self, recorder: &'static dyn Recorder) -> Cell {
        self.watching.recorder.get_or_insert(recorder);
        self
    }

    /// Records to this file what it is asked to record, or everything.
    #[must_use]
    pub fn record_to(mut self, file: &Path) -> Cell {
        let asked = self.watching.recording.take().unwrap_or_else(|| Recording::to(file));
        self.watching.recording = Some(asked.with_file(file));
        self
    }

    /// Records nothing.
    pub fn unrecorded(mut self) -> Cell {
        self.watching.recording = None;
        self
    }

    /// Lets no run in real time begin before a dry run has gone well.
    pub const fn demand_dry_run(mut self) -> Cell {
        self.timing.dry_run = true;
        self
    }

    /// Whether a dry run comes before one in real time.
    pub const fn demands_dry_run(&self) -> bool {
        self.timing.dry_run
    }

    /// What it is recorded to.
    pub const fn recording(&self) -> Option<&Recording> {
        self.watching.recording.as_ref()
    }

    /// What records it.
    pub fn recorder(&self) -> Option<&'static dyn Recorder> {
        self.watching.recorder
    }

    /// Shows what happens in the cell's processes to a witness.
    pub fn witnessed_by(mut self, witness: Rc<dyn Witness>) -> Cell {
        self.watching.witnesses.push(witness);
        self
    }

    /// Answers from a recording in place of drives, sensors and the operator. The recording is of this cell.
    pub fn replaying(mut self, recorded: Rc<RecordedRun>) -> Cell {
        let step = self.timing.step;
        for robot in &mut self.parts.robots {
            if let Some(robot_record) = recorded.robot(robot.name()) {
                robot.replay(Rc::clone(robot_record), step);
            }
        }
        self.watching.recorded = Some(recorded);
        self
    }
}
