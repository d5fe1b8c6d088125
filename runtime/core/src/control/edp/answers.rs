//! The ECP's side of an EDP: its requests, whether they are of this epoch, and the answers.
//!
//! In: requests, faults. Out: which requests are taken, and the replies: once a fault is latched, that fault.

use crate::link::Server;
use crate::link::message::{Kind, Message, RequestKind, flag};
use crate::model::fault::{Fault, ProcessId};
use crate::safety::latch::{Admission, Gate, GateRequest};

/// What an EDP is asked and answers.
pub(super) struct Answers {
    process: ProcessId,
    port: Box<dyn Server>,
    /// Shut by a stop or a fault.
    pub gate: Gate,
    /// The first fault since the last reset.
    pub fault: Option<Fault>,
    /// The last request.
    pub request: Message,
    /// Its place among the requests of its step, from 0.
    pub nth: u32,
    /// The last reply.
    pub reply: Message,
    /// Whether the robot is recovering from a stop of its own.
    pub recovers: bool,
}

impl Answers {
    pub fn new(process: ProcessId, port: Box<dyn Server>) -> Self {
        Answers {
            process,
            port,
            gate: Gate::default(),
            fault: None,
            request: Message::empty(),
            nth: 0,
            reply: Message::empty(),
            recovers: false,
        }
    }

    /// The process that answers.
    pub const fn process(&self) -> ProcessId {
        self.process
    }

    /// Takes the next request, if one is there.
    #[inline]
    pub fn receive(&mut self) -> bool {
        let last = self.request.header.step;
        let is_there = self.port.receive(&mut self.request);
        if is_there {
            self.nth = if self.request.header.step == last { self.nth + 1 } else { 0 };
        }
        is_there
    }

    /// What the request asks for; `None` for a message that is no request.
    #[inline]
    pub const fn kind(&self) -> Option<RequestKind> {
        match self.request.header.kind {
            Kind::Request(request) => Some(request),
            Kind::Order(_) | Kind::Command | Kind::Read | Kind::Reply | Kind::Fault => None,
        }
    }

    /// Whether the request is taken, of a robot that stands or not.
    #[inline]
    pub fn admit(&mut self, at_standstill: bool) -> Admission {
        let asked = self.kind().map_or(GateRequest::Look, asked);
        let (gate, admission) = self.gate.meet(self.request.header.epoch, asked, at_standstill);
        self.gate = gate;
        admission
    }

    /// Shuts the gate: no demand is taken before the next reset.
    pub fn shut(&mut self) {
        self.gate = self.gate.closed();
    }

    /// Keeps the first fault, and shuts the gate. The fault, if it is the first.
    pub fn latch(&mut self, fault: Fault, step: u64) -> Option<&Fault> {
        self.shut();
        if self.fault.is_some() {
            return None;
        }
        self.fault = Some(fault.in_process(self.process).at_step(step));
        self.fault.as_ref()
    }

    /// Begins the reply to the request. Says whether it is the latched fault: then there is nothing to add.
    #[inline]
    pub fn begin_reply(&mut self, at_standstill: bool) -> bool {
        let reply = &mut self.reply;
        reply.header.answer(&self.request.header);
        let recovers = if self.recovers { flag::RECOVERS } else { 0 };
        reply.header.flags = recovers | if at_standstill { flag::STANDSTILL } else { 0 };
        if let Some(fault) = &self.fault {
            reply.set_fault(fault);
            return true;
        }
        reply.header.kind = Kind::Reply;
        reply.header.len = 0;
        false
    }

    /// Sends the reply.
    #[inline]
    pub fn send(&self) {
        self.port.reply(&self.reply);
    }
}

/// What a request asks, as far as the gate is concerned.
#[inline]
const fn asked(request: RequestKind) -> GateRequest {
    match request {
        RequestKind::Demand => GateRequest::Move,
        RequestKind::Query | RequestKind::Brake => GateRequest::Look,
        RequestKind::Stop => GateRequest::Stop,
        RequestKind::Reset => GateRequest::Reset,
    }
}
