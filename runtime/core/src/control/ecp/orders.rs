//! The MP's side of an ECP: takes orders, answers them, and knows where in an instruction the ECP is. The MP of a lower cell has
//! the same towards the MP above it.
//!
//! In: the MP's orders, one per step. Out: what each of them asks of the ECP in its present [`Phase`], and the
//! answers. An order stays open until it is answered: one that a generator's end left unused is the next
//! motion's first.
//!
//! ```text
//!           START             first STEP             program returns          END, ABORT
//!   Idle ───────────▶ Started ───────────▶ Serving ──────────────────▶ Finished ───────────▶ Idle
//!     ▲                  │ END, ABORT         a fault of this robot or of the cell, anywhere: ▶ Latched
//!     └──────────────────┘                                                       RESET: Latched ▶ Idle
//! ```

use crate::link::message::{Header, Kind, Message, OrderKind, flag};
use crate::link::{Closed, Server, Waiter};
use crate::model::fault::Fault;
use crate::model::list::PayloadType;
use crate::operator::jog::JogNow;
use crate::safety::latch::{Admission, Gate, GateRequest};

/// Where in the protocol of instructions an ECP is.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::control) enum Phase {
    /// No instruction is open.
    Idle,
    /// START has been acknowledged; the first order is to come.
    Started,
    /// The program works on the instruction.
    Serving,
    /// The program has returned; the robot stands until the MP ends the instruction.
    Finished,
    /// A fault: every order is answered with it.
    Latched(Fault),
}

/// What an order asks of an ECP in a phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::control) enum Duty {
    /// Answer with the robot's state.
    Report,
    /// Acknowledge START.
    Open,
    /// Do a step of the program.
    Work,
    /// Hold: the program has finished.
    Rest,
    /// Leave the instruction, which ends.
    End,
    /// Leave the instruction, which the operator aborts.
    Abort,
    /// Hold: the instruction has been left already.
    StayOut,
    /// Stop and latch.
    Stop,
    /// Answer with the fault that is latched.
    Refuse,
    /// Leave the latch; the program starts again.
    Reset,
    /// An order that has no place here: the two sides disagree about where they are.
    Foreign,
}

impl Phase {
    /// What an order asks for; `same` says whether it belongs to the instruction that was opened last.
    #[inline]
    pub const fn duty(&self, order: OrderKind, same: bool) -> Duty {
        use OrderKind as O;
        match (self, order) {
            (Phase::Latched(_), O::Reset) => Duty::Reset,
            (Phase::Latched(_), _) => Duty::Refuse,
            (Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished, O::Stop) => Duty::Stop,
            (Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished, O::Query) => Duty::Report,
            // Ends are repeated until every ECP has left, and brakes until every robot stands.
            (Phase::Idle, O::End | O::Abort | O::Brake) => Duty::StayOut,
            (Phase::Idle, O::Start) => {
                if same {
                    Duty::Foreign
                } else {
                    Duty::Open
                }
            }
            (Phase::Idle, O::Step) => Duty::Foreign,
            (Phase::Started | Phase::Serving, O::Step) if same => Duty::Work,
            (Phase::Started, O::End | O::Abort) if same => Duty::StayOut,
            (Phase::Serving | Phase::Finished, O::End) if same => Duty::End,
            (Phase::Serving | Phase::Finished, O::Abort) if same => Duty::Abort,
            (Phase::Finished, O::Step) if same => Duty::Rest,
            (
                Phase::Started | Phase::Serving | Phase::Finished,
                O::Start | O::Step | O::End | O::Abort | O::Brake,
            )
            // A robot that was not stopped is not reset.
            | (Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished, O::Reset) => Duty::Foreign,
        }
    }
}

/// The orders of the MP, and the phase that they have led to.
pub(in crate::control) struct Orders {
    port: Box<dyn Server>,
    order: Message,
    /// The kind of the order that is to be answered.
    open: Option<OrderKind>,
    /// What the last order says of jogging.
    jog: Option<JogNow>,
    answer: Message,
    pub phase: Phase,
    /// Of the epoch that orders must be of.
    gate: Gate,
    /// The type of the orders of the instruction opened last, and its ordinal.
    payload: Option<PayloadType>,
    instruction: u32,
}

