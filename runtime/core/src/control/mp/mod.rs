//! MP: the master process, the coordinator of all robots.
//!
//! In: the ECPs' replies and its virtual sensors. Out: orders, one per robot of the instruction and step. Only the MP
//! sets the pace of the cell. [`clock`] says when a step begins and how much path time it has. [`exchange`] sends one
//! order to each robot and collects the replies; [`instruction`] opens, ends and stops instructions by such exchanges.
//! [`motion`] is Move and [`waiting`] is Wait; [`background`] is Move that goes on beside later instructions, [`progress`] how
//! far a generator has come. [`restart`] runs the program, and runs it again after a reset.
//! The MP of a lower cell [serves](serving) the one above it, which [`upper`] hears; [`lower`] is what a robot is that is a cell.
//! [`robots`] holds the ports of the ECPs, [`operating`] the operator's side, [`jogging`] the robot that a person jogs, [`stops`] the
//! causes of stops.

mod background;
mod clock;
mod exchange;
mod instruction;
mod jogging;
mod lower;
mod motion;
mod operating;
mod progress;
mod restart;
mod robots;
mod serving;
mod stops;
mod telling;
#[cfg(test)]
mod tests;
mod upper;
mod waiting;

use core::time::Duration;
use std::rc::Rc;

use crate::control::guard::Guard;
use crate::control::recorded::{Recorded, recorded};
use crate::control::replay::Script;
use crate::control::sensing::Sensing;
use crate::link::{Host, News, Sample};
#[cfg(doc)]
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::image::{RobotImage, Sensor};
use crate::model::list::{Owner, RobotHandle, RobotList, RobotsOf, SensorHandle, SensorList, SensorsOf};
use crate::model::load::Tool;
use crate::model::named::CellNames;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;
use crate::model::wire::Wire;
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;
use crate::observe::step_observer::{StepEvent, StepObservers};
use crate::operator::button::Button;
use crate::operator::state::InstructionKind;
use crate::operator::{CellState, Operator};
use crate::safety::rate::Feed;

use background::Background;
use clock::StepClock;
pub(crate) use jogging::AnyModel;
use jogging::Jogging;
use operating::Operating;
pub(crate) use operating::StepHook;
use robots::RobotPorts;
pub(crate) use robots::{RobotFacts, RobotPort};
use stops::Stops;
pub(crate) use upper::Upper;

/// The master process, as the coordinating program sees it.
pub struct Mp<'w> {
    process: ProcessId,
    host: Host<'w>,
    robots: RobotPorts,
    sensing: Sensing,
    background: Background,
    clock: StepClock,
    operating: Operating,
    jogging: Jogging,
    stops: Stops,
    step_observers: StepObservers,
    /// Steps after which a protective stop leaves the path.
    path_stop: u64,
    /// The recorded steps, in a replay.
    script: Option<Rc<Script>>,
    named: Rc<CellNames>,
    /// The MP above, of a lower cell.
    upper: Option<Upper>,
}

/// The times that an MP uses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MpTiming {
    /// Length of a step.
    pub period: Duration,
    /// The time into a step \[ns\] after which its demands would reach the EDPs too late for their servo periods.
    pub grace: Nanos,
    /// By how much the rate of path time may change in a second \[1/s\].
    pub rate_change: f64,
    /// Steps after which a protective stop leaves the path.
    pub path_stop: u64,
}

