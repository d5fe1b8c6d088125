//! A cell: robots, virtual sensors and programs, put together and run.
//!
//! In: set-ups. Out: a run; or all mistakes in the set-ups, before anything moves.
//!
//! This file has the functions that a user calls. A cell keeps their arguments in four parts: `parts` for robots and
//! sensors, `timing`, `coordination` for the MP and its operator, `watching` for observers and recordings; `running`
//! runs the cell.

mod assembly;
mod coordination;
mod error;
mod layout;
mod limits;
mod lower;
mod nodes;
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
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::control::ecp::Ecp;
use crate::control::guard::{Guard, RobotView};
use crate::control::mp::Mp;
use crate::control::plant::Body;
use crate::control::replay::RecordedRun;
use crate::model::fault::{Fault, ProcessId};
use crate::model::load::Tool;
use crate::model::name::Name;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::sensor::VirtualSensor;
use crate::model::time::Clock;
use crate::observe::layout::BodyLayout;
use crate::observe::recording::{Recorder, Recording, RunRecord};
use crate::observe::servo::Observation;
use crate::observe::solid::{ObstacleLayout, Solid};
use crate::observe::step_observer::{SharedStepObserver, StepObserver};
use crate::observe::subscription::Subscription;
use crate::operator::Operator;
pub use crate::safety::limits::rates::PATH_SHARE;
use crate::safety::rate::{RateMargin, path_stop_time};
use crate::safety::stopping::path_stop_steps;

use coordination::Coordination;
use parts::Parts;
use robot::SharedObserver;
use timing::Timing;
use watching::Watching;

pub use crate::control::plant::{Rest, Rests};
pub use crate::model::lower_cell::{CellStatus, LowerCell};
pub use crate::safety::latch::AfterFault;
pub use assembly::Assembly;
pub use error::CellError;
pub use nodes::{Node, Nodes};
pub use picture::RunPicture;
pub use realtime::{Permission, Realtime};
pub use robot::signals::{InputSetup, OutputSetup, WrongSignal};
pub use robot::{AnyRobot, NoSimulator, Outcomes, RobotSetup};
pub use running::{RunReport, first_cause};
pub use sensor::SensorSetup;

/// A set-up cell.
pub struct Cell {
    parts: Parts,
    timing: Timing,
    coordination: Coordination,
    watching: Watching,
    nodes: Option<Nodes>,
}

impl Cell {
    /// A cell with steps of this length: 1 ms, 2 ms ..
    #[must_use]
    pub fn new(step: Duration) -> Cell {
        Cell {
            parts: Parts::default(),
            timing: Timing::of_step(step),
            coordination: Coordination::default(),
            watching: Watching::default(),
            nodes: None,
        }
    }

    /// Spreads the processes of the cell over several machines, when it runs as processes in real time.
    #[must_use]
    pub fn on_nodes(mut self, nodes: Nodes) -> Cell {
        self.nodes = Some(nodes);
        self
    }

    /// The machines of the cell; `None` if it is on one.
    #[must_use]
    pub const fn nodes(&self) -> Option<&Nodes> {
        self.nodes.as_ref()
    }

    /// Sets the longest time that the cell allows any joint from the cause of a stop to a standstill; 600 ms by
    /// default. A joint needs the time to notice a lost peer and to brake from the velocity limit, `v / a + 2.5 a / j`.
    /// A cell with a joint that would take longer does not run. A robot may have
    /// [a time of its own](RobotSetup::stop_time).
    #[must_use]
    pub fn stop_time(mut self, limit: Duration) -> Cell {
        self.timing.stop_time = limit;
        self
    }

    /// Sets what the cell does after a fault has stopped it. By default it ends; it may also await a reset.
    #[must_use]
    pub fn after_fault(mut self, after_fault: AfterFault) -> Cell {
        self.coordination.after_fault = after_fault;
        self
    }

    /// Whether it awaits a reset after a fault.
    pub fn awaits_reset(&self) -> bool {
        self.coordination.after_fault == AfterFault::AwaitReset
    }

    /// The lower cells that await a reset of their own after a fault, and theirs, by their names in this cell.
    pub fn cells_that_await_reset(&self) -> Vec<Name> {
        let mut found = Vec::new();
        for lower in &self.parts.cells {
            let Ok(name) = Name::new(&lower.name) else { continue };
            found.extend(lower.cell.awaits_reset().then_some(name));
            found.extend(
                lower.cell.cells_that_await_reset().into_iter().filter_map(|own| own.within(name).ok()),
            );
        }
        found
    }