impl Orders {
    pub fn new(port: Box<dyn Server>) -> Self {
        Orders {
            port,
            order: Message::empty(),
            open: None,
            jog: None,
            answer: Message::empty(),
            phase: Phase::Idle,
            gate: Gate::default(),
            payload: None,
            instruction: 0,
        }
    }

    /// Waits for an order, unless one is open. Orders of another epoch are not taken.
    #[inline]
    pub fn receive(&mut self, waiter: &dyn Waiter) -> Result<OrderKind, Closed> {
        loop {
            if let Some(open) = self.open {
                return Ok(open);
            }
            if !self.look() {
                waiter.wait(None)?;
            }
        }
    }

    /// The order that is open, without waiting for one. A new one takes the place of one that was not answered: nobody waits
    /// for that answer any more.
    pub fn poll(&mut self) -> Option<OrderKind> {
        self.look();
        self.open
    }

    /// Whether anything has come; an order that may be taken is open then.
    #[inline]
    fn look(&mut self) -> bool {
        let has_come = self.port.receive(&mut self.order);
        if has_come {
            self.open = match self.order.header.kind {
                Kind::Order(kind) => self.admit(kind).then_some(kind),
                // Nobody but an MP is at the other end of this port.
                Kind::Request(_) | Kind::Command | Kind::Read | Kind::Reply | Kind::Fault => None,
            };
            self.jog = None;
            if self.order.is(flag::JOG) {
                self.take_jog();
            }
        }
        has_come
    }

    /// Takes what the order says of jogging from behind its own words. What cannot be read asks for nothing.
    #[cold]
    fn take_jog(&mut self) {
        let own = self.order.words().len().saturating_sub(JogNow::WORDS);
        self.jog = JogNow::get(&self.order.words()[own..]).ok();
        self.order.header.len = own as u32;
    }

    /// What the last order asks of the robot that a person jogs.
    #[inline]
    pub const fn jog(&self) -> Option<&JogNow> {
        self.jog.as_ref()
    }

    /// Whether an order is one of this epoch, or begins it. What it asks for is then the phase's to say.
    #[inline]
    fn admit(&mut self, kind: OrderKind) -> bool {
        let gate = if matches!(self.phase, Phase::Latched(_)) { self.gate.closed() } else { self.gate };
        // The EDP knows whether the robot stands: it is asked before the phase changes.
        let (gate, admission) = gate.meet(self.order.header.epoch, asked(kind), true);
        self.gate = gate;
        admission != Admission::Ignored
    }

    /// Leaves the latch: no instruction is open.
    pub fn reset(&mut self) {
        self.phase = Phase::Idle;
        self.payload = None;
    }

    /// The kind of the order that is to be answered.
    pub const fn open(&self) -> Option<OrderKind> {
        self.open
    }

    /// What an order of that kind asks for.
    #[inline]
    pub fn duty(&self, order: OrderKind) -> Duty {
        self.phase.duty(order, self.order.header.instruction == self.instruction)
    }

    /// The head of the last order.
    pub const fn header(&self) -> &Header {
        &self.order.header
    }

    /// The body of the last order.
    #[inline]
    pub fn words(&self) -> &[u64] {
        self.order.words()
    }

    /// Whether the last order has a flag.
    pub const fn is(&self, flag: u32) -> bool {
        self.order.is(flag)
    }

    /// Whether the open order ends an instruction while moving: the next one takes over in this very step.
    #[inline]
    pub fn hands_over(&self) -> bool {
        self.open == Some(OrderKind::End) && self.order.is(flag::BLEND)
    }

    /// Whether the MP has ended the instruction, and by which order: the program has not left it yet.
    #[inline]
    pub const fn ended_by(&self) -> Option<OrderKind> {
        match self.open {
            Some(kind @ (OrderKind::End | OrderKind::Abort)) => Some(kind),
            Some(
                OrderKind::Query
                | OrderKind::Start
                | OrderKind::Step
                | OrderKind::Brake
                | OrderKind::Stop
                | OrderKind::Reset,
            )
            | None => None,
        }
    }

    /// Opens the instruction that START announced.
    pub fn start(&mut self, payload: PayloadType) {
        self.payload = Some(payload);
        self.instruction = self.order.header.instruction;
        self.phase = Phase::Started;
    }

    /// The type of the open instruction's orders.
    pub const fn payload(&self) -> Option<PayloadType> {
        match self.phase {
            Phase::Started | Phase::Serving | Phase::Finished => self.payload,
            Phase::Idle | Phase::Latched(_) => None,
        }
    }

