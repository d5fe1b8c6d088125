//! ECP: the effector control process, the task for one robot.
//!
//! In: the MP's orders, one per step. Out: demands to the EDP, and in each reply to the MP the robot's image
//! and how fast the rate may change. The MP paces: a step of an ECP begins with an order, and its answer ends
//! it. [`orders`] is the MP's side of it, [`driver`] the EDP's, [`motion`] the Move between them and [`waiting`]
//! the Wait; [`instruction`] is what holds them together, [`latch`] what a fault does, [`jogging`] what a person who jogs the robot
//! does, [`process`] what is round the program.
//! Here are the public `Ecp` and standstill.

mod driver;
mod instruction;
mod jogging;
mod latch;
mod motion;
pub(in crate::control) mod orders;
mod process;
#[cfg(test)]
mod tests;
mod waiting;

use crate::link::Host;
use core::time::Duration;
use std::rc::Rc;

use crate::control::overruns::Overruns;
use crate::control::recorded::{Recorded, recorded};
use crate::control::replay::RecordedRobot;
use crate::control::sensing::Sensing;
use crate::link::message::{RequestKind, flag};
use crate::link::{Client, Server};
#[cfg(doc)]
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::image::{RobotImage, Sensor};
use crate::model::instruction::{Instruction, Level as InstructionLevel};
use crate::model::list::{PayloadType, SensorHandle};
use crate::model::load::Tool;
use crate::model::name::Name;
use crate::model::named::{CellNames, SignalNames};
use crate::model::payload::{Payload, Trigger};
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::model::signals::{Input, Level, Output};
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;
use crate::observe::step_observer::{StepEvent, StepObservers};
use crate::operator::state::InstructionKind;
use crate::safety::limits::rates::standing_margin;
use crate::safety::rate::RateMargin;

use driver::DriverPort;
use instruction::OfInstruction;
use jogging::Jogging;
use orders::{Orders, Phase};

/// An effector control process: what a robot's program is given.
pub struct Ecp<'w, R: Robot> {
    process: ProcessId,
    host: Host<'w>,
    orders: Orders,
    driver: DriverPort<R>,
    sensing: Sensing,
    pace: Pace,
    overruns: Overruns,
    refusals: u32,
    /// What the MP has been told, or will be, to stop the robot for on its path.
    trouble: Trouble,
    jogging: Jogging<R>,
    /// Where instructions and late steps are shown.
    step_observers: StepObservers,
    /// Where the instructions of a user's program are shown to observers; those of a transparent ECP are the MP's.
    activity: Option<Shown<Activity>>,
    /// The program's present instruction, and how many it has begun.
    at_work: AtWork,
    /// The robot's part of the run that is replayed.
    replayed: Option<Rc<RecordedRobot>>,
    signals: Rc<SignalNames>,
    named: Rc<CellNames>,
}

/// How far a program has come, for observers and for the faults that it meets.
#[derive(Clone, Copy, Default)]
struct AtWork {
    instructions: u64,
    doing: InstructionKind,
    by: TypeName,
}

/// What is wrong while demands are sound.
#[derive(Clone, Debug, PartialEq)]
enum Trouble {
    None,
    /// Not reported yet.
    New(Fault),
    /// Reported: the MP lets path time slow down.
    Told(Fault),
}

/// The times that an ECP goes by.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The cell's step \[ns\].
    pub period: Nanos,
    /// The time into a step after which its demand would come too late for the EDP's ticks \[ns\].
    pub grace: Nanos,
    /// Steps after which a robot that was told to stop must stand.
    pub stop_steps: u64,
}

/// Refused calls after which a program that ignores a latched fault, or the end of the cell, is ended.
pub(crate) const MAX_REFUSALS: u32 = 10_000;

impl<'w, R: Robot> Ecp<'w, R> {
    pub(crate) fn new(
        (process, model): (ProcessId, Rc<R>),
        host: Host<'w>,
        mp: Box<dyn Server>,
        edp: Box<dyn Client>,
        sensing: Sensing,
        pace: Pace,
        replayed: Option<Rc<RecordedRobot>>,
    ) -> Self {
        Ecp {
            process,
            host,
            orders: Orders::new(mp),
            driver: DriverPort::new(edp, sensing.timeout),
            step_observers: sensing.step_observers.clone(),
            sensing,
            overruns: Overruns::new(Duration::from_nanos(pace.period)),
            pace,
            refusals: 0,
            trouble: Trouble::None,
            jogging: Jogging::of(model),
            activity: None,
            at_work: AtWork::default(),
            replayed,
            signals: Rc::default(),
            named: Rc::default(),
        }
    }

