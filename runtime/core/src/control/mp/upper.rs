//! The MP of a lower cell towards the MP above it: it is an ECP there, whose robot is the whole cell.
//!
//! In: the upper MP's orders, of which the first one of an instruction is the program's to serve; the path time in each of them.
//! Out: an answer as soon as an order has come, whatever the cell's own step is doing; what the orders ask of the MP's next
//! step: to slow down, to end, to stop, to leave the latch. What an order means in which phase is [`Phase::duty`]'s to say.
//!
//! The rate of path time is a product: the upper cell's rate and the own operator's speed. The own feed follows it within the
//! limits of its own robots.

use crate::control::ecp::orders::{Duty, Orders, Phase};
use crate::link::Server;
use crate::link::message::{Message, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::image::{IMAGE_WORDS, RobotImage};
use crate::model::list::PayloadType;
use crate::model::lower_cell::{CellStatus, LowerCell};
use crate::model::payload::Payload;
use crate::model::time::Nanos;
use crate::model::wire::{BadWords, WORDS, Wire};

/// The message of the fault of a lower cell whose upper MP gives no orders.
pub(super) const SILENT: &str = "no orders from the upper MP: robots stop on their paths";

/// What the program of the cell does with the next START.
#[derive(Clone, Copy)]
enum Program {
    /// It computes, or comes to its first `serve`: the order waits.
    Elsewhere,
    /// It awaits orders of this type.
    Awaits(PayloadType),
    /// It is over.
    Over,
}

/// The instruction of the upper MP that is open.
#[derive(Default)]
struct Served {
    /// The words of its first order, until the program takes them.
    first: Option<[u64; WORDS]>,
    /// The order that ends it while the program is at work on it, or has ended it after that.
    ending: Option<OrderKind>,
    ended: Option<OrderKind>,
}

/// The path time of the upper cell, as its MP's last order says: its rate, 0 to 1, whether it is suspended, and whether the limit of
/// reduced speed is in force.
pub(super) struct PathTime {
    pub rate: f64,
    pub suspended: bool,
    pub reduced: bool,
}

/// The MP above, as this one sees it.
pub(crate) struct Upper {
    orders: Orders,
    /// This MP.
    process: ProcessId,
    /// For how long nothing may come while an instruction is open \[ns\].
    timeout: Nanos,
    /// When an order came last \[ns\].
    heard: Nanos,
    program: Program,
    served: Served,
    pub(super) path_time: PathTime,
    /// What the MP is to stop the cell for, once.
    wrong: Option<Fault>,
    /// Whether the upper MP stopped the cell: then its reset is this one's, too.
    stopped: bool,
    reset: bool,
    /// Whether the robots of a latched cell stand.
    stands: bool,
    /// What the cell's image says, among that whether the program has come to a `serve` since it began; the message that it goes with.
    status: CellStatus,
    state: Message,
}

impl Upper {
    pub fn new(port: Box<dyn Server>, process: ProcessId, timeout: Nanos) -> Upper {
        Upper {
            orders: Orders::new(port),
            process,
            timeout,
            heard: 0,
            program: Program::Elsewhere,
            served: Served::default(),
            path_time: PathTime { rate: 1.0, suspended: false, reduced: false },
            wrong: None,
            stopped: false,
            reset: false,
            stands: true,
            // A latched cell answers with its fault.
            status: CellStatus { ready: false, latched: false, suspended: false, rate: 0.0 },
            state: Message::empty(),
        }
    }

    /// What the image says of the cell from now on: whether it is suspended, and its rate of path time.
    pub const fn show(&mut self, suspended: bool, rate: f64) {
        (self.status.suspended, self.status.rate) = (suspended, rate);
    }

    /// Answers what has come. A START for which the program is not ready stays open.
    pub fn serve(&mut self, now: Nanos) {
        while let Some(order) = self.orders.poll() {
            self.heard = now;
            let header = self.orders.header();
            if header.duration > 0.0 {
                self.path_time.rate = (header.dt / header.duration).clamp(0.0, 1.0);
            }
            self.path_time.suspended = self.orders.is(flag::SUSPENDED);
            self.path_time.reduced = self.orders.is(flag::REDUCED);
            let duty = self.orders.duty(order);
            if duty == Duty::Open && matches!(self.program, Program::Elsewhere) {
                return;
            }
            self.answer(order, duty);
        }
    }

    fn answer(&mut self, order: OrderKind, duty: Duty) {
        match duty {
            Duty::Report => self.reply(0),
            Duty::Open => self.open(),
            Duty::Work => {
                if self.orders.phase == Phase::Started {
                    let mut words = [0; WORDS];
                    words[..self.orders.words().len()].copy_from_slice(self.orders.words());
                    self.served.first = Some(words);
                    self.orders.phase = Phase::Serving;
                }
                self.reply(0);
            }
            Duty::Rest => self.reply(flag::FINISHED),
            // It moves nothing yet, or nothing any more.
            Duty::End | Duty::Abort
                if self.served.first.take().is_some() || self.orders.phase == Phase::Finished =>
            {
                self.served.ended = Some(order);
                self.leave();
            }
            Duty::End | Duty::Abort => {
                self.served.ending.get_or_insert(order);
                self.reply(0);
            }
            Duty::StayOut => self.leave(),
            Duty::Stop => {
                self.stopped = true;
                self.fail(Fault::new(FaultKind::StoppedByCell).text("by the upper cell"));
            }
            Duty::Reset if self.stopped && !matches!(self.program, Program::Over) => {
                self.orders.reset();
                (self.status.ready, self.reset, self.stopped) = (false, true, false);
                self.reply(0);
            }
            // Its own operator resets a cell that has stopped for a cause of its own.
            Duty::Refuse | Duty::Reset => self.refuse(),
            // That operator has done so already.
            Duty::Foreign if order == OrderKind::Reset && self.orders.phase == Phase::Idle => self.reply(0),
            Duty::Foreign => {
                let text = format!("order {order:?} of the upper MP in phase {:?}", self.orders.phase);
                self.fail(Fault::new(FaultKind::Message).text(&text));
            }
        }
    }

    /// Acknowledges START, if the type of the orders is right.
    fn open(&mut self) {
        match self.program {
            Program::Awaits(payload) if payload.id == self.orders.header().payload => {
                self.served = Served::default();
                self.orders.start(payload);
                self.reply(flag::STATE);
            }
            Program::Awaits(payload) => {
                let text = format!("this cell serves orders of type `{}`", payload.name);
                self.fail(Fault::new(FaultKind::PayloadMismatch).text(&text));
            }
            Program::Over => {
                let text = "the program of this cell's MP is over; the upper MP starts another instruction";
                self.fail(Fault::thrown(text));
            }
            Program::Elsewhere => {}
        }
    }

    /// The cell has left the instruction, or stays out of it.
    fn leave(&mut self) {
        self.orders.phase = Phase::Idle;
        self.reply(flag::ENDED | flag::FINISHED);
    }

    /// Answers the open order.
    fn reply(&mut self, flags: u32) {
        let wanted = if self.orders.is(flag::WANT_STATE) { flag::STATE } else { 0 };
        if wanted != 0 {
            RobotImage::<LowerCell>::of_cell(self.status).put(&mut self.state.body);
            self.state.header.len = IMAGE_WORDS as u32;
        }
        self.say();
        self.orders.reply(flags | wanted, &self.state);
    }

    /// Answers the open order of a latched cell.
    fn refuse(&mut self) {
        self.say();
        if let Phase::Latched(fault) = &self.orders.phase {
            let fault = fault.clone();
            self.orders.reply_fault(&fault, &self.state);
        }
    }

    /// Latches what an order was wrong for, and answers it so. The MP stops the cell for it in its next step.
    fn fail(&mut self, fault: Fault) {
        let fault = fault.in_process(self.process).at_step(self.orders.header().step);
        self.latch(&fault);
        self.wrong = Some(fault);
        self.refuse();
    }

    /// What all answers say: whether the robots stand, and whether the cell is not ready for orders yet.
    fn say(&mut self) {
        let stands = match self.orders.phase {
            Phase::Idle | Phase::Started | Phase::Finished => true,
            Phase::Serving => false,
            Phase::Latched(_) => self.stands,
        };
        self.state.header.flags =
            if stands { flag::STANDSTILL } else { 0 } | if self.status.ready { 0 } else { flag::HOMING };
    }

    /// From now on every order is answered with the fault, until a reset.
    pub fn latch(&mut self, fault: &Fault) {
        if !matches!(self.orders.phase, Phase::Latched(_)) {
            self.orders.phase = Phase::Latched(fault.clone());
            (self.stands, self.reset) = (false, false);
        }
    }

    /// The robots of a latched cell stand.
    pub const fn stand(&mut self) {
        self.stands = true;
    }

    /// The cell has left its latch: its program begins anew.
    pub fn begin(&mut self) {
        self.orders.reset();
        (self.status.ready, self.stopped, self.reset, self.wrong) = (false, false, false, None);
        self.program = Program::Elsewhere;
    }

    /// The program is over: it serves nothing more.
    pub const fn be_over(&mut self) {
        self.program = Program::Over;
        self.status.ready = true;
    }

    /// Whether the upper MP resets the cell that it had stopped; told once.
    pub const fn take_reset(&mut self) -> bool {
        core::mem::replace(&mut self.reset, false)
    }

    /// Whether the upper MP has stopped the cell, and not reset it.
    pub const fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// What the cell is to be stopped for; told once.
    pub const fn take_wrong(&mut self) -> Option<Fault> {
        self.wrong.take()
    }

    /// Whether an instruction is open and its orders have not come for too long.
    pub const fn is_silent(&self, now: Nanos) -> bool {
        let open = matches!(self.orders.phase, Phase::Started | Phase::Serving | Phase::Finished);
        open && now > self.heard + self.timeout
    }

    /// Lets START come, for orders of this type.
    pub const fn await_start(&mut self, payload: PayloadType) {
        self.program = Program::Awaits(payload);
        self.status.ready = true;
    }

    /// The first order of the instruction that has begun.
    pub fn take_first<P: Payload>(&mut self) -> Option<Result<P, BadWords>> {
        let words = self.served.first.take()?;
        self.program = Program::Elsewhere;
        Some(P::get(&words))
    }

    /// The program has served, and all robots stand.
    pub fn finish(&mut self) {
        if self.orders.phase == Phase::Serving {
            self.orders.phase = Phase::Finished;
        }
        self.served.ending = None;
    }

    /// How the upper MP has ended the instruction, when that is over.
    pub const fn take_ended(&mut self) -> Option<OrderKind> {
        self.served.ended.take()
    }

    /// Whether no instruction is open.
    pub fn is_idle(&self) -> bool {
        self.orders.phase == Phase::Idle
    }

    /// Whether the program is at work on an instruction.
    pub fn is_serving(&self) -> bool {
        self.orders.phase == Phase::Serving && self.served.first.is_none()
    }

    /// How an instruction ends that the program is at work on, if the upper MP has ended it.
    pub fn ending(&self) -> Option<Fault> {
        let aborts = self.served.ending? == OrderKind::Abort;
        let kind = if aborts { FaultKind::Aborted } else { FaultKind::InstructionEnded };
        Some(Fault::orderly(kind))
    }
}