    /// Answers the open order. With `flag::STATE` the image of the EDP's last reply goes with it.
    #[inline]
    pub fn reply(&mut self, flags: u32, driver: &Message) {
        let answer = &mut self.answer;
        answer.header.answer(&self.order.header);
        answer.header.kind = Kind::Reply;
        answer.header.flags =
            flags | driver.header.flags & (flag::STANDSTILL | flag::HOMING | flag::TOGETHER);
        answer.header.rate_margin = driver.header.rate_margin;
        answer.header.law = driver.header.law;
        answer.header.len = 0;
        if flags & flag::STATE != 0 {
            answer.header.len = driver.header.len;
            answer.body[..driver.words().len()].copy_from_slice(driver.words());
        }
        self.port.reply(answer);
        self.open = None;
    }

    /// Answers the open order of a robot that is to stop on its path for a fault.
    pub fn reply_trouble(&mut self, fault: &Fault, driver: &Message) {
        let answer = &mut self.answer;
        answer.header.answer(&self.order.header);
        answer.header.rate_margin = driver.header.rate_margin;
        answer.header.law = driver.header.law;
        answer.set_fault(fault);
        answer.header.kind = Kind::Reply;
        answer.header.flags = flag::TROUBLE;
        self.port.reply(answer);
        self.open = None;
    }

    /// Answers the open order with a fault, and whether the robot stands.
    pub fn reply_fault(&mut self, fault: &Fault, driver: &Message) {
        self.answer.header.answer(&self.order.header);
        self.answer.header.flags = driver.header.flags & (flag::STANDSTILL | flag::RECOVERS);
        self.answer.set_fault(fault);
        self.port.reply(&self.answer);
        self.open = None;
    }
}

/// What an order asks, as far as the gate is concerned.
const fn asked(order: OrderKind) -> GateRequest {
    match order {
        OrderKind::Start | OrderKind::Step => GateRequest::Move,
        OrderKind::Query | OrderKind::End | OrderKind::Abort | OrderKind::Brake => GateRequest::Look,
        OrderKind::Stop => GateRequest::Stop,
        OrderKind::Reset => GateRequest::Reset,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fault::FaultKind;

    #[test]
    fn every_order_has_one_meaning_in_every_phase() {
        use Duty::{Abort, End, Foreign, Open, Refuse, Report, Reset, Rest, StayOut, Stop, Work};
        use OrderKind as O;
        let orders = [O::Query, O::Start, O::Step, O::End, O::Abort, O::Brake, O::Stop, O::Reset];
        #[rustfmt::skip]
        let table = [
            // of this instruction:  Query   Start    Step     End      Abort    Brake    Stop  Reset
            (Phase::Idle,     true,  [Report, Foreign, Foreign, StayOut, StayOut, StayOut, Stop, Foreign]),
            (Phase::Started,  true,  [Report, Foreign, Work,    StayOut, StayOut, Foreign, Stop, Foreign]),
            (Phase::Serving,  true,  [Report, Foreign, Work,    End,     Abort,   Foreign, Stop, Foreign]),
            (Phase::Finished, true,  [Report, Foreign, Rest,    End,     Abort,   Foreign, Stop, Foreign]),
            // of another one:
            (Phase::Idle,     false, [Report, Open,    Foreign, StayOut, StayOut, StayOut, Stop, Foreign]),
            (Phase::Started,  false, [Report, Foreign, Foreign, Foreign, Foreign, Foreign, Stop, Foreign]),
            (Phase::Serving,  false, [Report, Foreign, Foreign, Foreign, Foreign, Foreign, Stop, Foreign]),
            (Phase::Finished, false, [Report, Foreign, Foreign, Foreign, Foreign, Foreign, Stop, Foreign]),
        ];
        for (phase, same, duties) in table {
            for (order, duty) in orders.into_iter().zip(duties) {
                assert_eq!(phase.duty(order, same), duty, "{order:?} in {phase:?}, same: {same}");
            }
        }
        let latched = Phase::Latched(Fault::new(FaultKind::Program));
        for (order, same) in orders.into_iter().flat_map(|order| [(order, true), (order, false)]) {
            let duty = if order == O::Reset { Reset } else { Refuse };
            assert_eq!(latched.duty(order, same), duty, "{order:?}");
        }
    }
}