impl<'w> Mp<'w> {
    pub(crate) fn new(
        host: Host<'w>,
        robots: Vec<RobotPort>,
        sensing: Sensing,
        (operator, hook, activity): (Operator, Option<StepHook>, Shown<Activity>),
        timing: &MpTiming,
    ) -> Mp<'w> {
        Mp {
            process: ProcessId::MP,
            host,
            robots: RobotPorts::new(robots),
            step_observers: sensing.step_observers.clone(),
            sensing,
            background: Background::default(),
            clock: StepClock::new(timing.period, timing.grace, Feed::new(timing.rate_change)),
            operating: Operating::new(operator, hook, activity),
            jogging: Jogging::default(),
            stops: Stops::of(ProcessId::MP),
            path_stop: timing.path_stop,
            script: None,
            named: Rc::default(),
            upper: None,
        }
    }

    /// The same of a lower cell, whose MP is this process.
    pub(crate) fn under(mut self, upper: Upper, process: ProcessId) -> Self {
        self.upper = Some(upper);
        self.process = process;
        self.stops = Stops::of(process);
        self
    }

    /// The same with the frames and tools that the cell names.
    pub(crate) fn with_names(mut self, named: Rc<CellNames>) -> Self {
        self.named = named;
        self
    }

    /// Lets a guard watch over all robots.
    pub(crate) fn watch_by(&mut self, guard: Option<Guard>) {
        self.stops.guard = guard.map(|guard| guard.over(self.robots.iter().map(|robot| robot.facts.name)));
    }

    /// The handle of a robot, with its state. Each robot has only one handle: pass it on.
    ///
    /// # Errors
    /// `Config` when the cell has no robot of that name and kind, or when its handle is taken. Any other [`Fault`] is
    /// the reason why the robot cannot report its state.
    pub fn robot<R: Robot>(&mut self, name: &str) -> Result<RobotHandle<R>, Fault> {
        let mut handle = self.robots.handle(name).map_err(|fault| fault.in_process(self.process))?;
        let index = handle.index;
        // In a latched cell no robot is asked: the next instruction says why.
        if self.stops.latched.is_none() {
            self.ask(index).map_err(|fault| self.conclude(fault))?;
        }
        self.robots.each_image(&[index], &mut |_, words| {
            handle.image = RobotImage::get(words)?;
            Ok(())
        })?;
        Ok(handle)
    }

    /// Refuses handles of another cell.
    ///
    /// # Errors
    /// `Config` for the first one.
    fn check_handles<L: RobotList, V: SensorList>(
        &self,
        robots: &impl RobotsOf<L>,
        sensors: &impl SensorsOf<V>,
    ) -> Result<(), Fault> {
        let robots = Owner::refuse("robot", robots.stranger(self.robots.owner));
        robots.and_then(|()| self.sensing.check(sensors)).map_err(|fault| fault.in_process(self.process))
    }

    /// The handle of a virtual sensor of the MP, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives the MP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        self.sensing.handle(name, S::Configuration::default(), self.process)
    }

    /// A frame that the cell names, such as a table or a fixture: its pose in the world, `X_WU` \[m\].
    ///
    /// # Errors
    /// `Config`: the cell names no such frame.
    pub fn frame(&self, name: &str) -> Result<Pose, Fault> {
        self.named.frame(name).map_err(|fault| fault.in_process(self.process))
    }

    /// A tool that the cell names: where its tip is on the flange, for [`Demand::with_tool`], and what the flange carries with
    /// it, for [`Demand::with_load`].
    ///
    /// # Errors
    /// `Config`: the cell names no such tool.
    pub fn tool(&self, name: &str) -> Result<Tool, Fault> {
        self.named.tool(name).map_err(|fault| fault.in_process(self.process))
    }

    /// A value that a replay does not compute again: `compute` makes it, and it goes to the recording of the run, if there is one. In a
    /// replay it is what the recording says, or the fault with which `compute` ended then, and `compute` is not called. For
    /// plans, random choices, and what a file or a network said: all by which demands may differ.
    ///
    /// Call it between instructions, never in a step. A process must record the same names in the same order in the replay.
    ///
    /// # Errors
    /// Those of `compute`. `Config`: `name` is no name, the value is too long, or the recording has no such value here.
    pub fn recorded<T: Recorded>(
        &mut self,
        name: &str,
        compute: impl FnOnce() -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let show = |what: &StepEvent, words: &[u64]| {
            self.step_observers.show(self.host.waiter.now(), what, words);
        };
        let values = self.script.as_ref().map(|script| &script.values);
        recorded(name, self.clock.step(), values, show, compute)
            .map_err(|fault| fault.in_process(self.process))
    }

    /// Whether time stands still while the program computes, as under the virtual clock: then what it waits for cannot come too late.
    #[must_use]
    pub fn time_stands_still(&self) -> bool {
        self.host.waiter.stands_still()
    }

    /// Index of the step that has begun, counted since the cell started.
    #[must_use]
    pub const fn step(&self) -> u64 {
        self.clock.step()
    }

    /// Begins a step, unless no exchange has used the present one yet.
    fn begin_step(&mut self) -> Result<(), Fault> {
        self.keep_to_script();
        let Mp { clock, upper, host, .. } = self;
        let serve = || upper.iter_mut().for_each(|upper| upper.serve(host.waiter.now()));
        let begins = clock.begin(host.waiter, host.meter, serve);
        let begins = begins.map_err(|_| Fault::orderly(FaultKind::CellClosed))?;
        let heeded = self.heed_upper();
        if begins {
            self.count_own_time()?;
            self.operating.call_hook(self.clock.step());
            self.follow_script();
            self.hear_operator();
            match &self.script {
                Some(_) => self.replay_holds(),
                None => self.look_at_holds(),
            }
            self.clock.advance(self.wanted_rate(), self.is_suspended());
            self.tell_step()?;
            let epoch = self.robots.epoch;
            if self.host.console.is_there() {
                self.operating.show_jogs(self.jogged());
            }
            self.operating.show_step(self.state(), epoch, &self.clock, self.host.console);
            self.operating.show_suspension();
        }
        self.hear_news()?;
        self.tell_abort();
        heeded
    }

    /// Counts a step that began late because of the MP itself; too many of these are a fault.
    fn count_own_time(&mut self) -> Result<(), Fault> {
        let own_time = self.host.meter.own_time();
        self.host.meter.sample(Sample::Worked(own_time));
        if self.stops.latched.is_some() {
            return Ok(());
        }
        self.clock
            .count_own_time(own_time)
            .map_err(|fault| fault.in_process(self.process).at_step(self.clock.step()))
    }

    /// Carries out what the operator has pressed. Begins a protective stop if the operator asks for one, or if the
    /// launcher no longer supervises the cell.
    fn hear_operator(&mut self) {
        if self.host.console.is_there() {
            for kind in 0..Button::KINDS {
                // Each kind of button at most once.
                if let Some((number, button)) = self.host.console.pressed(kind) {
                    let (state, refused) = (self.state(), self.refuses(button));
                    self.operating.press(self.clock.step(), (kind, number, button), state, refused);
                }
            }
        }
        let asked = self.host.stops.asked();
        if asked != self.stops.asked {
            self.stops.asked = asked;
            self.operating.operator.protective_stop();
            let began = self.stops.latched.is_none().then_some(self.clock.step());
            self.host.stops.show_begun(asked, began);
        }
        if self.stops.latched.is_none() && !self.host.notices.is_supervised() {
            // A recording shows it as a stop of the operator, so that a replay stops in the same step.
            self.operating.stopping = true;
            self.stops.protect(Fault::of_launcher(), self.clock.step());
        }
        if self.stops.latched.is_none() && self.operating.take_protective_stop() {
            self.stops.protect(Fault::of_operator(), self.clock.step());
        }
    }

    /// The state of the cell, as an operator sees it.
    fn state(&self) -> CellState {
        cell_state(&self.stops, &self.operating.operator)
    }

    /// The rate of path time that is to be reached.
    fn wanted_rate(&self) -> f64 {
        let of_upper = self.upper.as_ref();
        if self.stops.protective.is_some() || of_upper.is_some_and(|upper| upper.ending().is_some()) {
            return 0.0;
        }
        self.operating.operator.wanted_rate() * of_upper.map_or(1.0, |upper| upper.path_time.rate)
    }

    /// Whether the operator has suspended the cell, or the one above it.
    fn is_suspended(&self) -> bool {
        self.operating.operator.is_suspended()
            || self.upper.as_ref().is_some_and(|upper| upper.path_time.suspended)
    }

    /// Whether the limit of reduced speed is in force, in this cell or in the one above it.
    fn is_reduced(&self) -> bool {
        self.operating.is_slow || self.upper.as_ref().is_some_and(|upper| upper.path_time.reduced)
    }

    /// Acts on events that the cell's messages do not tell of. If a process is lost in a latched cell, nothing more has
    /// to be done.
    fn hear_news(&mut self) -> Result<(), Fault> {
        match self.host.notices.news() {
            Some(News::Lost(process)) => {
                self.stops.gone.get_or_insert(process);
                if self.stops.latched.is_some() {
                    return Ok(());
                }
                Err(Fault::new(FaultKind::PeerLost).in_process(process).at_step(self.clock.step()))
            }
            // From the terminal: the program must end, and not start again.
            Some(News::Abort) => {
                self.operating.operator.abort();
                self.operating.operator.give_up();
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Ends an instruction with a fault. All robots stop and the fault is latched, unless it is an orderly end at
    /// standstill.
    fn conclude(&mut self, fault: Fault) -> Fault {
        let fault = fault.in_process(self.process).at_step(self.clock.step());
        let fault = self.stops.cause(fault).in_instruction(self.operating.instruction());
        self.operating.show_fault(&fault);
        // For example an abort, or a Wait that timed out: nothing is wrong with the cell.
        if fault.is_orderly() { fault } else { self.stop(fault) }
    }

    /// Runs one Move or Wait, which the operator can abort. The next instruction takes over the robots that this one
    /// leaves moving, and an abort that came too late for this one.
    fn instruction<T>(
        &mut self,
        doing: InstructionKind,
        by: TypeName,
        work: impl FnOnce(&mut Self) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        self.check_order()?;
        self.out_of_serve(doing, by, work)
    }

    /// The same of what a lower cell does without an order.
    fn out_of_serve<T>(
        &mut self,
        doing: InstructionKind,
        by: TypeName,
        work: impl FnOnce(&mut Self) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        self.check_latch()?;
        self.operating.show_instruction(doing, by);
        self.show_instruction(doing, by);
        if !self.robots.any_handed_over() && self.background.is_empty() {
            // The time that a program takes while its robots stand does not count as lateness.
            self.host.meter.own_time();
        }
        self.operating.operator.begin();
        let outcome = self.carry_out(work);
        self.jogging.end_move();
        self.operating.show_end(self.state(), self.host.console);
        self.show_instruction(InstructionKind::Nothing, by);
        outcome
    }

    /// Shows observers at the run that an instruction begins or is over.
    fn show_instruction(&self, doing: InstructionKind, by: TypeName) {
        let activity = &self.operating.activity;
        activity.set(activity.get().changed(doing, by));
        let shown = StepEvent::Instruction { step: self.clock.step(), doing, by };
        self.step_observers.show(self.host.waiter.now(), &shown, &[]);
    }

    fn carry_out<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        let outcome = work(self).map_err(|fault| self.conclude(fault));
        if outcome.is_ok() && self.robots.any_handed_over() {
            return outcome;
        }
        let outcome = match outcome {
            Ok(_) if self.is_ending() && !self.background.is_empty() => {
                let fault = self.rest_background().err().unwrap_or_else(|| self.ending());
                Err(self.conclude(fault))
            }
            outcome => outcome,
        };
        if !self.background.is_empty() {
            // Robots move: an abort that comes now is the next instruction's.
            return outcome;
        }
        let aborted = self.operating.operator.end();
        if outcome.is_ok() && (aborted || self.stops.protective.is_some()) {
            // An abort that came just as the instruction ended counts, too: the program must not go on.
            let fault = self.ending();
            return Err(self.conclude(fault));
        }
        outcome
    }

    /// Whether the open instruction is to end at standstill on its path, because of an abort or a protective stop.
    fn is_ending(&self) -> bool {
        let by_upper = self.upper.as_ref().is_some_and(|upper| upper.ending().is_some());
        self.stops.protective.is_some() || self.operating.operator.is_aborting() || by_upper
    }

    /// Whether the robots of an instruction that is to end on its path stand there.
    ///
    /// # Errors
    /// The cause of a protective stop that takes longer than the cell allows: the robots must then stop as for a fault.
    fn is_at_rest_on_path(&self) -> Result<bool, Fault> {
        if !self.is_ending() || self.clock.is_standing() {
            return Ok(self.is_ending());
        }
        self.stops.overdue(self.clock.step(), self.path_stop).map_or(Ok(false), Err)
    }

    /// The fault with which such an instruction ends.
    fn ending(&self) -> Fault {
        let by_this_cell = self.stops.protective.is_some() || self.operating.operator.is_aborting();
        let by_upper = self.upper.as_ref().and_then(Upper::ending).filter(|_| !by_this_cell);
        match by_upper {
            Some(fault) => fault.in_process(self.process).at_step(self.clock.step()),
            None => self.stops.ending(self.clock.step()),
        }
    }

    fn check_latch(&mut self) -> Result<(), Fault> {
        let Some(fault) = &self.stops.latched else { return Ok(()) };
        let fault = fault.clone();
        self.stops.refuse();
        // A refused call takes a step: a program that ignores the fault cannot stop the cell's time.
        self.clock.spend();
        self.begin_step()?;
        Err(fault)
    }
}

/// The state, as an operator sees it, of a cell with these causes of stops.
fn cell_state(stops: &Stops, operator: &Operator) -> CellState {
    if stops.protective.is_some() && stops.latched.is_none() { CellState::Stopping } else { operator.state() }
}