    /// The same with names of the robot's inputs and outputs, and of the cell's frames and tools.
    pub(crate) fn with_names(mut self, signals: Rc<SignalNames>, named: Rc<CellNames>) -> Self {
        (self.signals, self.named) = (signals, named);
        self
    }

    /// The same, which shows the instructions of its program: to observers by `activity`.
    pub(crate) fn showing_instructions(self, activity: Option<Shown<Activity>>) -> Self {
        // From now on this process says what it is.
        activity.iter().for_each(|activity| activity.set(Activity::default()));
        Ecp { activity, ..self }
    }

    /// Shows observers at the run that an instruction of the program begins, or is over.
    fn show_instruction(&mut self, doing: InstructionKind, by: TypeName) {
        let Some(activity) = &self.activity else { return };
        let begun = u64::from(doing != InstructionKind::Nothing);
        self.at_work = AtWork { instructions: self.at_work.instructions + begun, doing, by };
        activity.set(activity.get().changed(doing, by));
        self.host.console.show_ecp(&self.shown_state());
        let shown = StepEvent::Instruction { step: self.orders.header().step, doing, by };
        self.step_observers.show(self.host.waiter.now(), &shown, &[]);
    }

    /// The instruction of the program that is at work, as a fault names it; those of a transparent ECP are the MP's.
    fn instruction(&self) -> Option<Instruction> {
        let AtWork { instructions, doing, by } = self.at_work;
        Instruction::new(instructions, doing, InstructionLevel::Ecp, by)
    }

    /// The robot's image at the end of the last motion or Wait.
    #[must_use]
    pub const fn image(&self) -> &RobotImage<R> {
        &self.driver.image
    }

    /// The input of the robot's controller that the cell calls `name`: `bool` of a digital one, `f64` of an analog one. Its value
    /// is looked up in the [image](Self::image), [`RobotImage::value`].
    ///
    /// # Errors
    /// `Config`: the robot has no input of that name and type.
    pub fn input<T: Level>(&self, name: &str) -> Result<Input<T>, Fault> {
        self.signals.input(self.robot_name(), name).map_err(|fault| fault.in_process(self.process))
    }

    /// The output of the robot's controller that the cell calls `name`: `bool` of a digital one, `f64` of an analog one. A demand
    /// tells it a value, [`Demand::with_output`].
    ///
    /// # Errors
    /// `Config`: the robot has no output of that name and type.
    pub fn output<T: Level>(&self, name: &str) -> Result<Output<T>, Fault> {
        self.signals.output(self.robot_name(), name).map_err(|fault| fault.in_process(self.process))
    }

    fn robot_name(&self) -> &str {
        self.process.name.as_ref().map_or("", Name::as_str)
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
        let values = self.replayed.as_ref().map(|robot| &robot.values);
        recorded(name, self.orders.header().step, values, show, compute)
            .map_err(|fault| fault.in_process(self.process))
    }

