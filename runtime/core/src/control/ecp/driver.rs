//! The EDP's side of an ECP: sends requests, keeps the last reply and the robot's image.
//!
//! In: a request, and the order whose step it belongs to. Out: the EDP's reply, or its fault.

use crate::control::state_words::StateWords;
use crate::link::message::{Header, Kind, Message, RequestKind, flag};
use crate::link::timeout::AnswerTimeout;
use crate::link::{Client, Waiter};
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::RobotImage;
use crate::model::robot::Robot;
use crate::model::wire::Wire;
use crate::safety::rate::RateMargin;

/// What the MP's orders tell an EDP by their flags.
const PASSED_ON: u32 = flag::WANT_STATE
    | flag::SUSPENDED
    | flag::TOGETHER
    | flag::RECOVER
    | flag::REDUCED
    | flag::ABORTED
    | flag::UNANSWERED;

/// One robot's EDP as its ECP sees it.
pub(super) struct DriverPort<R: Robot> {
    port: Box<dyn Client>,
    request: Message,
    /// Words of the demand in it.
    demanded: u32,
    reply: Message,
    /// The robot's image in the last reply that had one.
    pub image: RobotImage<R>,
    /// Whether the last demand may have left the robot moving: then somebody has to brake it.
    pub moving: bool,
    timeout: AnswerTimeout,
}

impl<R: Robot> DriverPort<R> {
    pub fn new(port: Box<dyn Client>, timeout: AnswerTimeout) -> Self {
        DriverPort {
            port,
            request: Message::empty(),
            demanded: 0,
            reply: Message::empty(),
            image: RobotImage::unknown(),
            moving: false,
            timeout,
        }
    }

    /// The EDP's last reply.
    pub const fn reply(&self) -> &Message {
        &self.reply
    }

    /// Says how fast the rate of path time may change, in the place of what the EDP said last.
    pub const fn set_rate_margin(&mut self, margin: RateMargin) {
        self.reply.header.rate_margin = margin;
    }

    /// Whether the EDP said last that the robot stands.
    pub const fn is_at_standstill(&self) -> bool {
        self.reply.is(flag::STANDSTILL)
    }

    /// The robot's measured state in the last reply, as a sensor's order carries it.
    pub fn effector_state(&self) -> Option<StateWords<'_>> {
        StateWords::of(&self.reply)
    }

    /// Writes the demand of the next request, and its step's path time \[s\].
    pub fn set_demand(&mut self, demand: &Demand<R>, dt: f64) {
        demand.put(&mut self.request.body);
        self.demanded = demand.used() as u32;
        self.request.header.dt = dt;
    }

    /// One exchange for the step of an order. The MP's wish for the robot's image is this process's wish.
    ///
    /// # Errors
    /// The EDP's fault; `PeerLost` when it does not answer; `CellClosed`.
    pub fn ask(
        &mut self,
        kind: RequestKind,
        flags: u32,
        order: &Header,
        waiter: &dyn Waiter,
    ) -> Result<(), Fault> {
        let header = &mut self.request.header;
        (header.kind, header.step, header.duration) = (Kind::Request(kind), order.step, order.duration);
        header.epoch = order.epoch;
        header.instruction = order.instruction;
        header.law = order.law;
        header.flags = flags | order.flags & PASSED_ON;
        // What is no demand has no path time, whatever the demand before it had.
        if kind == RequestKind::Demand {
            header.len = self.demanded;
        } else {
            (header.len, header.dt) = (0, 0.0);
        }
        self.port.send(&self.request);
        let mut waiting = self.timeout.begin(waiter);
        // An answer to a request that was given up does not answer this one.
        let to = |header: &Header| (header.epoch, header.step);
        while !(self.port.receive(&mut self.reply) && to(&self.reply.header) == to(&self.request.header)) {
            let goes_on = waiting.goes_on(&*self.port, waiter);
            if !goes_on.map_err(|_| Fault::orderly(FaultKind::CellClosed))? {
                if self.request.is(flag::RECOVER) {
                    // Drives that are opened again may take their time.
                    self.reply.header.flags |= flag::RECOVERS;
                }
                return Err(Fault::new(FaultKind::PeerLost).text("no answer from the EDP"));
            }
        }
        if self.has_fault() {
            return Err(self.reply.fault());
        }
        if self.reply.is(flag::STATE) {
            self.image = RobotImage::get(self.reply.words()).map_err(|_| Fault::new(FaultKind::Message))?;
        }
        Ok(())
    }

    /// Whether the last reply was a fault: its flags count all the same.
    pub fn has_fault(&self) -> bool {
        self.reply.header.kind == Kind::Fault
    }
}