    /// Adds a robot.
    #[must_use]
    pub fn robot<R: Robot>(mut self, setup: RobotSetup<R>) -> Cell {
        self.parts.robots.push(Box::new(setup));
        self
    }

    /// Names a frame in the world, such as a table or a fixture: `X_WU` \[m\]. Programs ask for it by [`Mp::frame`] and
    /// [`Ecp::frame`].
    #[must_use]
    #[allow(non_snake_case)]
    pub fn frame(mut self, name: &str, X_WU: Pose) -> Cell {
        self.parts.named.frames.push((name.to_owned(), X_WU));
        self
    }

    /// Names a tool: where its tip is on the flange, and what the flange carries with it. Programs ask for it by [`Mp::tool`]
    /// and [`Ecp::tool`].
    #[must_use]
    pub fn tool(mut self, name: &str, tool: Tool) -> Cell {
        self.parts.named.tools.push((name.to_owned(), tool));
        self
    }

    /// Gives the ECP of a robot its program; add the robot first. Without a program an ECP is transparent: it passes
    /// the MP's demands on. The program is called again after a [reset](AfterFault::AwaitReset).
    #[must_use]
    pub fn ecp<R: Robot>(
        mut self,
        robot: &str,
        program: impl FnMut(&mut Ecp<R>) -> Result<(), Fault> + 'static,
    ) -> Cell {
        self.parts.give_program::<R>(robot, program);
        self
    }

    /// Shows `observer` every servo period of all robots that were added so far.
    #[must_use]
    pub fn watch(mut self, observer: impl FnMut(&Observation<'_>) + 'static) -> Cell {
        let observer: SharedObserver = Rc::new(RefCell::new(observer));
        self.watch_all(&observer);
        self
    }

    /// Shows recordings a body that the robots handle, as a block of these edges along x, y, z \[m\] about its frame. `pose`
    /// tells where that frame is, `X_WB`; it is called some tens of times a second, where the simulated drives are: in their
    /// process, when the cell runs as processes. The name, of 1 to 24 of the characters `a-z A-Z 0-9 _ -`, is one that no
    /// robot has.
    #[must_use]
    pub fn shows_body(mut self, name: &str, edges: [f64; 3], pose: impl FnMut() -> Pose + 'static) -> Cell {
        match Name::new(name) {
            Ok(known) => {
                let layout = BodyLayout { name: name.to_owned(), edges };
                self.watching.bodies.push((layout, Body { name: known, pose: Box::new(pose) }));
            }
            Err(bad) => self.parts.errors.push(bad.into()),
        }
        self
    }

    /// Shows pictures, recordings and the panel a solid that stands in the cell, with its frame at `X_WO` \[m\] in the world. The
    /// obstacles of a cell file are shown already. Robots are kept away from it by a clearance, not by this.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn shows_obstacle(mut self, name: &str, X_WO: Pose, solid: Solid) -> Cell {
        let is_same = |other: &ObstacleLayout| other.name == name;
        match Name::new(name) {
            Ok(_) if self.watching.obstacles.iter().any(is_same) => {
                self.parts.errors.push(CellError::TwoNamed { what: "obstacle", name: name.to_owned() });
            }
            Ok(_) => {
                let layout = ObstacleLayout { name: name.to_owned(), pose: X_WO, solid };
                self.watching.obstacles.push(layout);
            }
            Err(bad) => self.parts.errors.push(bad.into()),
        }
        self
    }

    /// Removes the observers of all robots.
    pub fn unobserved(mut self) -> Cell {
        self.parts.unwatch();
        self
    }

    /// Lets observers look at simulated drives in the plant instead of in their EDPs.
    pub fn watched_in_plant(mut self) -> Cell {
        self.parts.cells.iter_mut().for_each(|lower| lower.cell.watching.watched_in_plant = true);
        self.watching.watched_in_plant = true;
        self
    }

    /// Adds a robot of any kind.
    pub fn push_robot(&mut self, robot: Box<dyn AnyRobot>) {
        self.parts.robots.push(robot);
    }