    /// The handle of a virtual sensor of this robot, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives this ECP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        self.sensing.handle(name, S::Configuration::default(), self.process)
    }

    /// Does the ECP's part of one instruction of the MP: `program` is run with the first order's value when the
    /// MP starts an instruction of this payload; its return means *finished*.
    ///
    /// With an `enum` payload the program may finish early and then holds until the MP ends the instruction;
    /// with a `struct` payload finishing early is a fault.
    ///
    /// # Errors
    /// What `program` returned, except that an instruction that the MP has ended is no fault. `PayloadMismatch`
    /// when the MP's instruction has orders of another type: then nothing has moved.
    pub fn serve<P: Payload>(
        &mut self,
        program: impl FnOnce(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        self.serve_orders(PayloadType::of::<P>(), program)
    }

    /// The same for orders that the MP calls `payload`, and that are read as a `P`.
    pub(crate) fn serve_orders<P: Payload>(
        &mut self,
        payload: PayloadType,
        program: impl FnOnce(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        self.check_latch()?;
        if let Some(served) = self.orders.payload() {
            let text = if served.id == PayloadType::of::<Trigger>().id {
                "the cell has no MP program, whose orders could be served: leave `serve` out, or give it one"
            } else {
                "serve inside serve: an ECP serves one instruction at a time"
            };
            return Err(self.fail(Fault::thrown(text)));
        }
        self.await_start(payload)?;
        let first = P::get(self.orders.words());
        let first = first.map_err(|_| self.fail(Fault::new(FaultKind::Message)))?;
        self.orders.phase = Phase::Serving;
        let outcome = program(self, first);
        self.finish(outcome)
    }

    /// Serves one instruction after another, each as [`serve`](Self::serve) does, until the MP's program is over.
    ///
    /// # Errors
    /// As [`serve`](Self::serve), except that the end of the MP's program is no fault here. An abort is one: a program whose
    /// MP goes on after it calls this again.
    pub fn serve_all<P: Payload>(
        &mut self,
        mut program: impl FnMut(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        loop {
            if let Err(fault) = self.serve(&mut program) {
                let closed = fault.is_orderly() && fault.kind() == FaultKind::CellClosed;
                // Between two instructions, not in one that was opened.
                return if closed && self.orders.phase == Phase::Idle { Ok(()) } else { Err(fault) };
            }
        }
    }

    /// Answers the open order.
    fn reply(&mut self, flags: u32) {
        if !self.driver.moving {
            self.stand_beside_rate();
        }
        self.orders.reply(flags | self.jog_flags(), self.driver.reply());
    }

    /// A robot in no motion, which stands or brakes by its own law, bounds the changes of the rate by what it may begin in the
    /// next step, at the rate that all have now: not at that of its last motion. Once its program is over, by nothing.
    fn stand_beside_rate(&mut self) {
        let header = self.orders.header();
        let rate = if header.duration > 0.0 { header.dt / header.duration } else { 0.0 };
        let margin = match self.orders.phase {
            Phase::Finished => RateMargin::UNLIMITED,
            Phase::Idle | Phase::Started | Phase::Serving | Phase::Latched(_) => {
                standing_margin(self.jogging.model().limits(), rate, self.pace.period as f64 * 1e-9)
            }
        };
        let most = self.driver.reply().header.rate_margin.most;
        self.driver.set_rate_margin(RateMargin { most, ..margin });
    }

    /// Answers the open order, with the robot's image if the EDP gave it in this step; or with what is wrong, once.
    fn reply_with_state(&mut self) {
        if let Trouble::New(fault) = &self.trouble {
            let fault = fault.clone();
            self.orders.reply_trouble(&fault, self.driver.reply());
            self.trouble = Trouble::Told(fault);
            return;
        }
        self.reply(self.driver.reply().header.flags & flag::STATE);
    }

    /// One exchange with the EDP.
    fn ask(&mut self, kind: RequestKind, flags: u32) -> Result<(), Fault> {
        let asked = self.driver.ask(kind, flags, self.orders.header(), self.host.waiter);
        asked.map_err(|fault| self.fail(fault))
    }

    /// Answers a step in which the robot stands. One that a blend left moving brakes, unless this very order
    /// hands it over; it has not left the instruction before it stands.
    fn hold(&mut self, mut flags: u32) -> Result<(), Fault> {
        let brakes = self.driver.moving && !self.orders.hands_over();
        if brakes || self.orders.is(flag::WANT_STATE) || flags & flag::ENDED != 0 {
            let kind = if brakes { RequestKind::Brake } else { RequestKind::Query };
            self.ask(kind, flag::WANT_STATE)?;
            flags |= self.driver.reply().header.flags & flag::STATE;
        }
        if brakes {
            self.stand_beside_rate();
            self.driver.moving = !self.driver.is_at_standstill();
            flags &= if self.driver.moving { !flag::ENDED } else { !0 };
        }
        self.reply(flags);
        Ok(())
    }

    /// Brings the robot to a standstill when a motion left it moving: the braking tail.
    fn settle(&mut self) -> Result<(), Fault> {
        while self.driver.moving {
            // Without an open order there is no step to brake in.
            self.next_of_instruction()?;
            self.ask(RequestKind::Brake, flag::WANT_STATE)?;
            if self.driver.is_at_standstill() {
                self.driver.moving = false;
            } else {
                self.stand_beside_rate();
                self.reply(flag::STATE);
            }
        }
        Ok(())
    }

    /// The same, unless the MP's END hands the moving robot over to its next instruction.
    fn settle_unless_blending(&mut self) -> Result<(), Fault> {
        if self.orders.hands_over() { Ok(()) } else { self.settle() }
    }

    /// Whether a demand of the open order's step would miss the EDP's ticks, after what took place since `began`.
    fn is_late_since(&self, began: Nanos) -> bool {
        let now = self.host.waiter.now();
        let step = self.orders.header().step;
        let is_late = match &self.replayed {
            // The recorded run has found that out, and the time of a replay does not tell it.
            Some(recorded) => recorded.put_off.contains(&step),
            None => now > began && now >= step * self.pace.period + self.pace.grace,
        };
        if is_late {
            self.step_observers.show(now, &StepEvent::Late { step }, &[]);
        }
        is_late
    }

    fn check_payload(&mut self, read: PayloadType, reads: bool) -> Result<(), Fault> {
        match self.orders.payload() {
            Some(payload) if reads && payload.id != read.id => {
                let text =
                    format!("the step function reads `{}`, the order is `{}`", read.name, payload.name);
                Err(self.fail(Fault::new(FaultKind::PayloadMismatch).text(&text)))
            }
            Some(_) | None => Ok(()),
        }
    }
}