    /// Names sensors without which the cell does not run.
    pub fn expect_sensors<'a>(mut self, names: impl Iterator<Item = &'a str>) -> Cell {
        self.parts.expected_sensors.extend(names.map(str::to_owned));
        self
    }

    /// Names lower cells without which the cell does not run.
    pub fn expect_cells<'a>(mut self, names: impl Iterator<Item = &'a str>) -> Cell {
        self.parts.expected_cells.extend(names.map(str::to_owned));
        self
    }

    /// Adds a virtual sensor.
    #[must_use]
    pub fn sensor<V: VirtualSensor>(mut self, setup: SensorSetup<V>) -> Cell {
        self.parts.sensors.push(setup.into());
        self
    }

    /// Gives the MP its program. Without one the MP starts every ECP's program and waits for all of them. The program
    /// is called again, from its first line, after a [reset](AfterFault::AwaitReset); so it must clone what it would
    /// otherwise move out of itself.
    #[must_use]
    pub fn program(mut self, program: impl FnMut(&mut Mp) -> Result<(), Fault> + 'static) -> Cell {
        self.coordination.program = Some(Box::new(program));
        self
    }

    /// Calls another hook at the start of every step, after the hook that the cell has already.
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

    /// Sets the guard: while programs Move and Wait, `watch` is called with the states of all robots once in `every`
    /// steps, at least 1. Robots that the instruction does not name are included. While robots look for their reference
    /// marks, the guard is not called. If it returns a fault, that is a protective stop: all robots slow down on their
    /// paths together, with bounded deceleration, and the cell stops with the fault at standstill. A cell has one
    /// guard, the last one that was set.
    #[must_use]
    pub fn guard(
        mut self,
        every: u32,
        watch: impl FnMut(&[RobotView]) -> Result<(), Fault> + 'static,
    ) -> Cell {
        self.coordination.guard = Some(Guard::new(every, watch));
        self
    }

    /// Ends a cell that is stuck. On the memory link the executable ends, with status 1 and the name of the process,
    /// when a process of the cell computes for longer than `timeout` at a stretch: all processes share one thread
    /// there, so an endless loop in a step function cannot be ended by any other means. When the processes are those of
    /// the operating system, in real time, the cell is ended when its MP begins no step for `timeout`, 60 s by
    /// default; a message says so after a sixth of it.
    #[must_use]
    pub fn end_when_stuck(mut self, timeout: Duration) -> Cell {
        self.timing.watchdog = Some(timeout);
        self
    }

    /// How long one of its processes may compute at a stretch, if that was set.
    pub const fn watchdog_timeout(&self) -> Option<Duration> {
        self.timing.watchdog
    }

    /// Lets simulated drives stand in for all that name [hardware](crate::robot::Driver::hardware), which is then neither
    /// opened nor asked for anything but its name and its period: so the cell runs under the virtual clock.
    /// [`layout`](Cell::layout) tells which robots have such stand-ins.
    ///
    /// # Errors
    /// [`CellError`] for each robot with real drives and [nothing to stand in](RobotSetup::stand_in) for them, and for each sensor
    /// with [hardware](crate::sensor::VirtualSensor::hardware) and [nothing to stand in](SensorSetup::stand_in) for it.
    pub fn simulated(mut self) -> Result<Cell, CellError> {
        self.parts.simulate().map(|()| self)
    }

    /// The operator's handle of this cell.
    #[must_use]
    pub fn operator(&self) -> Operator {
        self.coordination.operator.clone()
    }

    /// Whether any robot is simulated, those of its lower cells among them.
    pub fn is_simulated(&mut self) -> bool {
        self.parts.is_simulated()
    }

    /// Its robots, for a trial to watch.
    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut (dyn AnyRobot + 'static)> {
        self.parts.robots.iter_mut().map(|robot| &mut **robot)
    }

    /// The hardware that its drivers and sensors name, each once.
    pub fn hardware(&self) -> Vec<String> {
        let of_robots = self.parts.robots.iter().filter_map(|robot| robot.hardware());
        let of_sensors = self.parts.sensors.iter().filter_map(|sensor| sensor.hardware());
        let of_cells = self.parts.cells.iter().flat_map(|lower| lower.cell.hardware());
        let names: BTreeSet<_> = of_robots.chain(of_sensors).chain(of_cells).collect();
        names.into_iter().collect()
    }

    /// The Python module by which a program of another sends what the sensor of this name reads
    /// ([`VirtualSensor::python`]), simulates the robot of this name ([`Driver::python`](crate::robot::Driver::python)), or subscribes
    /// by this name ([`Subscription::python`]); `None` if no program does, or there is none of the three.
    #[must_use]
    pub fn python(&self, name: &str) -> Option<String> {
        let mut subscriptions =
            self.watching.subscriptions.iter().filter(|subscription| subscription.name() == name);
        let mut sensors = self.parts.sensors.iter().filter(|sensor| sensor.name() == name);
        let mut robots = self.parts.robots.iter().filter(|robot| robot.name() == name);
        sensors
            .find_map(|sensor| sensor.python())
            .or_else(|| robots.find_map(|robot| robot.python()))
            .or_else(|| {
                subscriptions
                    .next()
                    .map(|subscription| subscription.python(&self.layout().without_lower_cells()))
            })
    }

    /// The length of a step.
    pub const fn step_length(&self) -> Duration {
        self.timing.step
    }

    /// Steps within which every robot must stand after a stop began.
    pub fn stop_steps(&self) -> u64 {
        let (step, delay) = (self.timing.step, self.delay().unwrap_or_default());
        let of_robots = self.parts.robots.iter().map(|robot| robot.stop_steps(step, delay));
        let of_cells = self.parts.cells.iter().map(|lower| lower.stop_steps(step));
        of_robots.chain(of_cells).max().unwrap_or(0)
    }

    /// The longest time that a stop on the path, a suspension or an abort, takes: that of robots at their velocity
    /// limits, on paths that use nine tenths of their acceleration and jerk limits. Those of a lower cell follow the rate of
    /// this one by a rate of their own.
    pub fn path_stop_time(&self) -> Duration {
        let step = self.timing.step;
        let margin = |rate: f64| {
            let robots = self.parts.robots.iter().map(|robot| robot.least_margin(rate, step));
            robots.fold(RateMargin::UNLIMITED, RateMargin::and)
        };
        let own =
            Duration::from_secs_f64(path_stop_time(self.timing.rate_change, step.as_secs_f64(), margin));
        let of_cells = self.parts.cells.iter().map(|lower| lower.cell.path_stop_time());
        own + of_cells.max().unwrap_or_default()
    }

    /// The delay of the drives behind their demands; `None` if each drive takes every demand as it is.
    fn delay(&self) -> Option<Duration> {
        self.timing.delay(self.parts.robots.iter().map(|robot| robot.servo_period()))
    }

    /// Steps after which a protective stop leaves the path.
    fn path_stop_steps(&self) -> u64 {
        let delay = self.delay().unwrap_or_default();
        let steps = self.parts.robots.iter().map(|robot| {
            let stop_time = robot.stop_time(self.timing.stop_time);
            path_stop_steps(stop_time, robot.braking_time(), self.timing.step, delay)
        });
        let of_cells = self.parts.cells.iter().map(|lower| lower.path_stop_steps(self.timing.step));
        steps.chain(of_cells).min().unwrap_or(0)
    }

    /// The number of steps in which the rate of path time falls from the planned one to 0.
    pub fn rate_steps(&self) -> u64 {
        self.timing.rate_steps()
    }

    /// The longest stop that the cell allows its robots.
    pub fn stop_limit(&self) -> Duration {
        let cell = self.timing.stop_time;
        self.parts.robots.iter().map(|robot| robot.stop_time(cell)).max().unwrap_or(cell)
    }

    /// What its processes ask of the machine.
    pub const fn realtime(&self) -> Option<&Realtime> {
        self.timing.realtime.as_ref()
    }

    /// When the cell runs as processes in real time, asks the machine for priority and for locked memory, and runs
    /// without them if the machine does not permit it. For a cell without a file this replaces `[realtime]` with
    /// `permission = "best effort"`.
    #[must_use]
    pub fn prefer_real_time(self) -> Cell {
        self.ask_for(Some(Realtime::PREFERRED))
    }

    /// Sets what its processes ask of the machine.
    pub fn ask_for(mut self, realtime: Option<Realtime>) -> Cell {
        self.timing.realtime = realtime;
        self
    }

    /// Records every step to a file: the demands and motions of the robots, the readings of the sensors, the orders of
    /// the MP. The crate that records makes the [`Recording`].
    #[must_use]
    pub fn record(mut self, recording: Recording) -> Cell {
        self.watching.recorder = recording.recorder().or(self.watching.recorder);
        self.watching.recording = Some(recording);
        self
    }

    /// Sets the recorder that writes the recording, unless the cell has one already.
    #[must_use]
    pub fn recorded_by(mut self, recorder: &'static dyn Recorder) -> Cell {
        self.watching.recorder.get_or_insert(recorder);
        self
    }

    /// Records to this file: what the cell was asked to record, or else everything.
    #[must_use]
    pub fn record_to(mut self, file: &Path) -> Cell {
        let asked = self.watching.recording.take().unwrap_or_else(|| Recording::to(file));
        self.watching.recording = Some(asked.with_file(file));
        self
    }

    /// Draws the images that sensors hand over ([`Frames`](crate::sensor::Frames)) as PNG files, in a folder of each sensor's
    /// own in this one. A cell that is recorded has its frames beside the recording as well: those of the sensor `camera` of
    /// `run.mcap` are in `run.camera.mcap`.
    #[must_use]
    pub fn frames_to(mut self, folder: impl Into<PathBuf>) -> Cell {
        self.watching.frames = Some(folder.into());
        self
    }

    /// Records nothing, and shows nothing to programs of others.
    pub fn unrecorded(mut self) -> Cell {
        self.watching.recording = None;
        self.watching.subscriptions.clear();
        self.watching.frames = None;
        self
    }

    /// Requires a successful dry run before every run in real time.
    pub const fn demand_dry_run(mut self) -> Cell {
        self.timing.dry_run = true;
        self
    }

    /// Whether every run in real time needs a dry run before it.
    pub const fn demands_dry_run(&self) -> bool {
        self.timing.dry_run
    }

    /// The recording that its run makes, if any.
    pub const fn recording(&self) -> Option<&Recording> {
        self.watching.recording.as_ref()
    }

    /// What writes the recording.
    pub fn recorder(&self) -> Option<&'static dyn Recorder> {
        self.watching.recorder
    }

    /// Shows an observer what happens in the cell's processes.
    pub fn observed_by(mut self, observer: Rc<dyn StepObserver>) -> Cell {
        self.watching.observers.push(observer);
        self
    }

    /// Shows an observer what happens in the processes of the cell and of all lower cells. What a robot or a process is called says in which
    /// one: `press.arm`, `mp press`. A sensor has its name in the cell of the process that has read it.
    pub fn observed_in_all_cells_by(mut self, observer: Rc<dyn StepObserver>) -> Cell {
        self.watching.of_all.push(observer);
        self
    }

    /// Shows the cell to programs of others.
    #[must_use]
    pub fn shown_to(mut self, subscription: impl Subscription + 'static) -> Cell {
        self.watching.subscriptions.push(Rc::new(subscription));
        self
    }

    /// Begins to [show](Cell::shown_to) what happens in this process of it, or in all of them.
    pub fn begin_subscriptions(&self, process: Option<ProcessId>, clock: Clock) -> Vec<Rc<dyn RunRecord>> {
        // A cell without subscribers needs no layout for it.
        if self.watching.subscriptions.is_empty() {
            return Vec::new();
        }
        self.watching.begin_subscriptions(process, &self.layout().without_lower_cells(), clock)
    }

    /// Shows an observer what a picture needs besides the robots: every [`Step`](crate::observe::step_observer::StepEvent::Step) of the MP,
    /// every [`Reading`](crate::observe::step_observer::StepEvent::Reading) that a process collects, the
    /// [`Signals`](crate::observe::step_observer::StepEvent::Signals) of every robot. On the memory link it sees everything else, too.
    ///
    /// Where the cell runs as processes and the program [watches](Self::watched_in_plant), it is shown these on a thread of the
    /// plant: what one process shows in its order, but what several show in any order, and in real time not all of it if
    /// the plant is slow.
    #[must_use]
    pub fn shown_to_picture(mut self, observer: SharedStepObserver) -> Cell {
        self.watching.of_picture.push(observer);
        self
    }

    /// Takes the observers of its [picture](Cell::shown_to_picture).
    pub fn take_observers_of_picture(&mut self) -> Vec<SharedStepObserver> {
        core::mem::take(&mut self.watching.of_picture)
    }

    /// Replaces drives, sensors and the operator by a recording of this cell, which gives their answers.
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
